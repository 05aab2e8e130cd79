// Sweep and prune: boxes that overlap also overlap along each axis, so only pairs that overlap along one axis are
// tested.
//
// The lower ends of all boxes are sorted along the axis on which the boxes are spread most. A box's candidates are the
// boxes that come after it in that order and begin before it ends; they are tested on the two other axes. Every pair is
// found once, from the box that begins first.
//
// The sort is a parallel radix sort (openmp/spatial/radix_sort.h). The sweep of a box is independent of all others:
// threads take blocks of sixteen boxes as they come. The sixteen boxes of a block meet sixteen candidates at a time,
// which stand side by side in the order of the sweep. There is no incremental form: insertion is sequential, and the
// sort is not where the time goes.
//
// Source: [LRB08] "Collision Detection", Figure 5, and "Thread-level Parallelism": sweep and prune can "sweep
// individual bodies completely in parallel". The contract stands in common/rigid/broad_phase.h.
#include <algorithm>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/broad_phase.h"
#include "common/rigid/limits.h"
#include "common/simd.h"
#include "common/spatial/sweep.h"
#include "openmp/rigid/arranged.h"
#include "openmp/spatial/boxes.h"
#include "openmp/spatial/order_pairs.h"
#include "openmp/spatial/pair_list.h"
#include "openmp/spatial/radix_sort.h"

namespace lockstep::rigid::openmp {
namespace {

using namespace spatial;
using namespace spatial::openmp;

// The axis on which the centres have the greatest variance.
int sweep_axis(const Bounds<Real>& bounds) {
  std::vector<Vector3<Real>> parts((bounds.count + sum_block - 1) / sum_block);
  return widest_axis<Real>([&](const auto& term) {
    // Every block is one thread's, and has a sum of its own.
#pragma omp parallel for schedule(static)
    for (int first = 0; first < bounds.count; first += sum_block)
      parts[first / sum_block] = sum_of_block(bounds, first, term);
    Vector3<Real> sum = {0, 0, 0};
    for (const Vector3<Real>& part : parts) sum = sum + part;
    return sum;
  });
}

// Sorts the bounded colliders by their lower ends, equal ones by number.
void sort_by_low(const Bounds<Real>& bounds, int axis, std::vector<std::int32_t>& order) {
  const Array<Real>& low = along(bounds.low, axis);
  sort_by_key(
      bounds, 32, [&](int i) { return key_of(load(&low[i])); }, order);
}

// Tests each box against its candidates. u and v are the two axes that are not swept.
void sweep(const Bounds<Real>& bounds, std::span<const std::int32_t> group, const SweepOrder& state, Pairs& pairs) {
  const int u = (state.axis + 1) % 3, v = (state.axis + 2) % 3;
  const Arranged& sorted = arrange(bounds, group, state.order);
  const int n = sorted.count;

  // Boxes are only read; the pairs that a thread finds go to its own list.
  const std::vector<PairList>& found = collect((n + lanes - 1) / lanes, 4, [&](int block, PairList& mine) {
    const Vectors<Real>&lows = sorted.boxes.low, &highs = sorted.boxes.high;
    const Real *const low = along(lows, state.axis).data(), *const high = along(highs, state.axis).data();
    const Real *const low_u = along(lows, u).data(), *const high_u = along(highs, u).data();
    const Real *const low_v = along(lows, v).data(), *const high_v = along(highs, v).data();
    const Owners owners(sorted);
    const int first = block * lanes, last = first + lanes;
    // Tests boxes j .. j + 15 against every box k of the block; candidates(k) are those that overlap it on the sweep
    // axis.
    const auto meet = [&](int j, const auto& candidates) {
      const floatv begin_u = load(low_u + j), end_u = load(high_u + j);
      const floatv begin_v = load(low_v + j), end_v = load(high_v + j);
      for (int k = first; k < last; ++k) {
        const maskv hit =
            candidates(k) & (begin_u <= high_u[k]) & (end_u >= low_u[k]) & (begin_v <= high_v[k]) & (end_v >= low_v[k]);
        if (any(hit)) add_hits(owners, k, j, hit, mine);
      }
    };
    const auto begun = [&](int j) { return [=, begin = load(low + j)](int k) { return begin <= high[k]; }; };
    meet(first, [&, begun = begun(first)](int k) { return begun(k) & !first_lanes(k - first + 1); });
    int j = last;
    // While all 16 candidates start before the first box of the block ends, they overlap every box of the block on the
    // sweep axis: skip that test. A box may end at infinity, where the padding behind the last box starts; so j is
    // compared with n.
    const Real first_end = reduce_min(load(high + first)), last_end = reduce_max(load(high + first));
    for (; j < n && low[j + lanes - 1] <= first_end; j += lanes) meet(j, [](int) { return first_lanes(lanes); });
    for (; j < n && low[j] <= last_end; j += lanes) meet(j, begun(j));
  });
  require_contacts_fit(count_pairs(found), pairs.capacity());
  order_pairs(bounds.count, found, pairs);
}

}  // namespace

void sweep_and_prune_batch(const Bounds<Real>& bounds, std::span<const std::int32_t> group, SweepOrder& state,
                           Pairs& pairs) {
  state.axis = sweep_axis(bounds);
  sort_by_low(bounds, state.axis, state.order);
  sweep(bounds, group, state, pairs);
}

}  // namespace lockstep::rigid::openmp
