// A uniform grid: boxes of like size are put into cells, and only those of neighbouring cells are looked at.
//
// Every box is in one cell, that of its low corner, and meets the boxes after it in that cell and those of 13 of the 26 cells around: of
// two cells, one looks at the other. So every pair is met once, and there are no duplicates to remove. How many cells, how they are hashed
// and why that is enough: common/spatial/wrapped_grid.h.
//
// Cells must be as large as the largest box in them, and a few large boxes would make them too large for all the others. So those
// longer than twice a size that most keep to are kept apart, in a list at the end of the table, which every box meets. Where sizes differ
// so much that many are large, a tree does better.
//
// The table is sorted in parallel; then the boxes are independent. Cells of a row are side by side in memory, but the runs that they make
// are mostly far shorter than a vector. So a box first notes the candidates of all its runs, and lanes meet sixteen of them at a time, each
// loading the whole record of its own.
//
// Source: Teschner et al., Optimized Spatial Hashing, VMV 2003; Ericson, Real-Time Collision Detection (2005), 7.1. The contract stands in
// common/rigid/broad_phase.h.
#include <algorithm>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/broad_phase.h"
#include "common/rigid/limits.h"
#include "common/spatial/wrapped_grid.h"
#include "common/simd.h"
#include "openmp/spatial/boxes.h"
#include "openmp/spatial/order_pairs.h"
#include "openmp/spatial/pair_list.h"
#include "openmp/spatial/radix_sort.h"

namespace lockstep::rigid::openmp {
namespace {

using namespace spatial;
using namespace spatial::openmp;

// Of the boxes no longer than a limit: how many, the longest of their sides, and where their low corners are.
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
    // A thread surveys what it has seen; counts, least and greatest are the same in any order.
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

// Eight numbers of four bytes, which lanes load at once.
struct alignas(32) Entry {
  Vector3<Real> low;
  std::int32_t collider;
  Vector3<Real> high;
  std::int32_t group;
};

// Colliders that have bounds in the order of the table, those of hash h from begin[h] on, equal ones by number; large ones as if their hash
// were grid.cells(). Sixteen entries more may be loaded.
struct Table {
  std::vector<std::int32_t> order, begin;
  Array<Entry> entries;
};

void fill_table(const Bounds<Real>& bounds, std::span<const std::int32_t> group, const WrappedGrid<Real>& grid, Real size, Table& table) {
  const auto hash_of = [&](int i) {
    const Box<Real> box = bounds.box(i);
    return longest_side(box) <= size ? hash(grid, cell_at(grid, box.low)) : grid.cells();
  };
  const std::span<const Keyed> sorted = sort_by_key(bounds, grid.bits.x + grid.bits.y + grid.bits.z + 1, hash_of, table.order);
  const int n = static_cast<int>(sorted.size());
  table.begin.resize(grid.cells() + 2);
  table.entries.resize(padded(n));
  // Where box k is the first of its hash, whoever has k says where that hash begins, and with it the empty ones before it.
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

  // Boxes are only read, what is found goes to a thread's own list.
  const std::vector<PairList>& found = collect(n, 64, [&](int k, PairList& mine) {
    const Entry& own = entries[k];
    const Box<floatv> box = in_all_lanes(Box<Real>{own.low, own.high});
    alignas(array_alignment) std::int32_t candidates[2 * lanes] = {};  // lanes beyond those noted load what was there, and do not count
    int noted = 0;
    const auto meet_first = [&](int count) {
      const Records r = load_records(&entries->low.x, candidates);
      const Box<floatv> other = {{r.field[0], r.field[1], r.field[2]}, {r.field[4], r.field[5], r.field[6]}};
      const maskv hit = first_lanes(count) & overlap(box, other);
      if (none(hit)) return;
      const intv collider = bits_of(r.field[3]), group_of_other = bits_of(r.field[7]);
      add(mine, hit & (group_of_other != own.group), min(intv(own.collider), collider), max(intv(own.collider), collider));
    };
    // Whether a run is empty no branch could foresee.
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
