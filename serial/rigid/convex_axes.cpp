// Convex against convex: along which axis two cores are farthest apart, or overlap least.
//
// The distance of two cores comes from GJK. Where they overlap, or nearly touch, the normal is the axis along which
// they overlap least: one of the normals of a's faces, of b's, or a cross product of two edges, for these are the
// normals of the faces of the difference of two polytopes. Trying all is exact and knows no degenerate cases, where
// polytopes that are expanded towards the difference (EPA) fail on flat and needle-like faces. But the edges alone
// would give thousands of pairs.
//
// One point that both cores have, which GJK knows, makes it cheap. If an axis separates the cores by s <= 0, no point
// of b, so not the common point either, is lower than s above where a ends. So a face can be discarded if the common
// point lies deeper below it than the best depth found so far; an edge, if both its faces are discarded, since the
// point is as deep along any axis between their normals. Of millimetres of overlap a handful of faces and edges is
// left. The bounds hold for any point of the core. How many axes are left depends on the point; the result does not.
//
// The faces are tried as cutting planes are. The one with the highest bound is measured, by the vertex of the other
// core that is deepest below it. That vertex bounds all other faces, too. This ends when no bound is higher than what
// was measured.
//
// Source: separating axes of polytopes, Gottschalk, Lin and Manocha, SIGGRAPH 1996; Gregorius, The Separating Axis Test
//         between Convex Polyhedra, GDC 2013. The bounds by a common point are ours. The contract stands in
//         common/rigid/convex_axes.h, formulas in common/rigid/core_axes.h.
#include "common/rigid/convex_axes.h"

#include <algorithm>
#include <array>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/core_axes.h"

namespace lockstep::rigid::serial {
namespace {

constexpr Real infinity = std::numeric_limits<Real>::infinity();

// A collider's hull.
struct Shape {
  int vertices, faces;
  const Quad<Real>* vertex;          // as it stands in the library
  const Quad<Real>* plane;           // [face]
  const std::int32_t* first_corner;  // [face]
  const std::int32_t* corner;
  Vector3<Real> scale;
  bool cube;
};

Shape shape_of(const Placed<Real>& placed, int collider) {
  const Hulls<Real>& hulls = placed.hulls;
  const int hull = placed.colliders.hull[collider];
  return {hulls.vertices(hull),
          hulls.faces(hull),
          &hulls.vertex[hulls.first_vertex[hull]],
          hulls.plane.data() + hulls.first_face[hull],
          hulls.first_corner.data() + hulls.first_face[hull],
          hulls.corner.data(),
          vector_of(placed.colliders.size[collider]),
          hull == cube_hull};
}

Vector3<Real> normal_of(const Shape& shape, int face) { return vector_of(shape.plane[face]); }

// The height of a point of the shape's frame above a face, m. Of shapes with faces only the cube is scaled, and its
// normals are its axes: they stay.
Real height(const Shape& shape, int face, const Vector3<Real>& point) {
  const Quad<Real>& plane = shape.plane[face];
  return dot(vector_of(plane), point) - (shape.cube ? dot(absolute(vector_of(plane)), shape.scale) : plane.w);
}

// The vertex that is lowest along a direction (brought into the hull's frame); the first of equals.
int lowest(const Shape& shape, const Vector3<Real>& direction) {
  int lowest = 0;
  Real least = dot(direction, vector_of(shape.vertex[0]));
  for (int k = 1; k < shape.vertices; ++k) {
    const Real along = dot(direction, vector_of(shape.vertex[k]));
    if (along < least) least = along, lowest = k;
  }
  return lowest;
}

// The face whose normal is nearest to a direction, in the shape's frame; the first of equals.
Facing<Real> facing(const Shape& shape, const Vector3<Real>& direction) {
  Facing<Real> best = {-1, -infinity};
  for (int face = 0; face < shape.faces; ++face) {
    const Real cosine = dot(direction, normal_of(shape, face));
    if (cosine > best.cosine) best = {face, cosine};
  }
  return best;
}

// Two colliders, in a's frame.
struct Problem : CorePair<Real> {
  Shape a, b;

  Vector3<Real> vertex_a(int k) const { return vertex_of_a(cores, vector_of(a.vertex[k])); }
  Vector3<Real> vertex_b(int k) const { return vertex_of_b(cores, vector_of(b.vertex[k])); }
  // The vertices that are lowest along a direction.
  Vector3<Real> lowest_a(const Vector3<Real>& direction) const {
    return vertex_a(lowest(a, direction_in_a(cores, direction)));
  }
  Vector3<Real> lowest_b(const Vector3<Real>& direction) const {
    return vertex_b(lowest(b, direction_in_b(cores, direction)));
  }
};

Problem make_problem(const Placed<Real>& placed, const Pair& pair, const Simplex& simplex) {
  const auto& [colliders, hulls, pose] = placed;
  const int hull_a = colliders.hull[pair.a], hull_b = colliders.hull[pair.b];
  const Shape a = shape_of(placed, pair.a), b = shape_of(placed, pair.b);
  const Cores<Real> cores = make_cores(a.scale, b.scale, pose[pair.a].position, pose[pair.b].position,  //
                                       pose[pair.a].orientation, pose[pair.b].orientation);
  Vector3<Real> of_a[4], of_b[4];
  for (int k = 0; k < 4; ++k) {
    of_a[k] = vertex_of_a(cores, vector_of(a.vertex[simplex.a[k]]));
    of_b[k] = vertex_of_b(cores, vector_of(b.vertex[simplex.b[k]]));
  }
  const Real reach =
      reach_of(cores, hulls.centre[hull_a], hulls.half[hull_a], hulls.centre[hull_b], hulls.half[hull_b]);
  return {make_core_pair<Real>(cores, reach, simplex.count, of_a, of_b), a, b};
}

// No axis of a face separates by more than the least height of a point of the other core above it.
using FaceBounds = std::array<Real, most_hull_faces>;

FaceBounds face_bounds(const Shape& shape, const Vector3<Real>& point) {
  FaceBounds bound;
  for (int face = 0; face < shape.faces; ++face) bound[face] = height(shape, face, point);
  return bound;
}

template <class Deepest>
BestFace<Real> best_face(const Shape& shape, const FaceBounds& bounds, Real least, const Deepest& deepest) {
  FaceBounds bound = bounds;
  BestFace<Real> best = {-1, least, {0, 0, 0}};
  for (;;) {
    int highest = -1;
    for (int face = 0; face < shape.faces; ++face)
      if (highest < 0 || bound[face] > bound[highest]) highest = face;
    if (highest < 0 || !(bound[highest] > best.separation)) return best;
    const Vector3<Real> vertex = deepest(normal_of(shape, highest));
    for (int face = 0; face < shape.faces; ++face) bound[face] = min(height(shape, face, vertex), bound[face]);
    if (bound[highest] > best.separation) best = {highest, bound[highest], vertex};
    bound[highest] = -infinity;  // it is measured
  }
}

struct Edges {
  int count = 0;
  std::array<CoreEdge<Real>, most_hull_edges + 1> edge;  // one beyond, which is written but not counted
};

// The edges of a shape that have a face that may separate by more than `least`, each once. A segment has one edge and
// no faces.
template <class Place>
Edges edges_left(const Shape& shape, const FaceBounds& bound, Real least, const Place& place) {
  Edges edges;
  const auto add = [&](int from, int to, bool is_new) {
    const Vector3<Real> start = place(from);
    edges.edge[edges.count] = {start, place(to) - start};
    edges.count += is_new;
  };
  if (shape.faces == 0 && shape.vertices == 2) add(0, 1, true);
  std::array<std::uint64_t, most_hull_vertices> taken;  // [from]: the set of vertices to which edges go
  std::fill_n(taken.begin(), shape.vertices, 0);
  for (int face = 0; face < shape.faces; ++face) {
    if (!(bound[face] > least)) continue;
    const int first = shape.first_corner[face], end = shape.first_corner[face + 1];
    int from = shape.corner[end - 1];
    for (int k = first; k < end; ++k) {
      const int to = shape.corner[k];
      taken[from] |= std::uint64_t{1} << to;
      add(from, to, (taken[to] >> from & 1) == 0);
      from = to;
    }
  }
  return edges;
}

// The axis that separates most, of cores that overlap or touch: faces first, then edges where they are better.
CoreAxis<Real> deepest_axis(const Problem& problem) {
  const FaceBounds bounds_a = face_bounds(problem.a, problem.on_b),
                   bounds_b = face_bounds(problem.b, problem.in_b(problem.on_a));
  CoreAxis<Real> best = best_face_axis(problem, bounds_a, bounds_b);
  const Real least = min(best.separation, 0);
  const Edges edges_a = edges_left(problem.a, bounds_a, least, [&](int k) { return problem.vertex_a(k); });
  const Edges edges_b = edges_left(problem.b, bounds_b, least, [&](int k) { return problem.vertex_b(k); });
  for (int i = 0; i < edges_a.count; ++i)
    for (int k = 0; k < edges_b.count; ++k) try_edges(problem, edges_a.edge[i], edges_b.edge[k], best);
  try_closest_points(problem, best);
  return best;
}

}  // namespace

void convex_axes(const Placed<Real>& placed, std::span<const Pair> pairs, std::span<const Simplex> simplex,
                 std::span<const Closest<Real>> closest, Real margin, std::span<SeparatingAxis<Real>> axes) {
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Pair& pair = pairs[k];
    const Real radius_a = placed.colliders.size[pair.a].w, radius_b = placed.colliders.size[pair.b].w;
    if (!(closest[k].distance <= margin + (radius_a + radius_b))) {
      axes[k] = far_apart<Real>;
      continue;
    }
    const Problem problem = make_problem(placed, pair, simplex[k]);
    axes[k] = with_faces(problem, are_apart(problem) ? closest_axis(problem) : deepest_axis(problem));
  }
}

}  // namespace lockstep::rigid::serial
