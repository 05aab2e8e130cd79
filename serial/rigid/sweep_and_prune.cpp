// Sweep and prune: boxes that overlap also overlap along each axis, so only pairs that overlap along one axis are
// tested.
//
// The lower ends of all boxes are sorted along the axis on which the boxes are spread most. A box's candidates are the
// boxes that come after it in that order and begin before it ends; they are tested on the two other axes. Every pair is
// found once, from the box that begins first.
//
// The batch form sorts from nothing. The incremental form mends the order of the step before by insertion: each box
// moves down past those that begin after it now. Bodies move little in a step, so the cost is nearly linear, and the
// order is the only thing to sort. Both forms then sweep in the same way. In a pile of n boxes a box has of the order
// of n^(2/3) candidates, and that is where the time goes.
//
// Source: [LRB08] "Collision Detection", Figure 5; Cohen et al., I-COLLIDE, Symp. Interactive 3D Graphics (1995), for
// the order that is kept. The contract stands in common/rigid/broad_phase.h.
#include <algorithm>
#include <utility>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/broad_phase.h"
#include "common/rigid/limits.h"
#include "common/spatial/order_pairs.h"
#include "common/spatial/sweep.h"

namespace lockstep::rigid::serial {
namespace {

using namespace spatial;

// The axis on which the centres have the greatest variance.
int sweep_axis(const Bounds<Real>& bounds) {
  return widest_axis<Real>([&](const auto& term) {
    Vector3<Real> sum = {0, 0, 0};
    for (int first = 0; first < bounds.count; first += sum_block) sum = sum + sum_of_block(bounds, first, term);
    return sum;
  });
}

// Sorts the bounded colliders by their lower ends, equal ones by number.
void sort_by_low(const Bounds<Real>& bounds, int axis, std::vector<std::int32_t>& order) {
  const Array<Real>& low = along(bounds.low, axis);
  std::vector<std::pair<Real, std::int32_t>> keys;
  for (int i = 0; i < bounds.count; ++i)
    if (bounds.bounded(i)) keys.push_back({low[i], i});
  std::sort(keys.begin(), keys.end());
  order.clear();
  for (const auto& [key, i] : keys) order.push_back(i);
}

// Insertion sort: each collider in turn moves down past those that come after it.
void mend(const Array<Real>& low, std::vector<std::int32_t>& order) {
  for (std::size_t k = 1; k < order.size(); ++k) {
    const std::int32_t i = order[k];
    std::size_t hole = k;
    for (; hole > 0 && std::pair(low[i], i) < std::pair(low[order[hole - 1]], order[hole - 1]); --hole)
      order[hole] = order[hole - 1];
    order[hole] = i;
  }
}

// Whether `order` holds every bounded collider exactly once.
bool is_complete(const Bounds<Real>& bounds, const std::vector<std::int32_t>& order) {
  std::vector<bool> seen(bounds.count);
  for (const std::int32_t i : order) {
    if (i < 0 || i >= bounds.count || !bounds.bounded(i) || seen[i]) return false;
    seen[i] = true;
  }
  for (int i = 0; i < bounds.count; ++i)
    if (bounds.bounded(i) && !seen[i]) return false;
  return true;
}

// Tests each box against its candidates. u and v are the two axes that are not swept.
void sweep(const Bounds<Real>& bounds, std::span<const std::int32_t> group, const SweepOrder& state, Pairs& pairs) {
  const std::vector<std::int32_t>& order = state.order;
  const int n = static_cast<int>(order.size()), u = (state.axis + 1) % 3, v = (state.axis + 2) % 3;
  Bounds<Real> sorted;
  sorted.resize(n);
  for (int k = 0; k < n; ++k) sorted.set(k, bounds.box(order[k]));
  const Real *const low = along(sorted.low, state.axis).data(), *const high = along(sorted.high, state.axis).data();
  const Real *const low_u = along(sorted.low, u).data(), *const high_u = along(sorted.high, u).data();
  const Real *const low_v = along(sorted.low, v).data(), *const high_v = along(sorted.high, v).data();

  const std::size_t room = pairs.capacity();
  pairs.clear();
  for (int k = 0; k < n; ++k)
    for (int j = k + 1; j < n && low[j] <= high[k]; ++j) {
      // & instead of &&: half the candidates pass each test, so branches would be mispredicted.
      const bool hit =
          (low_u[j] <= high_u[k]) & (low_u[k] <= high_u[j]) & (low_v[j] <= high_v[k]) & (low_v[k] <= high_v[j]);
      if (hit && group[order[k]] != group[order[j]]) add_pair(pairs, make_pair(order[k], order[j]));
    }
  require_contacts_fit(pairs.size(), room);
  order_pairs(bounds.count, pairs);
}

}  // namespace

void sweep_and_prune_batch(const Bounds<Real>& bounds, std::span<const std::int32_t> group, SweepOrder& state,
                           Pairs& pairs) {
  state.axis = sweep_axis(bounds);
  sort_by_low(bounds, state.axis, state.order);
  sweep(bounds, group, state, pairs);
}

void sweep_and_prune_incremental(const Bounds<Real>& bounds, std::span<const std::int32_t> group, SweepOrder& state,
                                 Pairs& pairs) {
  const int axis = sweep_axis(bounds);
  if (axis == state.axis && is_complete(bounds, state.order)) {
    mend(along(bounds.low, axis), state.order);
  } else {
    state.axis = axis;
    sort_by_low(bounds, axis, state.order);
  }
  sweep(bounds, group, state, pairs);
}

}  // namespace lockstep::rigid::serial
