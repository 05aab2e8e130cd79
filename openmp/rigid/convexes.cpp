// Convex against convex: how far apart or how deep, along which normal, and at which points.
//
// How the axis is found, and the points, is told in serial/rigid/convexes.cpp. Here the lanes change sides twice:
//
//   - Sixteen pairs at once, where all pairs do the same: how two colliders stand to one another, what is left of GJK's simplex, and the
//     points. Pairs that are too far apart are left out before, so that lanes are full.
//   - One pair, where each goes a way of its own: which faces are tried and which edges are left. There the lanes are sixteen faces,
//     sixteen vertices, or sixteen edges of b against one of a. Hulls of a dozen vertices or two have about as many faces as two vectors
//     hold; sixteen pairs side by side would all wait for the one that tries most.
//
// The points of sixteen pairs: slots are the same for all, so what the serial loops do to one candidate they do to sixteen, and which are
// candidates at all is in masks. A lane whose polygon has fewer corners than the largest waits.
//
// Source: as in serial/rigid/convexes.cpp; early-outs by masks, [LRB08] Figure 10. The contract stands in common/rigid/narrow_phase.h.
#include "common/rigid/convexes.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/narrow_phase.h"
#include "common/simd.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {
namespace {

constexpr Real infinity = std::numeric_limits<Real>::infinity();
constexpr int face_vectors = (most_hull_faces + lanes - 1) / lanes;

Vector3<Real> vector_of(const Quad<Real>& quad) { return {quad.x, quad.y, quad.z}; }
Vector3<floatv> vector_of(const Quad<floatv>& quad) { return {quad.x, quad.y, quad.z}; }
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

// The hulls of all pairs by component, so that sixteen vertices or faces of one are loaded side by side. A hull is met in many pairs, and
// turned round once. Elements beyond the last repeat it.
struct HullComponents {
  std::vector<std::int32_t> begin;  // [hull]: where its components begin; -1 of what no pair has
  Array<Real> component;            // of a hull: x, y and z of its vertices, then x, y, z and w of its planes, each in whole vectors
};

constexpr int whole(int count) { return (count + lanes - 1) / lanes * lanes; }

HullComponents components_of(const Placed<Real>& placed, std::span<const Pair> pairs) {
  const Hulls<Real>& hulls = placed.hulls;
  HullComponents result;
  result.begin.assign(hulls.count, -1);
  std::vector<std::int32_t> met;
  std::int32_t end = 0;
  for (const auto& [a, b] : pairs)
    for (const int collider : {a, b}) {
      const int hull = placed.colliders.hull[collider];
      if (result.begin[hull] >= 0) continue;
      result.begin[hull] = end;
      met.push_back(hull);
      end += 3 * whole(hulls.vertices(hull)) + 4 * whole(hulls.faces(hull));
    }
  result.component.resize(end);

  // A hull is in `met` once, and its components are its own.
#pragma omp parallel for schedule(static)
  for (const int hull : met) {
    Real* out = &result.component[result.begin[hull]];
    const auto turn_round = [&](const Array<Quad<Real>>& quads, int first, int count, int components) {
      for (int k = 0; k < count; k += lanes) {
        Indices indices;
        store(indices.index, min(lane_index() + k, intv(count - 1)) + first);
        const auto [x, y, z, w] = load_quad(quads, indices);
        const floatv component[] = {x, y, z, w};
        for (int c = 0; c < components; ++c) store(out + c * whole(count) + k, component[c]);
      }
      out += components * whole(count);
    };
    turn_round(hulls.vertex, hulls.first_vertex[hull], hulls.vertices(hull), 3);
    turn_round(hulls.plane, hulls.first_face[hull], hulls.faces(hull), 4);
  }
  return result;
}

// A collider's hull.
struct Shape {
  int vertices, faces;
  const Real* vertex;                // as it stands in the library; x, y, z
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
  Vector3<Real> normal(int face) const {
    const int stride = whole(faces);
    return {plane[face], plane[stride + face], plane[2 * stride + face]};
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

// How high a point of the shape's frame is above a face, and above sixteen.
Real height(const Shape& shape, int face, const Vector3<Real>& point) { return dot(shape.normal(face), point) - shape.distance[face]; }
floatv height(const Shape& shape, int face, const Vector3<floatv>& point) {
  return dot(shape.sixteen_normals(face), point) - load(shape.distance + face);
}

// The first of the elements that have the least value; `value` gives sixteen from an element on.
template <class Value>
int first_least(int count, const Value& value) {
  std::array<floatv, face_vectors> values;
  floatv least = values[0] = value(0);
  for (int k = lanes; k < count; k += lanes) {
    values[k / lanes] = value(k);
    least = min(least, values[k / lanes]);
  }
  const floatv bound = reduce_min(least);
  for (int k = 0;; k += lanes)
    if (const maskv equal = values[k / lanes] == bound; any(equal)) return k + std::countr_zero(bits(equal));
}

// The vertex that is lowest along a direction (brought into the hull's frame); the first of equals.
int lowest(const Shape& shape, const Vector3<Real>& direction) {
  const Vector3<floatv> d = splat(direction);
  return first_least(shape.vertices, [&](int k) { return dot(d, shape.sixteen_vertices(k)); });
}

// The face that looks most along a direction of the shape's frame; the first of equals; -1 if there is none.
struct Facing {
  int face;
  Real cosine;
};
Facing facing(const Shape& shape, const Vector3<Real>& direction) {
  if (shape.faces == 0) return {-1, -infinity};
  const Vector3<floatv> d = splat(direction);
  const int face = first_least(shape.faces, [&](int face) { return -dot(d, shape.sixteen_normals(face)); });
  return {face, dot(direction, shape.normal(face))};
}

// Two colliders, in a's frame.
struct Problem {
  Cores<Real> cores;
  Shape a, b;
  Real slack, touching;      // m
  Vector3<Real> on_a, on_b;  // points of the cores: the closest, or where they overlap, the same within rounding
  Vector3<Real> between;     // from the one to the other

  PlacedVertices vertices_a, vertices_b;

  Vector3<Real> vertex_a(int k) const { return vertices_a[k]; }
  Vector3<Real> vertex_b(int k) const { return vertices_b[k]; }
  Vector3<Real> in_b(const Vector3<Real>& point) const { return transposed_times(cores.turn, point - cores.offset); }
  // The vertices that are lowest along a direction.
  Vector3<Real> lowest_a(const Vector3<Real>& direction) const { return vertex_a(lowest(a, direction_in_a(cores, direction))); }
  Vector3<Real> lowest_b(const Vector3<Real>& direction) const { return vertex_b(lowest(b, direction_in_b(cores, direction))); }
};

// Sixteen problems, but for the shapes.
struct ProblemLanes {
  Cores<floatv> cores;
  floatv slack, touching;
  Vector3<floatv> on_a, on_b, between;
};

void take_problem(const ProblemLanes& p, int l, Problem& problem) {
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

// Which hulls sixteen pairs are of, and where in the library their vertices and faces begin.
struct HullLanes {
  Indices hull, first_vertex, first_face;
};
HullLanes load_hulls(const Placed<Real>& placed, const Indices& colliders) {
  HullLanes result;
  for (int l = 0; l < lanes; ++l) {
    const int hull = placed.colliders.hull[colliders.index[l]];
    result.hull.index[l] = hull;
    result.first_vertex.index[l] = placed.hulls.first_vertex[hull];
    result.first_face.index[l] = placed.hulls.first_face[hull];
  }
  return result;
}

// Vertices of sixteen hulls, by their numbers within them.
Vector3<floatv> load_vertices(const Placed<Real>& placed, const HullLanes& of, intv number) {
  Indices indices;
  store(indices.index, load(of.first_vertex.index) + number);
  return vector_of(load_quad(placed.hulls.vertex, indices));
}

ProblemLanes make_problems(const Placed<Real>& placed, const PairLanes& pairs, const HullLanes& hulls_a, const HullLanes& hulls_b,
                           const std::array<const Simplex*, lanes>& simplex) {
  const auto& [colliders, hulls, pose] = placed;
  const Pose<floatv> a = load_pose(pose, pairs.a), b = load_pose(pose, pairs.b);
  ProblemLanes problem;
  problem.cores = make_cores(vector_of(load_quad(colliders.size, pairs.a)), vector_of(load_quad(colliders.size, pairs.b)), a.position,
                             b.position, a.orientation, b.orientation);
  const floatv reach =
      reach_of(problem.cores, vector_of(load_quad(hulls.centre, hulls_a.hull)), vector_of(load_quad(hulls.half, hulls_a.hull)),
               vector_of(load_quad(hulls.centre, hulls_b.hull)), vector_of(load_quad(hulls.half, hulls_b.hull)));
  problem.slack = slack_per_reach<Real> * reach;
  problem.touching = touching * reach;

  Vector3<floatv> of_a[4], of_b[4], corner[4];
  Indices count, number_a, number_b;
  for (int l = 0; l < lanes; ++l) count.index[l] = simplex[l]->count;
  for (int k = 0; k < 4; ++k) {
    for (int l = 0; l < lanes; ++l) number_a.index[l] = simplex[l]->a[k], number_b.index[l] = simplex[l]->b[k];
    of_a[k] = vertex_of_a(problem.cores, load_vertices(placed, hulls_a, load(number_a.index)));
    of_b[k] = vertex_of_b(problem.cores, load_vertices(placed, hulls_b, load(number_b.index)));
    corner[k] = of_b[k] - of_a[k];
  }
  const intv corners = load(count.index);
  const auto [weight, point] = nearest_between(corners == 2, corners == 3, corners == 4, corner);
  problem.on_a = weight[0] * of_a[0] + weight[1] * of_a[1] + weight[2] * of_a[2] + weight[3] * of_a[3];
  problem.on_b = weight[0] * of_b[0] + weight[1] * of_b[1] + weight[2] * of_b[2] + weight[3] * of_b[3];
  problem.between = point;
  return problem;
}

// An axis from a to b, how far it separates the cores, and the point midway where they are nearest along it.
struct Axis {
  Vector3<Real> normal;
  Real separation;
  Vector3<Real> middle;
  int face_a = -1, face_b = -1;  // whose normal it is, if it is
};

// How far an axis separates the cores. Along an axis from face to vertex or edge to edge, that is how far these are apart.
Real separation_along(const Problem& problem, const Vector3<Real>& axis) {
  return dot(axis, problem.lowest_b(axis)) - dot(axis, problem.lowest_a(-axis));
}

// No axis of a face separates by more than the least height of a point of the other core above it. Lanes beyond the last face are below
// everything.
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

// Which face of a shape separates most, if by more than `least`, and the other core's vertex that is deepest below it. `deepest` finds
// that along a direction, all in the shape's frame.
struct BestFace {
  int face;
  Real separation;
  Vector3<Real> vertex;
};
template <class Deepest>
BestFace best_face(const Shape& shape, const FaceBounds& bounds, Real least, const Deepest& deepest) {
  FaceBounds bound = bounds;
  BestFace best = {-1, least, {0, 0, 0}};
  if (shape.faces == 0) return best;
  for (;;) {
    const int highest = first_least(shape.faces, [&](int face) { return -bound.sixteen(face); });
    if (!(bound[highest] > best.separation)) return best;
    const Vector3<Real> vertex = deepest(shape.normal(highest));
    const Vector3<floatv> v = splat(vertex);
    for (int face = 0; face < shape.faces; face += lanes) store(&bound[face], min(height(shape, face, v), bound.sixteen(face)));
    if (bound[highest] > best.separation) best = {highest, bound[highest], vertex};
    bound[highest] = -infinity;  // is measured
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
};

// The edges of a shape that have a face that may separate by more than `least`, each once. A segment has one edge and no faces.
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

// The middle of where two lines are closest, as far as their edges go. They are not parallel.
Vector3<Real> middle_of_edges(const Vector3<Real>& start_a, const Vector3<Real>& along_a, const Vector3<Real>& start_b,
                              const Vector3<Real>& along_b) {
  const Vector3<Real> between = start_b - start_a, normal = cross(along_a, along_b);
  const Real per_square = 1 / dot(normal, normal);
  const Real s = dot(cross(between, along_b), normal) * per_square, t = dot(cross(between, along_a), normal) * per_square;
  const Vector3<Real> on_a = start_a + min(max(s, 0), 1) * along_a, on_b = start_b + min(max(t, 0), 1) * along_b;
  return Real(.5) * (on_a + on_b);
}

// The axis that separates most, of cores that overlap or touch.
Axis deepest_axis(const Problem& problem) {
  const auto& [cores, a, b, its_slack, touching, on_a, on_b, between, vertices_a, vertices_b] = problem;
  const Real slack = its_slack;  // not the binding itself, which clang 14 lets no lambda capture
  Axis best = {{0, 0, 0}, -infinity, {0, 0, 0}};

  // Faces. b's must be better by more than rounding, so that of two alike a's is taken, step after step.
  const FaceBounds bound_a = face_bounds(a, on_b), bound_b = face_bounds(b, problem.in_b(on_a));
  const BestFace face_a = best_face(a, bound_a, best.separation, [&](const Vector3<Real>& n) { return problem.lowest_b(n); });
  if (face_a.face >= 0) {
    const Vector3<Real> normal = a.normal(face_a.face);
    best = {normal, face_a.separation, face_a.vertex - (Real(.5) * face_a.separation) * normal, face_a.face};
  }
  const BestFace face_b = best_face(b, bound_b, best.separation + slack,
                                    [&](const Vector3<Real>& n) { return problem.in_b(problem.lowest_a(problem.cores.turn * n)); });
  if (face_b.face >= 0) {
    const Vector3<Real> normal = cores.turn * b.normal(face_b.face);
    best = {-normal, face_b.separation, cores.turn * face_b.vertex + cores.offset - (Real(.5) * face_b.separation) * normal, -1,
            face_b.face};
  }

  // Edges, where they are better again. Along an axis of two, on_a is not beyond a's edge, nor on_b before b's.
  const Real least = min(best.separation, 0);
  const Edges edges_a = edges_left(a, bound_a, least, [&](int k) { return problem.vertex_a(k); });
  const Edges edges_b = edges_left(b, bound_b, least, [&](int k) { return problem.vertex_b(k); });
  for (int i = 0; i < edges_a.count; ++i) {
    const Vector3<Real> start_a = edges_a.start[i], along_a = edges_a.along[i];
    const Real beyond_2 = parallel_2 * dot(along_a, along_a);
    for (int k = 0; k < edges_b.count; k += lanes) {
      const Vector3<floatv> start_b = edges_b.start.sixteen(k), along_b = edges_b.along.sixteen(k);
      const Vector3<floatv> normal = cross(splat(along_a), along_b);
      const floatv square = dot(normal, normal), length = sqrt(square);
      const floatv apart = dot(normal, start_b - splat(start_a)), before_a = dot(normal, splat(start_a - on_a)),
                   after_b = dot(normal, splat(on_b) - start_b);
      const floatv away = slack * length, enough = (best.separation + slack) * length;
      const maskv way = (before_a >= -away) & (after_b >= -away) & (apart > enough);
      const maskv other_way = (before_a <= away) & (after_b <= away) & (-apart > enough);
      const maskv left = (way | other_way) & (square > beyond_2 * dot(along_b, along_b)) & first_lanes(edges_b.count - k);
      // Few are left. They are measured one after another, as each may make the next one needless.
      for (std::uint32_t set = bits(left); set != 0; set &= set - 1) {
        const int l = std::countr_zero(set);
        const Real enough_now = (best.separation + slack) * at(length, l);
        const auto measure = [&](const Vector3<Real>& axis, Real between_edges) {
          const Real separation = separation_along(problem, axis);
          const bool are_deepest = between_edges <= separation + apart_slacks * slack;  // these two edges, and not others parallel to them
          if ((separation > best.separation + slack) & are_deepest)
            best = {axis, separation, middle_of_edges(start_a, along_a, edges_b.start[k + l], edges_b.along[k + l])};
        };
        const Real per_length = 1 / at(length, l), apart_l = at(apart, l);
        const bool this_way = (bits(way) >> l & 1) != 0 && apart_l > enough_now,
                   that_way = (bits(other_way) >> l & 1) != 0 && -apart_l > enough_now;
        if (this_way) measure(per_length * at(normal, l), per_length * apart_l);
        if (that_way) measure(-per_length * at(normal, l), -per_length * apart_l);
      }
    }
  }

  // Corners that all but touch: the line between them.
  const Real distance_2 = dot(between, between);
  if (distance_2 > slack * slack) {
    const Vector3<Real> axis = (1 / sqrt(distance_2)) * between;
    const Real separation = separation_along(problem, axis);
    if (separation > best.separation + slack) best = {axis, separation, Real(.5) * (on_a + on_b)};
  }
  return best;
}

// The line between the closest points of cores that are apart. Where a face separates as far, within rounding, its normal is the better:
// it comes from no difference.
Axis closest_axis(const Problem& problem) {
  const auto& [cores, a, b, slack, touching, on_a, on_b, between, vertices_a, vertices_b] = problem;
  const Real distance = sqrt(dot(between, between));
  Axis best = {(1 / distance) * between, distance, Real(.5) * (on_a + on_b)};
  const Facing face_a = facing(a, best.normal), face_b = facing(b, -transposed_times(cores.turn, best.normal));
  if (face_a.cosine > least_cosine) {
    const Vector3<Real> normal = a.normal(face_a.face);
    if (height(a, face_a.face, problem.lowest_b(normal)) >= distance - slack) {
      best.normal = normal, best.face_a = face_a.face;
      return best;
    }
  }
  if (face_b.cosine > least_cosine) {
    const Vector3<Real> normal = cores.turn * b.normal(face_b.face);
    if (height(b, face_b.face, problem.in_b(problem.lowest_a(normal))) >= distance - slack)
      best.normal = -normal, best.face_b = face_b.face;
  }
  return best;
}

// The axis of a pair, and the faces that look most along it.
struct Contact {
  Axis axis;
  Facing face_a, face_b;
};
Contact contact_of(const Problem& problem) {
  const bool apart = dot(problem.between, problem.between) > problem.touching * problem.touching;
  const Axis axis = apart ? closest_axis(problem) : deepest_axis(problem);
  const Vector3<Real> back = -transposed_times(problem.cores.turn, axis.normal);
  return {axis, axis.face_a >= 0 ? Facing{axis.face_a, 1} : facing(problem.a, axis.normal),
          axis.face_b >= 0 ? Facing{axis.face_b, 1} : facing(problem.b, back)};
}

// The polygon of a shape that supports the normal: of a face, counterclockwise from outside; a segment or a point is its own.
struct Polygon {
  intv count;
  int most;  // of any lane
  std::array<Vector3<floatv>, most_hull_vertices> corner;

  Vector3<floatv> next(int k) const { return k + 1 < most ? select(intv(k + 1) < count, corner[k + 1], corner[0]) : corner[0]; }
};
// Of the faces of sixteen shapes, and how many corners each has.
struct Faces {
  const HullLanes& hulls;
  maskv is_face;
  intv first, count;

  intv number(const Placed<Real>& placed, int k) const {
    const intv one = min(intv(k), count - 1);
    return select(is_face, gather(placed.hulls.corner.data(), first + one, is_face), one);
  }
};
Faces load_faces(const Placed<Real>& placed, const HullLanes& hulls, intv face) {
  const maskv is_face = face >= 0;
  const intv index = load(hulls.first_face.index) + face;
  const intv first = gather(placed.hulls.first_corner.data(), index, is_face);
  Indices hull;
  store(hull.index, load(hulls.hull.index));
  const std::int32_t* const first_vertex = placed.hulls.first_vertex.data();
  const intv vertices = gather(first_vertex + 1, load(hull.index)) - gather(first_vertex, load(hull.index));
  return {hulls, is_face, first, select(is_face, gather(placed.hulls.first_corner.data() + 1, index, is_face) - first, vertices)};
}

// Planes of faces, in the shape's frame; of what has no face, zero.
Quad<floatv> planes_of(const Placed<Real>& placed, const HullLanes& hulls, intv face, const Vector3<floatv>& scale) {
  const maskv is_face = face >= 0;
  Indices indices;
  store(indices.index, select(is_face, load(hulls.first_face.index) + face, 0));
  const auto [x, y, z, w] = load_quad(placed.hulls.plane, indices);
  const floatv distance = select(load(hulls.hull.index) == cube_hull, dot(absolute(Vector3<floatv>{x, y, z}), scale), w);
  return {select(is_face, x, 0.f), select(is_face, y, 0.f), select(is_face, z, 0.f), select(is_face, distance, 0.f)};
}

int most_of(intv v, maskv mask) { return static_cast<int>(reduce_max(to_float(select(mask, v, 0)))); }

// What may become a point of the manifold.
struct Candidates {
  int count = 0;
  std::array<maskv, most_candidates> valid;
  std::array<Vector3<floatv>, most_candidates> middle;  // between the cores
  std::array<floatv, most_candidates> separation;       // of the cores
  std::array<int, most_candidates> slot;

  void add(maskv is_valid, const Vector3<floatv>& position, floatv distance, int from) {
    valid[count] = is_valid, middle[count] = position, separation[count] = distance, slot[count++] = from;
  }
};

// The incident polygon against the reference, which looks along `out`, towards it. A plane of a face: its normal, and the distance of the
// origin from it.
void clip(maskv mask, const Polygon& reference, const Quad<floatv>& reference_plane, const Polygon& incident,
          const Quad<floatv>& incident_plane, const Vector3<floatv>& out, floatv slack, Candidates& candidates) {
  // Sides stand on the edges, along `out`; what is beyond one by no more than rounding is within.
  std::array<Vector3<floatv>, most_hull_vertices> side;
  std::array<floatv, most_hull_vertices> border;
  for (int k = 0; k < reference.most; ++k) {
    const Vector3<floatv>&from = reference.corner[k], to = reference.next(k);
    side[k] = cross(to - from, out);
    border[k] = dot(side[k], from) + slack * taxicab(side[k]);
  }

  const floatv per_cosine = 1.f / dot(vector_of(reference_plane), out);
  for (int j = 0; j < incident.most; ++j) {
    const Vector3<floatv>&from = incident.corner[j], to = incident.next(j);
    const Vector3<floatv> along = to - from;
    floatv enter = 0.f, leave = 1.f;
    maskv outside = first_lanes(0);
    for (int k = 0; k < reference.most; ++k) {
      const maskv is_side = intv(k) < reference.count;
      const floatv beyond = dot(side[k], from) - border[k], slope = dot(side[k], along);
      const floatv crossing = -beyond / select(slope == 0.f, 1.f, slope);
      enter = select(is_side & (slope < 0.f), max(crossing, enter), enter);
      leave = select(is_side & (slope > 0.f), min(crossing, leave), leave);
      outside = outside | (is_side & (slope == 0.f) & (beyond > 0.f));
    }
    const maskv is_edge = mask & (intv(j) < min(incident.count, select(incident.count == 2, 1, incident.count)));
    const maskv within = is_edge & ~outside & (enter <= leave);
    const auto add = [&](maskv valid, floatv where, int slot) {
      const Vector3<floatv> point = from + where * along;
      const floatv separation = (dot(vector_of(reference_plane), point) - reference_plane.w) * per_cosine;
      candidates.add(valid, point - (.5f * separation) * out, separation, slot);
    };
    // Where it leaves at its end, the next edge enters, unless this is a segment.
    add(within, enter, 2 * j);
    add(within & ((leave < 1.f) | (incident.count == 2)), leave, 2 * j + 1);
  }

  if (incident.most < 3) return;
  const floatv cosine = -dot(vector_of(incident_plane), out), per_incident_cosine = 1.f / max(cosine, floatv(least_incident_cosine));
  for (int k = 0; k < reference.most; ++k) {
    const Vector3<floatv>& corner = reference.corner[k];
    maskv within = mask & (intv(k) < reference.count) & (incident.count >= 3) & (cosine > least_incident_cosine);
    for (int j = 0; j < incident.most; ++j) {
      const Vector3<floatv>&from = incident.corner[j], to = incident.next(j);
      const Vector3<floatv> out_of_edge = cross(out, to - from);
      within = within & ((intv(j) >= incident.count) | (dot(out_of_edge, corner - from) < -slack * taxicab(out_of_edge)));
    }
    const floatv separation = (dot(vector_of(incident_plane), corner) - incident_plane.w) * per_incident_cosine;
    candidates.add(within, corner + (.5f * separation) * out, separation, slot_of_corner + k);
  }
}

// Up to four of the candidates: the deepest; the farthest from it; the farthest from the line through both, to either side.
struct Chosen {
  maskv valid;
  Vector3<floatv> middle;
  floatv separation;
  intv slot;
};
std::array<Chosen, most_points> choose(const Candidates& candidates, const Vector3<floatv>& normal, floatv least_apart) {
  // The valid candidate of the greatest value, if that is greater than `least`; the first of equals.
  const auto greatest = [&](maskv wanted, floatv least, const auto& value) {
    Chosen best = {first_lanes(0), {0.f, 0.f, 0.f}, 0.f, 0};
    for (int k = 0; k < candidates.count; ++k) {
      const floatv v = value(k);
      const maskv better = wanted & candidates.valid[k] & (v > least);
      least = select(better, v, least);
      best = {best.valid | better, select(better, candidates.middle[k], best.middle),
              select(better, candidates.separation[k], best.separation), select(better, candidates.slot[k], best.slot)};
    }
    return best;
  };
  const Chosen deepest = greatest(first_lanes(lanes), -infinity, [&](int k) { return -candidates.separation[k]; });
  const Vector3<floatv>& origin = deepest.middle;
  const Chosen farthest = greatest(deepest.valid, least_apart * least_apart, [&](int k) {
    const Vector3<floatv> away = candidates.middle[k] - origin;
    return dot(away, away);
  });
  const Vector3<floatv> along = farthest.middle - origin, across = cross(normal, along);
  const floatv least = least_apart * sqrt(dot(along, along));
  const Chosen left = greatest(farthest.valid, least, [&](int k) { return dot(across, candidates.middle[k] - origin); });
  const Chosen right = greatest(farthest.valid, least, [&](int k) { return -dot(across, candidates.middle[k] - origin); });
  // Three are the first three.
  const maskv both = left.valid & right.valid;
  const Chosen third = {left.valid | right.valid, select(left.valid, left.middle, right.middle),
                        select(left.valid, left.separation, right.separation), select(left.valid, left.slot, right.slot)};
  return {deepest, farthest, third, {both, right.middle, right.separation, right.slot}};
}

// The contacts of sixteen pairs.
struct ContactLanes {
  struct {
    alignas(array_alignment) Real x[lanes], y[lanes], z[lanes];
    void set(int l, const Vector3<Real>& v) { x[l] = v.x, y[l] = v.y, z[l] = v.z; }
    Vector3<floatv> sixteen() const { return {load(x), load(y), load(z)}; }
  } normal, middle;
  alignas(array_alignment) Real separation[lanes], cosine_a[lanes], cosine_b[lanes];
  Indices face_a, face_b;

  void set(int l, const Contact& contact) {
    normal.set(l, contact.axis.normal), middle.set(l, contact.axis.middle);
    separation[l] = contact.axis.separation;
    cosine_a[l] = contact.face_a.cosine, cosine_b[l] = contact.face_b.cosine;
    face_a.index[l] = contact.face_a.face, face_b.index[l] = contact.face_b.face;
  }
};

// The points that hold the two apart along the axis.
ManifoldLanes manifolds_of(const Placed<Real>& placed, const ProblemLanes& problem, const PairLanes& pairs, const HullLanes& hulls_a,
                           const HullLanes& hulls_b, const ContactLanes& contact, floatv radius_a, floatv radius_b, Real margin) {
  const auto& [cores, slack, touching, on_a, on_b, between] = problem;
  const Vector3<floatv> normal = contact.normal.sixteen();
  const floatv axis_separation = load(contact.separation), cosine_a = load(contact.cosine_a), cosine_b = load(contact.cosine_b);
  const intv face_a = load(contact.face_a.index), face_b = load(contact.face_b.index);

  Candidates candidates;
  const maskv of_b = cosine_b - preference > cosine_a;
  const maskv clipped = max(cosine_a, cosine_b) > least_cosine;
  if (any(clipped)) {
    const Quad<floatv> plane_a = planes_of(placed, hulls_a, face_a, cores.scale_a),
                       plane = planes_of(placed, hulls_b, face_b, cores.scale_b);
    const Vector3<floatv> turned = cores.turn * vector_of(plane);
    const Quad<floatv> plane_b = {turned.x, turned.y, turned.z, plane.w + dot(turned, cores.offset)};
    const Faces faces_a = load_faces(placed, hulls_a, face_a), faces_b = load_faces(placed, hulls_b, face_b);
    Polygon reference, incident;
    reference.count = select(of_b, faces_b.count, faces_a.count), incident.count = select(of_b, faces_a.count, faces_b.count);
    reference.most = most_of(reference.count, clipped), incident.most = most_of(incident.count, clipped);
    for (int k = 0; k < std::max(reference.most, incident.most); ++k) {
      const Vector3<floatv> corner_a = vertex_of_a(cores, load_vertices(placed, hulls_a, faces_a.number(placed, k)));
      const Vector3<floatv> corner_b = vertex_of_b(cores, load_vertices(placed, hulls_b, faces_b.number(placed, k)));
      reference.corner[k] = select(of_b, corner_b, corner_a), incident.corner[k] = select(of_b, corner_a, corner_b);
    }
    const auto choose_plane = [&](const Quad<floatv>& b, const Quad<floatv>& a) {
      return Quad<floatv>{select(of_b, b.x, a.x), select(of_b, b.y, a.y), select(of_b, b.z, a.z), select(of_b, b.w, a.w)};
    };
    clip(clipped, reference, choose_plane(plane_b, plane_a), incident, choose_plane(plane_a, plane_b), select(of_b, -normal, normal), slack,
         candidates);
  }

  // Where the faces do not hold the deepest points, those are one more.
  const floatv radii = radius_a + radius_b;
  floatv deepest = infinity;
  for (int k = 0; k < candidates.count; ++k) {
    deepest = select(candidates.valid[k], min(candidates.separation[k], deepest), deepest);
    candidates.valid[k] = candidates.valid[k] & (candidates.separation[k] - radii <= margin);
  }
  candidates.add((axis_separation - radii <= margin) & (deepest > axis_separation + 4.f * slack), contact.middle.sixteen(), axis_separation,
                 slot_of_closest);

  const std::array<Chosen, most_points> chosen = choose(candidates, normal, apart_slacks * slack);
  ManifoldLanes manifold;
  manifold.normal = cores.from_a * normal;
  manifold.count = 0;
  manifold.a = load(pairs.a.index), manifold.b = load(pairs.b.index);
  const intv reference = max(select(of_b, face_b, face_a), 0), incident = max(select(of_b, face_a, face_b), 0);
  const Vector3<floatv> to_middle = (.5f * (radius_a - radius_b)) * normal;
  for (int k = 0; k < most_points; ++k) {
    const Chosen& c = chosen[k];
    const Vector3<floatv> position = in_world(cores, c.middle + to_middle);
    manifold.count = manifold.count + select(c.valid, intv(1), intv(0));
    manifold.position[k] = select(c.valid, position, {0.f, 0.f, 0.f});
    manifold.separation[k] = select(c.valid, c.separation - radii, 0.f);
    manifold.feature[k] = select(c.valid, feature_of(select(of_b, intv(1), intv(0)), reference, incident, c.slot), 0);
  }
  return manifold;
}

// Up to sixteen pairs that are near, by their numbers; lanes beyond repeat the first.
void collide_sixteen(const Placed<Real>& placed, const HullComponents& components, std::span<const Pair> pairs, Real margin,
                     std::span<const Simplex> simplex, const Indices& near, int count, std::span<Manifold<Real>> manifolds) {
  PairLanes sixteen;
  std::array<const Simplex*, lanes> start;
  for (int l = 0; l < lanes; ++l) {
    const int k = near.index[l];
    sixteen.a.index[l] = pairs[k].a, sixteen.b.index[l] = pairs[k].b;
    start[l] = &simplex[k];
  }
  const HullLanes hulls_a = load_hulls(placed, sixteen.a), hulls_b = load_hulls(placed, sixteen.b);
  const ProblemLanes problems = make_problems(placed, sixteen, hulls_a, hulls_b, start);
  ContactLanes contacts;
  Problem problem;
  Contact contact;
  for (int l = 0; l < lanes; ++l) {
    if (l < count) {
      load_shape(placed, components, sixteen.a.index[l], problem.a), load_shape(placed, components, sixteen.b.index[l], problem.b);
      take_problem(problems, l, problem);
      contact = contact_of(problem);
    }
    contacts.set(l, contact);
  }
  const floatv radius_a = load_quad(placed.colliders.size, sixteen.a).w, radius_b = load_quad(placed.colliders.size, sixteen.b).w;
  const ManifoldLanes manifold = manifolds_of(placed, problems, sixteen, hulls_a, hulls_b, contacts, radius_a, radius_b, margin);
  store_manifolds(manifolds, near, manifold, first_lanes(count));
}

// Pairs that a thread takes at once: enough to fill vectors with those that are near.
constexpr int block = 256;

}  // namespace

void convexes(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin, std::span<Simplex> simplex,
              std::span<Manifold<Real>> manifolds) {
  Array<Closest<Real>> closest(pairs.size());
  closest_points(placed, pairs, simplex, closest);
  const HullComponents components = components_of(placed, pairs);
  const int count = static_cast<int>(pairs.size());
  // Manifold k is written where pair k is met, and nowhere else. Pairs differ in work, hence dynamic.
#pragma omp parallel for schedule(dynamic)
  for (int first = 0; first < count; first += block) {
    Indices near;
    int found = 0;
    for (int k = first; k < std::min(first + block, count); ++k) {
      const Pair& pair = pairs[k];
      const Real radius_a = placed.colliders.size[pair.a].w, radius_b = placed.colliders.size[pair.b].w;
      if (!(closest[k].distance <= margin + (radius_a + radius_b))) {
        manifolds[k] = {};
        manifolds[k].a = pair.a, manifolds[k].b = pair.b;
        continue;
      }
      near.index[found++] = k;
      if (found == lanes) collide_sixteen(placed, components, pairs, margin, simplex, near, std::exchange(found, 0), manifolds);
    }
    if (found == 0) continue;
    for (int l = found; l < lanes; ++l) near.index[l] = near.index[0];
    collide_sixteen(placed, components, pairs, margin, simplex, near, found, manifolds);
  }
}

}  // namespace lockstep::rigid::openmp
