// Boxes around what a cloth's elements sweep in a step: of vertices from their positions, of edges and triangles from
// those of their vertices, of nodes from those of their children, bottom up.
//
// Sixteen boxes at a time: those of a node are six vectors, one for each end along an axis. Edges and triangles load
// their vertices' boxes from records, one access a box.
//
// The trees' topology never changes, so there is nothing to build (common/production_cloth/search.h).
//
// The contract stands in common/production_cloth/bvh.h.
#include "common/production_cloth/bvh.h"

#include <memory>

#include "common/real.h"
#include "common/simd.h"
#include "openmp/spatial/boxes.h"
#include "openmp/vector_lanes.h"

namespace lockstep::production_cloth::openmp {
namespace {

using namespace spatial;
using namespace spatial::openmp;

static_assert(tree_width == lanes);

// The boxes of vertices as records of eight numbers: low and high.
struct VertexBoxes {
  struct alignas(32) Record {
    float number[8];
  };
  std::unique_ptr<Record[]> records;

  explicit VertexBoxes(int n) : records(std::make_unique_for_overwrite<Record[]>(n)) {}

  LOCKSTEP_INLINE Box<floatv> box(const std::int32_t* vertices) const {
    const Records r = load_records(records[0].number, vertices);
    return {{r.field[0], r.field[1], r.field[2]}, {r.field[3], r.field[4], r.field[5]}};
  }
  // Those of vertices i .. i + 15.
  LOCKSTEP_INLINE void set(int i, const Box<floatv>& box) const {
    alignas(64) std::int32_t place[lanes];
    store(place, lane_index() + i);
    store_records(records[0].number, place,
                  {{box.low.x, box.low.y, box.low.z, box.high.x, box.high.y, box.high.z, 0.f, 0.f}});
  }
};

// The box around the children of a node.
Box<Real> box_of_node(const Levels& levels, const Bounds<Real>& boxes, int level, int node) {
  return around_lanes(load_boxes(boxes, levels.first[level - 1] + node * tree_width));
}

// Level 0: box_of(i) for elements, and empty boxes up to a whole node. A team calls it, and waits at its end.
template <class BoxOf>
void fit_elements(const Levels& levels, const BoxOf& box_of, Bounds<Real>& boxes) {
  const Box<floatv> empty = in_all_lanes(empty_box<Real>);
  // Every node is one thread's. What box_of reads was written before the barrier of an earlier loop.
#pragma omp for schedule(static)
  for (int i = 0; i < levels.first[1]; i += lanes)
    store_boxes(boxes, i, select(first_lanes(levels.elements - i), box_of(i), empty));
}

// The levels above. A team calls it.
void fit_nodes(const Levels& levels, Bounds<Real>& boxes) {
  int n = levels.nodes();
  for (int level = 1; level <= levels.last(); ++level) {
    const int first = levels.first[level], slots = levels.first[level + 1] - first;
    // Every box of a level is one thread's and is made from the level below, which the loop's barrier has completed.
#pragma omp for schedule(static)
    for (int i = 0; i < slots; ++i)
      boxes.set(first + i, i < n ? box_of_node(levels, boxes, level, i) : empty_box<Real>);
    n = (n + tree_width - 1) / tree_width;
  }
}

}  // namespace

void refit(const Search& search, const Vectors<Real>& start, const Vectors<Real>& end, Real margin,
           SearchBoxes<Real>& boxes) {
  boxes.resize(search);
  const VertexBoxes of(search.vertices.first[1]);
  const Vector3<const float*> p = pointers(start), q = pointers(end);
#pragma omp parallel
  {
    fit_elements(
        search.vertices,
        [&](int i) {
          const Box<floatv> box = swept_box(load(p, i), load(q, i), margin);
          of.set(i, box);
          return box;
        },
        boxes.vertices);
    fit_elements(
        search.edges, [&](int i) { return around(of.box(&search.ends[0][i]), of.box(&search.ends[1][i])); },
        boxes.edges);
    fit_elements(
        search.triangles,
        [&](int i) {
          const auto& corner = search.corners;
          return around(around(of.box(&corner[0][i]), of.box(&corner[1][i])), of.box(&corner[2][i]));
        },
        boxes.triangles);
    fit_nodes(search.vertices, boxes.vertices);
    fit_nodes(search.edges, boxes.edges);
    fit_nodes(search.triangles, boxes.triangles);
  }
}

}  // namespace lockstep::production_cloth::openmp
