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
// Source: Teschner et al., Optimized Spatial Hashing, VMV 2003; Ericson, Real-Time Collision Detection (2005), 7.1. The
// contract stands in common/rigid/broad_phase.h.
#include <algorithm>

#include "common/counting_sort.h"
#include "common/math.h"
#include "common/real.h"
#include "common/rigid/broad_phase.h"
#include "common/rigid/limits.h"
#include "common/spatial/order_pairs.h"
#include "common/spatial/wrapped_grid.h"

namespace lockstep::rigid::serial {
namespace {

using namespace spatial;

// The boxes no longer than a limit: their number, their longest side, and the box around their low corners.
struct Survey {
  int boxes = 0;
  Real size = 0;
  Box<Real> corners = empty_box<Real>;
};

Survey survey(const Bounds<Real>& bounds, Real limit) {
  Survey found;
  for (int i = 0; i < bounds.count; ++i) {
    const Box<Real> box = bounds.box(i);
    const Real size = longest_side(box);
    if (size > limit) continue;
    ++found.boxes;
    found.size = max(found.size, size);
    found.corners = around(found.corners, {box.low, box.low});
  }
  return found;
}

// The bounded colliders sorted by hash, equal ones by number. Those of hash h begin at begin[h]. Large ones have hash
// grid.cells().
struct Table {
  std::vector<std::int32_t> order, begin;
};

void fill_table(const Bounds<Real>& bounds, const WrappedGrid<Real>& grid, Real size, Table& table) {
  const auto hash_of = [&](int i) {
    const Box<Real> box = bounds.box(i);
    return longest_side(box) <= size ? hash(grid, cell_at(grid, box.low)) : grid.cells();
  };
  table.order.resize(bounds.count);
  stable_counting_sort(
      grid.cells() + 1,
      [&](const auto& visit) {
        for (int i = 0; i < bounds.count; ++i)
          if (bounds.bounded(i)) visit(i, hash_of(i));
      },
      [&](int i, int place) { table.order[place] = i; }, table.begin);
  table.order.resize(table.begin.back());
}

}  // namespace

void grid(const Bounds<Real>& bounds, std::span<const std::int32_t> group, Pairs& pairs) {
  const auto [boxes, size, corners] = survey(bounds, 2 * typical_size(bounds));
  const WrappedGrid<Real> grid = wrapped_grid(boxes, size, corners);
  Table table;
  fill_table(bounds, grid, size, table);
  const std::vector<std::int32_t>&order = table.order, &begin = table.begin;
  const int n = static_cast<int>(order.size()), large = begin[grid.cells()];
  Bounds<Real> sorted;
  sorted.resize(n);
  for (int k = 0; k < n; ++k) sorted.set(k, bounds.box(order[k]));

  const std::size_t room = pairs.capacity();
  pairs.clear();
  for (int k = 0; k < n; ++k) {
    const Box<Real> box = sorted.box(k);
    const auto meet = [&](int first, int last) {
      for (int j = first; j < last; ++j)
        if (overlap(box, sorted.box(j)) && group[order[k]] != group[order[j]])
          add_pair(pairs, make_pair(order[k], order[j]));
    };
    if (k < large) for_each_forward_run(grid, begin.data(), cell_at(grid, box.low), k, meet);
    meet(std::max(k + 1, large), n);
  }
  require_contacts_fit(pairs.size(), room);
  order_pairs(bounds.count, pairs);
}

}  // namespace lockstep::rigid::serial
