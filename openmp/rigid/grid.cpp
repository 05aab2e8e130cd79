// A uniform grid: boxes of like size are put into cells, and only boxes of neighbouring cells are tested.
//
// Every box is in one cell, that of its low corner. It meets the boxes after it in that cell and the boxes of 13 of the
// 26 cells around: of two neighbouring cells, one looks at the other. So every pair is met once, and there are no
// duplicates to remove. common/spatial/wrapped_grid.h says how many cells there are, how they are hashed and why that
// finds all pairs.
//
// Cells must be as large as the largest box in them, and a few large boxes would make them too large for all others. So
// boxes longer than twice a typical size are kept apart, in a list at the end of the table that every box meets. Where
// sizes differ so much that many boxes are large, a tree is faster.
//
// The table is sorted in parallel; then the boxes are independent. Cells of a row are side by side in memory, but the
// runs of boxes in them are mostly far shorter than a vector. So a box first notes the candidates of all its runs;
// lanes then test sixteen of them at a time, each loading the whole record of its own.
//
// Source: Teschner et al., Optimized Spatial Hashing, VMV 2003; Ericson, Real-Time Collision Detection (2005), 7.1. The
// contract stands in common/rigid/broad_phase.h.
#include <algorithm>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/broad_phase.h"
#include "common/rigid/limits.h"
#include "common/simd.h"
#include "common/spatial/wrapped_grid.h"
#include "openmp/spatial/boxes.h"
#include "openmp/spatial/order_pairs.h"
#include "openmp/spatial/pair_list.h"
#include "openmp/spatial/radix_sort.h"

namespace lockstep::rigid::openmp {
namespace {

using namespace spatial;
using namespace spatial::openmp;

// The boxes no longer than a limit: their number, their longest side, and the box around their low corners.
struct Survey {
  int boxes = 0;
  Real size = 0;
  Box<Real> corners = empty_box<Real>;
};

Survey survey(const Bounds<Real>& bounds, Real limit) {
  std::vector<Survey> parts(omp_get_max_threads());
#pragma omp parallel
  {
    int boxes = 0;
    floatv longest = 0.f;
    Box<floatv> corners = in_all_lanes(empty_box<Real>);
    // Each thread surveys the boxes it has seen; counts, minima and maxima do not depend on the order.
#pragma omp for schedule(static) nowait
    for (int i = 0; i < bounds.count; i += lanes) {
      const Box<floatv> box = load_boxes(bounds, i);
      const floatv size = longest_side(box);
      const maskv counts = first_lanes(bounds.count - i) & (size <= limit);
      boxes += count(counts);
      where(counts, longest) = max(longest, size);
      corners = select(counts, around(corners, {box.low, box.low}), corners);
    }
    parts[omp_get_thread_num()] = {boxes, reduce_max(longest), around_lanes(corners)};
  }
  Survey found;
  for (const Survey& part : parts) {
    found.boxes += part.boxes;
    found.size = max(found.size, part.size);
    found.corners = around(found.corners, part.corners);
  }
  return found;
}

// Eight words, which load_records loads at once.
struct alignas(32) Entry {
  Vector3<Real> low;
  std::int32_t collider;
  Vector3<Real> high;
  std::int32_t group;
};

// The bounded colliders sorted by hash, equal ones by number. Those of hash h begin at begin[h]. Large ones have hash
// grid.cells(). Sixteen entries may be loaded from any on.
struct Table {
  std::vector<std::int32_t> order, begin;
  Array<Entry> entries;
};

void fill_table(const Bounds<Real>& bounds, std::span<const std::int32_t> group, const WrappedGrid<Real>& grid,
                Real size, Table& table) {
  const auto hash_of = [&](int i) {
    const Box<floatv> box = load_boxes(bounds, i);
    return select(longest_side(box) <= size, hash(grid, cell_at(grid, box.low)), grid.cells());
  };
  const int bits = grid.bits.x + grid.bits.y + grid.bits.z + 1;
  const std::span<const Keyed> sorted = sort_by_key(bounds, bits, hash_of, table.order);
  const int n = static_cast<int>(sorted.size());
  table.begin.resize(grid.cells() + 2);
  table.entries.resize(padded(n));
  // Every k is one thread's. If box k is the first of its hash, its thread sets where that hash and the empty ones
  // before it begin.
#pragma omp parallel for schedule(static)
  for (int k = 0; k <= n; ++k) {
    const int last = k < n ? static_cast<int>(sorted[k].key) : grid.cells() + 1;
    for (int h = k == 0 ? 0 : static_cast<int>(sorted[k - 1].key) + 1; h <= last; ++h) table.begin[h] = k;
    if (k == n) continue;
    const int collider = sorted[k].element;
    const Box<Real> box = bounds.box(collider);
    table.entries[k] = {box.low, collider, box.high, group[collider]};
  }
}

}  // namespace

void grid(const Bounds<Real>& bounds, std::span<const std::int32_t> group, Pairs& pairs) {
  const auto [boxes, size, corners] = survey(bounds, 2 * typical_size(bounds));
  const WrappedGrid<Real> grid = wrapped_grid(boxes, size, corners);
  thread_local Table table;  // kept from call to call, see workspace.h
  fill_table(bounds, group, grid, size, table);
  const std::int32_t* const begin = table.begin.data();
  const Entry* const entries = table.entries.data();
  const int n = static_cast<int>(table.order.size()), large = begin[grid.cells()];

  // Boxes are only read; the pairs that a thread finds go to its own list.
  const std::vector<PairList>& found = collect(n, 64, [&](int k, PairList& mine) {
    const Entry& own = entries[k];
    const Box<floatv> box = in_all_lanes(Box<Real>{own.low, own.high});
    // Lanes beyond those noted load an older candidate and are masked.
    alignas(array_alignment) std::int32_t candidates[2 * lanes] = {};
    int noted = 0;
    const auto meet_first = [&](int count) {
      const Records r = load_records(&entries->low.x, candidates);
      const Box<floatv> other = {{r.field[0], r.field[1], r.field[2]}, {r.field[4], r.field[5], r.field[6]}};
      const maskv hit = first_lanes(count) & overlap(box, other);
      if (none(hit)) return;
      const intv collider = bits_of(r.field[3]), group_of_other = bits_of(r.field[7]);
      add(mine, hit & (group_of_other != own.group), min(intv(own.collider), collider),
          max(intv(own.collider), collider));
    };
    // No branch asks whether a run is empty: it would be mispredicted.
    const auto note = [&](int first, int last) {
      int j = first;
      do {
        store(candidates + noted, lane_index() + j);
        noted += std::clamp(last - j, 0, lanes);
        if (noted >= lanes) {
          meet_first(lanes);
          store(candidates, load(candidates + lanes));
          noted -= lanes;
        }
        j += lanes;
      } while (j < last);
    };
    if (k < large) for_each_forward_run(grid, begin, cell_at(grid, own.low), k, note);
    if (large < n) note(std::max(k + 1, large), n);
    if (noted > 0) meet_first(noted);
  });
  require_contacts_fit(count_pairs(found), pairs.capacity());
  order_pairs(bounds.count, found, pairs);
}

}  // namespace lockstep::rigid::openmp
