// Convex against convex: along which axis two cores are farthest apart, or overlap least.
//
// serial/rigid/convex_axes.cpp explains how the axis is found. Here lanes are used in two ways:
//
//   - Sixteen pairs at once, where all pairs do the same: the cores, and GJK's simplex at their new positions. Pairs
//     that are too far apart are left out before, so that lanes are full.
//   - One pair, where pairs differ: which faces are tried and which edges are left. There the lanes are sixteen faces,
//     sixteen vertices, or sixteen edges of b against one of a. Hulls of a dozen vertices or two have about as many
//     faces as two vectors hold; sixteen pairs side by side would all wait for the one that tries most.
//
// Source: as in serial/rigid/convex_axes.cpp. The contract stands in common/rigid/convex_axes.h, formulas in
//         common/rigid/core_axes.h.
#include "common/rigid/convex_axes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/core_axes.h"
#include "common/simd.h"
#include "openmp/rigid/chunks.h"
#include "openmp/rigid/hull_components.h"
#include "openmp/rigid/hull_lanes.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {
namespace {

constexpr Real infinity = std::numeric_limits<Real>::infinity();
constexpr int face_vectors = (most_hull_faces + lanes - 1) / lanes;

Vector3<floatv> splat(const Vector3<Real>& v) { return {v.x, v.y, v.z}; }

// Lane l.
Real at(const floatv& v, int l) { return std::bit_cast<std::array<Real, lanes>>(v)[l]; }
Vector3<Real> at(const Vector3<floatv>& v, int l) { return {at(v.x, l), at(v.y, l), at(v.z, l)}; }

// The vertices of a hull in a's frame.
struct PlacedVertices {
  alignas(array_alignment) std::array<Real, most_hull_vertices> x, y, z;
  void set(int k, const Vector3<floatv>& v) { store(&x[k], v.x), store(&y[k], v.y), store(&z[k], v.z); }
  Vector3<Real> operator[](int k) const { return {x[k], y[k], z[k]}; }
};

// A collider's hull.
struct Shape {
  int vertices, faces;
  const Real* vertex;                // as in the library; x, y, z
  const Real* plane;                 // [face]; x, y, z
  const Real* distance;              // [face]: of the plane from the origin
  const std::int32_t* first_corner;  // [face]
  const std::int32_t* corner;
  Vector3<Real> scale;
  alignas(array_alignment) Real cube_distance[lanes];

  Vector3<floatv> sixteen_vertices(int k) const {
    const int stride = whole(vertices);
    return {load(vertex + k), load(vertex + stride + k), load(vertex + 2 * stride + k)};
  }
  Vector3<floatv> sixteen_normals(int face) const {
    const int stride = whole(faces);
    return {load(plane + face), load(plane + stride + face), load(plane + 2 * stride + face)};
  }
};

void load_shape(const Placed<Real>& placed, const HullComponents& hull_components, int collider, Shape& shape) {
  const Hulls<Real>& hulls = placed.hulls;
  const int hull = placed.colliders.hull[collider];
  shape.vertices = hulls.vertices(hull);
  shape.faces = hulls.faces(hull);
  shape.vertex = &hull_components.component[hull_components.begin[hull]];
  shape.plane = shape.vertex + 3 * whole(shape.vertices);
  shape.distance = shape.plane + 3 * whole(shape.faces);
  shape.first_corner = hulls.first_corner.data() + hulls.first_face[hull];
  shape.corner = hulls.corner.data();
  shape.scale = vector_of(placed.colliders.size[collider]);
  // Of shapes with faces only the cube is scaled, and its normals are its axes: they stay.
  if (hull == cube_hull) {
    store(shape.cube_distance, dot(absolute(shape.sixteen_normals(0)), splat(shape.scale)));
    shape.distance = shape.cube_distance;
  }
}

Vector3<Real> normal_of(const Shape& shape, int face) {
  const int stride = whole(shape.faces);
  return {shape.plane[face], shape.plane[stride + face], shape.plane[2 * stride + face]};
}

// The height of a point of the shape's frame above a face, and above sixteen, m.
Real height(const Shape& shape, int face, const Vector3<Real>& point) {
  return dot(normal_of(shape, face), point) - shape.distance[face];
}
floatv height(const Shape& shape, int face, const Vector3<floatv>& point) {
  return dot(shape.sixteen_normals(face), point) - load(shape.distance + face);
}

// The first of the elements that have the least value; `value` gives sixteen from an element on. If that is NaN, the
// first element.
template <class Value>
int first_least(int count, const Value& value) {
  std::array<floatv, face_vectors> values;
  floatv least = values[0] = value(0);
  for (int k = lanes; k < count; k += lanes) {
    values[k / lanes] = value(k);
    least = min(least, values[k / lanes]);
  }
  const floatv bound = reduce_min(least);
  for (int k = 0; k < count; k += lanes)
    if (const maskv equal = values[k / lanes] == bound; any(equal)) return k + std::countr_zero(bits(equal));
  return 0;
}

// The vertex that is lowest along a direction (brought into the hull's frame); the first of equals.
int lowest(const Shape& shape, const Vector3<Real>& direction) {
  const Vector3<floatv> d = splat(direction);
  return first_least(shape.vertices, [&](int k) { return dot(d, shape.sixteen_vertices(k)); });
}

// The face whose normal is nearest to a direction, in the shape's frame; the first of equals.
Facing<Real> facing(const Shape& shape, const Vector3<Real>& direction) {
  if (shape.faces == 0) return {-1, -infinity};
  const Vector3<floatv> d = splat(direction);
  const int face = first_least(shape.faces, [&](int face) { return -dot(d, shape.sixteen_normals(face)); });
  return {face, dot(direction, normal_of(shape, face))};
}

// Two colliders, in a's frame.
struct Problem : CorePair<Real> {
  Shape a, b;
  PlacedVertices vertices_a, vertices_b;

  // The vertices that are lowest along a direction.
  Vector3<Real> lowest_a(const Vector3<Real>& direction) const {
    return vertices_a[lowest(a, direction_in_a(cores, direction))];
  }
  Vector3<Real> lowest_b(const Vector3<Real>& direction) const {
    return vertices_b[lowest(b, direction_in_b(cores, direction))];
  }
};

// Lane l of sixteen problems. The shapes are there.
void take_problem(const CorePair<floatv>& p, int l, Problem& problem) {
  const Shape &a = problem.a, &b = problem.b;
  problem.cores.scale_a = a.scale, problem.cores.scale_b = b.scale;
  problem.cores.turn = {at(p.cores.turn.x, l), at(p.cores.turn.y, l), at(p.cores.turn.z, l)};
  problem.cores.offset = at(p.cores.offset, l);
  problem.slack = at(p.slack, l), problem.touching = at(p.touching, l);
  problem.on_a = at(p.on_a, l), problem.on_b = at(p.on_b, l), problem.between = at(p.between, l);

  const Matrix3<Real>& turn = problem.cores.turn;
  Cores<floatv> cores;
  cores.scale_a = splat(a.scale), cores.scale_b = splat(b.scale);
  cores.turn = {splat(turn.x), splat(turn.y), splat(turn.z)}, cores.offset = splat(problem.cores.offset);
  for (int k = 0; k < a.vertices; k += lanes) problem.vertices_a.set(k, vertex_of_a(cores, a.sixteen_vertices(k)));
  for (int k = 0; k < b.vertices; k += lanes) problem.vertices_b.set(k, vertex_of_b(cores, b.sixteen_vertices(k)));
}

// Sixteen problems, but for the shapes; simplex[which] of each pair.
CorePair<floatv> make_problems(const Placed<Real>& placed, const PairLanes& pairs, std::span<const Simplex> simplex,
                               const Indices& which) {
  const HullLanes a = load_hulls(placed, pairs.a), b = load_hulls(placed, pairs.b);
  const Cores<floatv> cores = load_cores(placed, pairs);
  const floatv reach = load_reach(placed, cores, a, b);

  Vector3<floatv> of_a[4], of_b[4];
  Indices count, number_a, number_b;
  for (int l = 0; l < lanes; ++l) count.index[l] = simplex[which.index[l]].count;
  for (int k = 0; k < 4; ++k) {
    for (int l = 0; l < lanes; ++l) {
      const Simplex& of_pair = simplex[which.index[l]];
      number_a.index[l] = of_pair.a[k], number_b.index[l] = of_pair.b[k];
    }
    of_a[k] = vertex_of_a(cores, load_vertices(placed, a, load(number_a.index)));
    of_b[k] = vertex_of_b(cores, load_vertices(placed, b, load(number_b.index)));
  }
  return make_core_pair<Real>(cores, reach, load(count.index), of_a, of_b);
}

// No axis of a face separates by more than the least height of a point of the other core above it. Lanes beyond the
// last face are below everything.
struct FaceBounds {
  alignas(array_alignment) std::array<Real, face_vectors * lanes> bound;
  Real& operator[](int face) { return bound[face]; }
  Real operator[](int face) const { return bound[face]; }
  floatv sixteen(int face) const { return load(&bound[face]); }
};

FaceBounds face_bounds(const Shape& shape, const Vector3<Real>& point) {
  FaceBounds bound;
  const Vector3<floatv> p = splat(point);
  for (int face = 0; face < shape.faces; face += lanes)
    store(&bound[face], select(first_lanes(shape.faces - face), height(shape, face, p), -infinity));
  return bound;
}

template <class Deepest>
BestFace<Real> best_face(const Shape& shape, const FaceBounds& bounds, Real least, const Deepest& deepest) {
  FaceBounds bound = bounds;
  BestFace<Real> best = {-1, least, {0, 0, 0}};
  if (shape.faces == 0) return best;
  for (;;) {
    const int highest = first_least(shape.faces, [&](int face) { return -bound.sixteen(face); });
    if (!(bound[highest] > best.separation)) return best;
    const Vector3<Real> vertex = deepest(normal_of(shape, highest));
    const Vector3<floatv> v = splat(vertex);
    for (int face = 0; face < shape.faces; face += lanes)
      store(&bound[face], min(height(shape, face, v), bound.sixteen(face)));
    if (bound[highest] > best.separation) best = {highest, bound[highest], vertex};
    bound[highest] = -infinity;  // it is measured
  }
}

// Edges from `start` along `along`, in a's frame; sixteen can be loaded from any on.
struct Edges {
  int count = 0;
  struct {
    std::array<Real, most_hull_edges + lanes> x, y, z;
    void set(int k, const Vector3<Real>& v) { x[k] = v.x, y[k] = v.y, z[k] = v.z; }
    Vector3<Real> operator[](int k) const { return {x[k], y[k], z[k]}; }
    Vector3<floatv> sixteen(int k) const { return {load(&x[k]), load(&y[k]), load(&z[k])}; }
  } start, along;

  CoreEdge<Real> operator[](int k) const { return {start[k], along[k]}; }
  CoreEdge<floatv> sixteen(int k) const { return {start.sixteen(k), along.sixteen(k)}; }
};

// The edges of a shape that have a face that may separate by more than `least`, each once. A segment has one edge and
// no faces.
template <class Place>
Edges edges_left(const Shape& shape, const FaceBounds& bound, Real least, const Place& place) {
  Edges edges;
  const auto add = [&](int from, int to, bool is_new) {
    const Vector3<Real> start = place(from);
    edges.start.set(edges.count, start);
    edges.along.set(edges.count, place(to) - start);
    edges.count += is_new;
  };
  if (shape.faces == 0 && shape.vertices == 2) add(0, 1, true);
  std::array<std::uint64_t, most_hull_vertices> taken;  // [from]: the set of vertices to which edges go
  std::fill_n(taken.begin(), shape.vertices, 0);
  for (int sixteen = 0; sixteen < shape.faces; sixteen += lanes)
    for (std::uint32_t set = bits(bound.sixteen(sixteen) > least); set != 0; set &= set - 1) {
      const int face = sixteen + std::countr_zero(set);
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
  const Edges edges_a = edges_left(problem.a, bounds_a, least, [&](int k) { return problem.vertices_a[k]; });
  const Edges edges_b = edges_left(problem.b, bounds_b, least, [&](int k) { return problem.vertices_b[k]; });
  const Vector3<floatv> on_a = splat(problem.on_a), on_b = splat(problem.on_b);
  for (int i = 0; i < edges_a.count; ++i) {
    const CoreEdge<Real> edge_a = edges_a[i];
    const CoreEdge<floatv> sixteen_times = {splat(edge_a.start), splat(edge_a.along)};
    for (int k = 0; k < edges_b.count; k += lanes) {
      const auto axes = edge_axis<floatv>(sixteen_times, edges_b.sixteen(k), on_a, on_b, problem.slack,
                                          best.separation + problem.slack);
      const maskv left = (axes.way | axes.other_way) & first_lanes(edges_b.count - k);
      // Few are left. They are measured one after another, as each may make the next one needless.
      for (std::uint32_t set = bits(left); set != 0; set &= set - 1)
        try_edges(problem, edge_a, edges_b[k + std::countr_zero(set)], best);
    }
  }
  try_closest_points(problem, best);
  return best;
}

// Up to sixteen pairs that are near, by their numbers; lanes beyond repeat the first.
void find_sixteen(const Placed<Real>& placed, const HullComponents& components, std::span<const Pair> pairs,
                  std::span<const Simplex> simplex, const Indices& near, int count,
                  std::span<SeparatingAxis<Real>> axes) {
  const PairLanes sixteen = load_pairs(pairs, near);
  const CorePair<floatv> problems = make_problems(placed, sixteen, simplex, near);
  Problem problem;
  for (int l = 0; l < count; ++l) {
    load_shape(placed, components, sixteen.a.index[l], problem.a),
        load_shape(placed, components, sixteen.b.index[l], problem.b);
    take_problem(problems, l, problem);
    axes[near.index[l]] = with_faces(problem, are_apart(problem) ? closest_axis(problem) : deepest_axis(problem));
  }
}

// Pairs that a thread takes at once, at most: enough to fill vectors with those that are near.
constexpr int most_at_once = 256;

}  // namespace

void convex_axes(const Placed<Real>& placed, std::span<const Pair> pairs, std::span<const Simplex> simplex,
                 std::span<const Closest<Real>> closest, Real margin, std::span<SeparatingAxis<Real>> axes) {
  const HullComponents components = components_of(placed, pairs);
  const int count = static_cast<int>(pairs.size()), block = chunk_of(pairs.size(), most_at_once);
  // Axis k is written where pair k is met, and nowhere else. Pairs differ in work, hence dynamic.
#pragma omp parallel for schedule(dynamic)
  for (int first = 0; first < count; first += block) {
    Indices near;
    int found = 0;
    for (int k = first; k < std::min(first + block, count); ++k) {
      const Pair& pair = pairs[k];
      const Real radius_a = placed.colliders.size[pair.a].w, radius_b = placed.colliders.size[pair.b].w;
      if (!(closest[k].distance <= margin + (radius_a + radius_b))) {
        axes[k] = far_apart<Real>;
        continue;
      }
      near.index[found++] = k;
      if (found == lanes) find_sixteen(placed, components, pairs, simplex, near, std::exchange(found, 0), axes);
    }
    if (found == 0) continue;
    for (int l = found; l < lanes; ++l) near.index[l] = near.index[0];
    find_sixteen(placed, components, pairs, simplex, near, found, axes);
  }
}

}  // namespace lockstep::rigid::openmp
