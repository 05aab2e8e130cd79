// A bounding volume hierarchy: a tree of boxes.
//
// To build it, elements are sorted by the Morton codes of their boxes' centres. Every sixteen in a row become a node,
// and every sixteen nodes become another: one sort, and no choices (common/spatial/tree.h). Where boxes are alike, such
// a tree is little worse than one whose every cut is chosen. One box far from all others makes the cells of the code
// coarse: the boxes stay right, the tree gets worse. To fit it, the order is kept and only the boxes are made anew,
// bottom up.
//
// Every loop over boxes is shared out among threads. A node is six vectors, one for each end of its sixteen boxes along
// an axis.
//
// Source: [ITJ07] on the broad phase; Lauterbach et al., Fast BVH Construction on GPUs, Computer Graphics Forum 28
// (2009), for the order. The contract stands in common/spatial/tree.h.
#include <vector>

#include "common/math.h"
#include "common/real.h"
#include "common/simd.h"
#include "common/spatial/morton.h"
#include "common/spatial/tree.h"
#include "openmp/share.h"
#include "openmp/spatial/boxes.h"
#include "openmp/spatial/radix_sort.h"

namespace lockstep::spatial::openmp {
namespace {

static_assert(tree_width == lanes);

// The smallest box around twice the centres.
Box<Real> extent_of(const Bounds<Real>& bounds) {
  std::vector<Box<Real>> parts(omp_get_max_threads(), empty_box<Real>);
#pragma omp parallel
  {
    Box<floatv> extent = in_all_lanes(empty_box<Real>);
    // Each thread keeps the extent of the boxes it has seen; minima and maxima do not depend on the order.
#pragma omp for schedule(static) nowait
    for (int i = 0; i < bounds.count; i += lanes) {
      const Box<floatv> box = load_boxes(bounds, i);
      const maskv counts = first_lanes(bounds.count - i) & bounded(box);
      extent = select(counts, around(extent, {box.low + box.high, box.low + box.high}), extent);
    }
    parts[omp_get_thread_num()] = around_lanes(extent);
  }
  Box<Real> extent = empty_box<Real>;
  for (const Box<Real>& part : parts) extent = around(extent, part);
  return extent;
}

// Sorts the bounded elements by the Morton codes of their centres, equal ones by number.
void sort_by_code(const Bounds<Real>& bounds, std::vector<std::int32_t>& order) {
  const Box<Real> extent = extent_of(bounds);
  const Real scale = morton_scale(extent);
  const auto code = [&](int i) {
    const Box<floatv> box = load_boxes(bounds, i);
    return morton_code(box.low + box.high, extent.low, scale);
  };
  sort_by_key(bounds, morton_bits + 1, code, order);
}

// The box around the children of a node.
Box<Real> box_of_node(const Tree<Real>& tree, int level, int node) {
  const Box<floatv> box = load_boxes(tree.boxes, tree.first[level - 1] + node * tree_width);
  return around_lanes(box);
}

}  // namespace

void bvh_build(const Bounds<Real>& bounds, Tree<Real>& tree) {
  sort_by_code(bounds, tree.order);
  tree.first = level_starts(static_cast<int>(tree.order.size()));
  tree.boxes.resize(tree.first.back());
  bvh_refit(bounds, tree);
}

void bvh_refit(const Bounds<Real>& bounds, Tree<Real>& tree) {
  Bounds<Real>& boxes = tree.boxes;
#pragma omp parallel
  {
    int n = static_cast<int>(tree.order.size());
    for (int level = 0; level < tree.levels(); ++level) {
      const int first = tree.first[level], slots = tree.first[level + 1] - first;
      // Every box of a level is one thread's and is made from the level below, which the loop's barrier has completed.
#pragma omp for schedule(static)
      for (int i = 0; i < slots; ++i)
        boxes.set(first + i, i >= n       ? empty_box<Real>
                             : level == 0 ? zeros_positive(bounds.box(tree.order[i]))
                                          : box_of_node(tree, level, i));
      n = (n + tree_width - 1) / tree_width;
    }
  }
}

}  // namespace lockstep::spatial::openmp
