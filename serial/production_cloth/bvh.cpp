// Boxes around what a cloth's elements sweep in a step: of vertices from their positions, of edges and triangles from
// those of their vertices, of nodes from those of their children, bottom up.
//
// The trees' topology never changes, so there is nothing to build (common/production_cloth/search.h).
//
// The contract stands in common/production_cloth/bvh.h.
#include "common/production_cloth/bvh.h"

#include "common/real.h"

namespace lockstep::production_cloth::serial {
namespace {

using namespace spatial;

// The box around the children of a node.
Box<Real> box_of_node(const Levels& levels, const Bounds<Real>& boxes, int level, int node) {
  Box<Real> box = empty_box<Real>;
  for (int c = 0; c < tree_width; ++c) box = around(box, boxes.box(levels.first[level - 1] + node * tree_width + c));
  return box;
}

// Level 0: box_of(i) for elements, and empty boxes up to a whole node.
template <class BoxOf>
void fit_elements(const Levels& levels, const BoxOf& box_of, Bounds<Real>& boxes) {
  for (int i = 0; i < levels.first[1]; ++i) boxes.set(i, i < levels.elements ? box_of(i) : empty_box<Real>);
}

// The levels above.
void fit_nodes(const Levels& levels, Bounds<Real>& boxes) {
  int n = levels.nodes();
  for (int level = 1; level <= levels.last(); ++level) {
    const int first = levels.first[level], slots = levels.first[level + 1] - first;
    for (int i = 0; i < slots; ++i)
      boxes.set(first + i, i < n ? box_of_node(levels, boxes, level, i) : empty_box<Real>);
    n = (n + tree_width - 1) / tree_width;
  }
}

}  // namespace

void refit(const Search& search, const Vectors<Real>& start, const Vectors<Real>& end, Real margin,
           SearchBoxes<Real>& boxes) {
  boxes.resize(search);
  const Bounds<Real>& of = boxes.vertices;
  fit_elements(
      search.vertices, [&](int i) { return swept_box(load(start, i), load(end, i), margin); }, boxes.vertices);
  fit_elements(
      search.edges, [&](int i) { return around(of.box(search.ends[0][i]), of.box(search.ends[1][i])); }, boxes.edges);
  fit_elements(
      search.triangles,
      [&](int i) {
        const auto& corner = search.corners;
        return around(around(of.box(corner[0][i]), of.box(corner[1][i])), of.box(corner[2][i]));
      },
      boxes.triangles);
  fit_nodes(search.vertices, boxes.vertices);
  fit_nodes(search.edges, boxes.edges);
  fit_nodes(search.triangles, boxes.triangles);
}

}  // namespace lockstep::production_cloth::serial
