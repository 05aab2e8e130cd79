// Convex against convex: how far apart or how deep, along which normal, and at which points.
//
// The distance of two cores comes from GJK. Where they overlap, or all but touch, the normal is the axis along which they overlap least:
// one of the normals of a's faces, of b's, or a cross product of two edges, for these are what the faces of the difference of two polytopes
// have as normals. Trying all is exact and knows no degenerate cases, where polytopes that are expanded towards the difference (EPA) have
// flat and needle-like faces to trip over; but of edges alone there would be thousands of pairs. What makes it cheap is one point that both
// cores have, which GJK knows. Along an axis that separates the cores by s <= 0, no point of b, so not the common one, is lower than s
// above where a ends. So a face that the common point is deeper below than the best axis so far is deep is out; and so is an edge between
// two such faces, as along any axis between their normals the point is as deep. Of millimetres of overlap a handful of faces and edges is
// left. That the bounds hold needs no more than that the point is of the core; how many axes are left depends on it, what comes out does
// not.
//
// The faces are tried as cutting planes are: the one with the highest bound is measured, by the vertex of the other core that is deepest
// below it; this vertex bounds all other faces, too; until no bound is higher than what was measured.
//
// The points: the faces of a and b that support the normal best are clipped against one another. Every edge of the one (incident) is cut by
// the planes through the sides of the other (reference), by Cyrus and Beck; where it enters and leaves are points, and so are corners of
// the reference that have the incident face above. Each has a slot of its own; there are no lists.
//
// Source: separating axes of polytopes, Gottschalk, Lin and Manocha, SIGGRAPH 1996; Gregorius, The Separating Axis Test between Convex
//         Polyhedra, GDC 2013; clipping, Cyrus and Beck, Computers & Graphics 3 (1978). The bounds by a common point are ours. The contract
//         stands in common/rigid/narrow_phase.h.
#include "common/rigid/convexes.h"

#include <algorithm>
#include <array>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/narrow_phase.h"

namespace lockstep::rigid::serial {
namespace {

constexpr Real infinity = std::numeric_limits<Real>::infinity();

Vector3<Real> vector_of(const Quad<Real>& quad) { return {quad.x, quad.y, quad.z}; }

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

// The distance of a face from the origin. Of shapes with faces only the cube is scaled, and its normals are its axes: they stay.
Real distance_of(const Shape& shape, int face) {
  return shape.cube ? dot(absolute(vector_of(shape.plane[face])), shape.scale) : shape.plane[face].w;
}

// How high a point of the shape's frame is above a face.
Real height(const Shape& shape, int face, const Vector3<Real>& point) {
  return dot(vector_of(shape.plane[face]), point) - distance_of(shape, face);
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

// The face that looks most along a direction of the shape's frame; the first of equals; -1 if there is none.
struct Facing {
  int face;
  Real cosine;
};
Facing facing(const Shape& shape, const Vector3<Real>& direction) {
  Facing best = {-1, -infinity};
  for (int face = 0; face < shape.faces; ++face) {
    const Real cosine = dot(direction, vector_of(shape.plane[face]));
    if (cosine > best.cosine) best = {face, cosine};
  }
  return best;
}

// Two colliders, in a's frame.
struct Problem {
  Cores<Real> cores;
  Shape a, b;
  Real slack, touching;      // m
  Vector3<Real> on_a, on_b;  // points of the cores: the closest, or where they overlap, the same within rounding
  Vector3<Real> between;     // from the one to the other

  Vector3<Real> vertex_a(int k) const { return vertex_of_a(cores, vector_of(a.vertex[k])); }
  Vector3<Real> vertex_b(int k) const { return vertex_of_b(cores, vector_of(b.vertex[k])); }
  Vector3<Real> in_b(const Vector3<Real>& point) const { return transposed_times(cores.turn, point - cores.offset); }
  // The vertices that are lowest along a direction.
  Vector3<Real> lowest_a(const Vector3<Real>& direction) const { return vertex_a(lowest(a, direction_in_a(cores, direction))); }
  Vector3<Real> lowest_b(const Vector3<Real>& direction) const { return vertex_b(lowest(b, direction_in_b(cores, direction))); }
};

Problem make_problem(const Placed<Real>& placed, const Pair& pair, const Simplex& simplex) {
  const auto& [colliders, hulls, pose] = placed;
  const int hull_a = colliders.hull[pair.a], hull_b = colliders.hull[pair.b];
  const Pose<Real>&a = pose[pair.a], &b = pose[pair.b];
  const Shape shape_a = shape_of(placed, pair.a), shape_b = shape_of(placed, pair.b);
  Problem problem = {
      make_cores(shape_a.scale, shape_b.scale, a.position, b.position, a.orientation, b.orientation), shape_a, shape_b, {}, {}, {}, {}, {}};
  const Real reach = reach_of(problem.cores, vector_of(hulls.centre[hull_a]), vector_of(hulls.half[hull_a]),
                              vector_of(hulls.centre[hull_b]), vector_of(hulls.half[hull_b]));
  problem.slack = slack_per_reach<Real> * reach;
  problem.touching = touching * reach;

  Vector3<Real> of_a[4], of_b[4], corner[4];
  for (int k = 0; k < 4; ++k) {
    of_a[k] = problem.vertex_a(simplex.a[k]);
    of_b[k] = problem.vertex_b(simplex.b[k]);
    corner[k] = of_b[k] - of_a[k];
  }
  const auto [weight, point] = nearest_between(simplex.count == 2, simplex.count == 3, simplex.count == 4, corner);
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

// No axis of a face separates by more than the least height of a point of the other core above it.
using FaceBounds = std::array<Real, most_hull_faces>;

FaceBounds face_bounds(const Shape& shape, const Vector3<Real>& point) {
  FaceBounds bound;
  for (int face = 0; face < shape.faces; ++face) bound[face] = height(shape, face, point);
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
  for (;;) {
    int highest = -1;
    for (int face = 0; face < shape.faces; ++face)
      if (highest < 0 || bound[face] > bound[highest]) highest = face;
    if (highest < 0 || !(bound[highest] > best.separation)) return best;
    const Vector3<Real> vertex = deepest(vector_of(shape.plane[highest]));
    for (int face = 0; face < shape.faces; ++face) bound[face] = min(height(shape, face, vertex), bound[face]);
    if (bound[highest] > best.separation) best = {highest, bound[highest], vertex};
    bound[highest] = -infinity;  // is measured
  }
}

// Edges from `start` along `along`, in a's frame.
struct Edges {
  int count = 0;
  std::array<Vector3<Real>, most_hull_edges + 1> start, along;  // one beyond, which is written but not counted
};

// The edges of a shape that have a face that may separate by more than `least`, each once. A segment has one edge and no faces.
template <class Place>
Edges edges_left(const Shape& shape, const FaceBounds& bound, Real least, const Place& place) {
  Edges edges;
  const auto add = [&](int from, int to, bool is_new) {
    const Vector3<Real> start = place(from);
    edges.start[edges.count] = start;
    edges.along[edges.count] = place(to) - start;
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
  const auto& [cores, a, b, its_slack, touching, on_a, on_b, between] = problem;
  const Real slack = its_slack;  // not the binding itself, which clang 14 lets no lambda capture
  Axis best = {{0, 0, 0}, -infinity, {0, 0, 0}};

  // Faces. b's must be better by more than rounding, so that of two alike a's is taken, step after step.
  const FaceBounds bound_a = face_bounds(a, on_b), bound_b = face_bounds(b, problem.in_b(on_a));
  const BestFace face_a = best_face(a, bound_a, best.separation, [&](const Vector3<Real>& n) { return problem.lowest_b(n); });
  if (face_a.face >= 0) {
    const Vector3<Real> normal = vector_of(a.plane[face_a.face]);
    best = {normal, face_a.separation, face_a.vertex - (Real(.5) * face_a.separation) * normal, face_a.face};
  }
  const BestFace face_b = best_face(b, bound_b, best.separation + slack,
                                    [&](const Vector3<Real>& n) { return problem.in_b(problem.lowest_a(problem.cores.turn * n)); });
  if (face_b.face >= 0) {
    const Vector3<Real> normal = cores.turn * vector_of(b.plane[face_b.face]);
    best = {-normal, face_b.separation, cores.turn * face_b.vertex + cores.offset - (Real(.5) * face_b.separation) * normal, -1,
            face_b.face};
  }

  // Edges, where they are better again. Along an axis of two, on_a is not beyond a's edge, nor on_b before b's.
  const Real least = min(best.separation, 0);
  const Edges edges_a = edges_left(a, bound_a, least, [&](int k) { return problem.vertex_a(k); });
  const Edges edges_b = edges_left(b, bound_b, least, [&](int k) { return problem.vertex_b(k); });
  for (int i = 0; i < edges_a.count; ++i) {
    const Vector3<Real>&start_a = edges_a.start[i], &along_a = edges_a.along[i];
    const Real beyond_2 = parallel_2 * dot(along_a, along_a);
    for (int k = 0; k < edges_b.count; ++k) {
      const Vector3<Real>&start_b = edges_b.start[k], &along_b = edges_b.along[k];
      const Vector3<Real> normal = cross(along_a, along_b);
      const Real square = dot(normal, normal), length = sqrt(square);
      const Real apart = dot(normal, start_b - start_a), before_a = dot(normal, start_a - on_a), after_b = dot(normal, on_b - start_b);
      const Real away = slack * length;
      const bool way = (before_a >= -away) & (after_b >= -away) & (apart > (best.separation + slack) * length);
      const bool other_way = (before_a <= away) & (after_b <= away) & (-apart > (best.separation + slack) * length);
      if (!((way | other_way) & (square > beyond_2 * dot(along_b, along_b)))) continue;
      const auto measure = [&](const Vector3<Real>& axis, Real between_edges) {
        const Real separation = separation_along(problem, axis);
        const bool are_deepest = between_edges <= separation + apart_slacks * slack;  // these two edges, and not others parallel to them
        if ((separation > best.separation + slack) & are_deepest)
          best = {axis, separation, middle_of_edges(start_a, along_a, start_b, along_b)};
      };
      const Real per_length = 1 / length;
      if (way) measure(per_length * normal, per_length * apart);
      if (other_way) measure(-per_length * normal, -per_length * apart);
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
  const auto& [cores, a, b, slack, touching, on_a, on_b, between] = problem;
  const Real distance = sqrt(dot(between, between));
  Axis best = {(1 / distance) * between, distance, Real(.5) * (on_a + on_b)};
  const Facing face_a = facing(a, best.normal), face_b = facing(b, -transposed_times(cores.turn, best.normal));
  if (face_a.cosine > least_cosine) {
    const Vector3<Real> normal = vector_of(a.plane[face_a.face]);
    if (height(a, face_a.face, problem.lowest_b(normal)) >= distance - slack) {
      best.normal = normal, best.face_a = face_a.face;
      return best;
    }
  }
  if (face_b.cosine > least_cosine) {
    const Vector3<Real> normal = cores.turn * vector_of(b.plane[face_b.face]);
    if (height(b, face_b.face, problem.in_b(problem.lowest_a(normal))) >= distance - slack)
      best.normal = -normal, best.face_b = face_b.face;
  }
  return best;
}

// The polygon of a shape that supports the normal: of a face, counterclockwise from outside; a segment or a point is its own.
struct Polygon {
  int count;
  std::array<Vector3<Real>, most_hull_vertices> corner;
};
template <class Place>
Polygon polygon_of(const Shape& shape, int face, const Place& place) {
  Polygon polygon;
  const int first = face >= 0 ? shape.first_corner[face] : 0;
  polygon.count = face >= 0 ? shape.first_corner[face + 1] - first : shape.vertices;
  for (int k = 0; k < polygon.count; ++k) polygon.corner[k] = place(face >= 0 ? shape.corner[first + k] : k);
  return polygon;
}

// What may become a point of the manifold.
struct Candidates {
  int count = 0;
  std::array<bool, most_candidates> valid;
  std::array<Vector3<Real>, most_candidates> middle;  // between the cores
  std::array<Real, most_candidates> separation;       // of the cores
  std::array<int, most_candidates> slot;

  void add(bool is_valid, const Vector3<Real>& position, Real distance, int from) {
    valid[count] = is_valid, middle[count] = position, separation[count] = distance, slot[count++] = from;
  }
};

// The incident polygon against the reference, which looks along `out`, towards it. A plane of a face: its normal, and the distance of the
// origin from it.
void clip(const Polygon& reference, const Quad<Real>& reference_plane, const Polygon& incident, const Quad<Real>& incident_plane,
          const Vector3<Real>& out, Real slack, Candidates& candidates) {
  // Sides stand on the edges, along `out`; what is beyond one by no more than rounding is within.
  std::array<Vector3<Real>, most_hull_vertices> side;
  std::array<Real, most_hull_vertices> border;
  for (int k = 0; k < reference.count; ++k) {
    const Vector3<Real>&from = reference.corner[k], &to = reference.corner[k + 1 < reference.count ? k + 1 : 0];
    side[k] = cross(to - from, out);
    border[k] = dot(side[k], from) + slack * taxicab(side[k]);
  }

  const Real per_cosine = 1 / dot(vector_of(reference_plane), out);
  for (int j = 0; j < incident.count; ++j) {
    const Vector3<Real>&from = incident.corner[j], &to = incident.corner[j + 1 < incident.count ? j + 1 : 0];
    const Vector3<Real> along = to - from;
    Real enter = 0, leave = 1;
    bool outside = false;
    for (int k = 0; k < reference.count; ++k) {
      const Real beyond = dot(side[k], from) - border[k], slope = dot(side[k], along);
      const Real crossing = -beyond / select(slope == 0, Real(1), slope);
      enter = select(slope < 0, max(crossing, enter), enter);
      leave = select(slope > 0, min(crossing, leave), leave);
      outside = outside | ((slope == 0) & (beyond > 0));
    }
    const bool within = !outside & (enter <= leave);
    const auto add = [&](bool valid, Real where, int slot) {
      const Vector3<Real> point = from + where * along;
      const Real separation = (dot(vector_of(reference_plane), point) - reference_plane.w) * per_cosine;
      candidates.add(valid, point - (Real(.5) * separation) * out, separation, slot);
    };
    // Where it leaves at its end, the next edge enters, unless this is a segment.
    add(within, enter, 2 * j);
    add(within & ((leave < 1) | (incident.count == 2)), leave, 2 * j + 1);
    if (incident.count == 2) break;
  }

  if (incident.count < 3) return;
  const Real cosine = -dot(vector_of(incident_plane), out), per_incident_cosine = 1 / max(cosine, Real(least_incident_cosine));
  for (int k = 0; k < reference.count; ++k) {
    const Vector3<Real>& corner = reference.corner[k];
    bool within = cosine > Real(least_incident_cosine);
    for (int j = 0; j < incident.count; ++j) {
      const Vector3<Real>&from = incident.corner[j], &to = incident.corner[j + 1 < incident.count ? j + 1 : 0];
      const Vector3<Real> out_of_edge = cross(out, to - from);
      within = within & (dot(out_of_edge, corner - from) < -slack * taxicab(out_of_edge));
    }
    const Real separation = (dot(vector_of(incident_plane), corner) - incident_plane.w) * per_incident_cosine;
    candidates.add(within, corner + (Real(.5) * separation) * out, separation, slot_of_corner + k);
  }
}

// Up to four of the candidates: the deepest; the farthest from it; the farthest from the line through both, to either side.
struct Chosen {
  int count = 0;
  std::array<int, most_points> candidate;
};
Chosen choose(const Candidates& candidates, const Vector3<Real>& normal, Real least_apart) {
  // The valid candidate of the greatest value, if that is greater than `least`; the first of equals.
  const auto greatest = [&](Real least, const auto& value) {
    int best = -1;
    for (int k = 0; k < candidates.count; ++k) {
      const Real v = value(k);
      if (candidates.valid[k] & (v > least)) least = v, best = k;
    }
    return best;
  };
  Chosen chosen;
  const auto take = [&](int k) {
    if (k >= 0) chosen.candidate[chosen.count++] = k;
    return k >= 0;
  };
  const int deepest = greatest(-infinity, [&](int k) { return -candidates.separation[k]; });
  if (!take(deepest)) return chosen;
  const Vector3<Real>& origin = candidates.middle[deepest];
  const int farthest = greatest(least_apart * least_apart, [&](int k) {
    const Vector3<Real> away = candidates.middle[k] - origin;
    return dot(away, away);
  });
  if (!take(farthest)) return chosen;
  const Vector3<Real> along = candidates.middle[farthest] - origin, across = cross(normal, along);
  const Real least = least_apart * sqrt(dot(along, along));
  take(greatest(least, [&](int k) { return dot(across, candidates.middle[k] - origin); }));
  take(greatest(least, [&](int k) { return -dot(across, candidates.middle[k] - origin); }));
  return chosen;
}

// The plane of a face, in the shape's frame.
Quad<Real> plane_of(const Shape& shape, int face) {
  const Quad<Real>& plane = shape.plane[face];
  return {plane.x, plane.y, plane.z, distance_of(shape, face)};
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

// The points that hold the two apart along the axis.
Manifold<Real> manifold_of(const Problem& problem, const Pair& pair, const Contact& contact, Real radius_a, Real radius_b, Real margin) {
  const auto& [cores, a, b, slack, touching, on_a, on_b, between] = problem;
  const auto& [axis, face_a, face_b] = contact;
  const Vector3<Real>& normal = axis.normal;

  Candidates candidates;
  const bool of_b = face_b.cosine - preference > face_a.cosine;
  if (max(face_a.cosine, face_b.cosine) > least_cosine) {
    const Polygon polygon_a = polygon_of(a, face_a.face, [&](int k) { return problem.vertex_a(k); });
    const Polygon polygon_b = polygon_of(b, face_b.face, [&](int k) { return problem.vertex_b(k); });
    Quad<Real> plane_a = {0, 0, 0, 0}, plane_b = {0, 0, 0, 0};
    if (face_a.face >= 0) plane_a = plane_of(a, face_a.face);
    if (face_b.face >= 0) {
      const Quad<Real> plane = plane_of(b, face_b.face);
      const Vector3<Real> turned = cores.turn * vector_of(plane);
      plane_b = {turned.x, turned.y, turned.z, plane.w + dot(turned, cores.offset)};
    }
    if (of_b)
      clip(polygon_b, plane_b, polygon_a, plane_a, -normal, slack, candidates);
    else
      clip(polygon_a, plane_a, polygon_b, plane_b, normal, slack, candidates);
  }

  // Where the faces do not hold the deepest points, those are one more.
  const Real radii = radius_a + radius_b;
  Real deepest = infinity;
  for (int k = 0; k < candidates.count; ++k) {
    deepest = select(candidates.valid[k], min(candidates.separation[k], deepest), deepest);
    candidates.valid[k] = candidates.valid[k] && candidates.separation[k] - radii <= margin;
  }
  candidates.add((axis.separation - radii <= margin) & (deepest > axis.separation + 4 * slack), axis.middle, axis.separation,
                 slot_of_closest);

  const Chosen chosen = choose(candidates, normal, apart_slacks * slack);
  Manifold<Real> manifold = {};
  manifold.normal = cores.from_a * normal;
  manifold.count = chosen.count;
  manifold.a = pair.a, manifold.b = pair.b;
  const int reference = std::max(of_b ? face_b.face : face_a.face, 0), incident = std::max(of_b ? face_a.face : face_b.face, 0);
  const Vector3<Real> to_middle = (Real(.5) * (radius_a - radius_b)) * normal;
  for (int k = 0; k < chosen.count; ++k) {
    const int candidate = chosen.candidate[k];
    manifold.point[k] = {in_world(cores, candidates.middle[candidate] + to_middle), candidates.separation[candidate] - radii};
    manifold.feature[k] = feature_of(int{of_b}, reference, incident, candidates.slot[candidate]);
  }
  return manifold;
}

}  // namespace

void convexes(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin, std::span<Simplex> simplex,
              std::span<Manifold<Real>> manifolds) {
  std::vector<Closest<Real>> closest(pairs.size());
  closest_points(placed, pairs, simplex, closest);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const Pair& pair = pairs[k];
    manifolds[k] = {};
    manifolds[k].a = pair.a, manifolds[k].b = pair.b;
    const Real radius_a = placed.colliders.size[pair.a].w, radius_b = placed.colliders.size[pair.b].w;
    if (!(closest[k].distance <= margin + (radius_a + radius_b))) continue;
    const Problem problem = make_problem(placed, pair, simplex[k]);
    manifolds[k] = manifold_of(problem, pair, contact_of(problem), radius_a, radius_b, margin);
  }
}

}  // namespace lockstep::rigid::serial
