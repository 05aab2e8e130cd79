// The axes of two convex cores: the formulas of convex_axes, which both versions share.
//
// A Problem is a CorePair of numbers with two shapes a and b, and with lowest_a(d) and lowest_b(d): of a core's
// vertices, in a's frame, the one that is lowest along d. Of a shape, each version has its own
//   normal_of(shape, face)              in the shape's frame
//   height(shape, face, point)          of a point of the shape's frame above a face
//   facing(shape, d)                    a Facing: the face whose normal is nearest to d
//   best_face(shape, bounds, least, f)  a BestFace
#pragma once

#include <limits>

#include "common/rigid/convex_axes.h"
#include "common/rigid/convexes.h"
#include "common/rigid/truth.h"

namespace lockstep::rigid {

// Edges whose directions differ by less than 2^-20 (the sine) have no axis but rounding; this is the square.
inline constexpr float parallel_2 = 0x1p-40f;
// Nearer than 2^-13 of the pair's reach, 1e-4, the line between the closest points is too short to tell its direction:
// rounding, some epsilon of the reach, would turn it by more than a milliradian.
inline constexpr float touching_per_reach = 0x1p-13f;

// The point of a simplex that is nearest to the origin, as GJK leaves the simplex: the weights of its corners, and that
// point. Corners are those of the difference of two cores; beyond the count they are anything finite.
template <class T>
struct Nearest {
  T weight[4];
  Vector3<T> point;
};
template <class T>
inline Nearest<T> nearest_between(const Truth<T>& two, const Truth<T>& three, const Truth<T>& four,
                                  const Vector3<T>* corner) {
  const T none(0), one(1);
  const Vector3<T>& p = corner[0];
  const Vector3<T> e = corner[1] - p, f = corner[2] - p, g = corner[3] - p;
  const Vector3<T> p_e = cross(p, e), e_f = cross(e, f), e_g = cross(e, g), f_g = cross(f, g);
  const T per_length_2 = one / dot(e, e), per_area_2 = one / dot(e_f, e_f), per_volume = one / dot(e, f_g);
  const T s = select(two, min(-dot(p, e) * per_length_2, one),
                     select(three, -dot(e_f, cross(p, f)) * per_area_2, select(four, -dot(p, f_g) * per_volume, none)));
  const T t = select(three, dot(e_f, p_e) * per_area_2, select(four, dot(p, e_g) * per_volume, none));
  const T u = select(four, -dot(p, e_f) * per_volume, none);

  // The point, along a vector at right angles to the edge or face, and not what is left of p after subtractions: its
  // direction is good however short it is.
  const Vector3<T> off_edge = cross(e, p_e);
  const T along = dot(p, e_f) * per_area_2;
  const auto choose = [&](T at_corner, T of_edge, T of_face) {
    return select(four, none, select(three, along * of_face, select(two, per_length_2 * of_edge, at_corner)));
  };
  return {{one - (s + t + u), s, t, u},
          {choose(p.x, off_edge.x, e_f.x), choose(p.y, off_edge.y, e_f.y), choose(p.z, off_edge.z, e_f.z)}};
}

// Two cores, in a's frame, and what is left of GJK's simplex.
template <class T>
struct CorePair {
  using Number = T;

  Cores<T> cores;
  T slack, touching;  // m
  // Points of the cores: the closest, or where they overlap, the same within rounding; and b's from a's.
  Vector3<T> on_a, on_b, between;

  Vector3<T> in_b(const Vector3<T>& point) const { return transposed_times(cores.turn, point - cores.offset); }
};
// Corners 0 .. count - 1 of the simplex are those of the vertices of_a and of_b.
template <class Real, class T>
inline CorePair<T> make_core_pair(const Cores<T>& cores, const T& reach, const Integer<T>& count,
                                  const Vector3<T> (&of_a)[4], const Vector3<T> (&of_b)[4]) {
  using I = Integer<T>;
  const Vector3<T> corner[4] = {of_b[0] - of_a[0], of_b[1] - of_a[1], of_b[2] - of_a[2], of_b[3] - of_a[3]};
  const auto [weight, point] = nearest_between<T>(count == I(2), count == I(3), count == I(4), corner);
  return {cores,
          T(slack_per_reach<Real>) * reach,
          T(touching_per_reach) * reach,
          weight[0] * of_a[0] + weight[1] * of_a[1] + weight[2] * of_a[2] + weight[3] * of_a[3],
          weight[0] * of_b[0] + weight[1] * of_b[1] + weight[2] * of_b[2] + weight[3] * of_b[3],
          point};
}

// An axis from a to b, how far it separates the cores, and the point midway where they are nearest along it.
template <class Real>
struct CoreAxis {
  Vector3<Real> normal;
  Real separation;
  Vector3<Real> middle;
  int face_a = -1, face_b = -1;  // the face whose normal it is, if any
};

// A face and the cosine of the angle between its normal and a direction; -1 of a shape without faces.
template <class Real>
struct Facing {
  int face;
  Real cosine;
};

// The face of a shape that separates most, if by more than `least`, and the other core's vertex that is deepest below
// it; else -1. `deepest` finds that vertex along a direction. All are in the shape's frame.
template <class Real>
struct BestFace {
  int face;
  Real separation;
  Vector3<Real> vertex;
};

// How far an axis separates the cores. Along an axis from face to vertex or edge to edge, that is how far these are
// apart.
template <class Problem, class Real>
inline Real separation_along(const Problem& problem, const Vector3<Real>& axis) {
  return dot(axis, problem.lowest_b(axis)) - dot(axis, problem.lowest_a(-axis));
}

// The best of the normals of both cores' faces. b's must be better by more than rounding, so that of two alike a's is
// taken, step after step.
template <class Problem, class Bounds>
inline auto best_face_axis(const Problem& problem, const Bounds& bounds_a, const Bounds& bounds_b) {
  using Real = typename Problem::Number;
  const auto &a = problem.a, &b = problem.b;
  const Cores<Real>& cores = problem.cores;
  CoreAxis<Real> best = {{0, 0, 0}, -std::numeric_limits<Real>::infinity(), {0, 0, 0}};
  const BestFace<Real> face_a =
      best_face(a, bounds_a, best.separation, [&](const Vector3<Real>& n) { return problem.lowest_b(n); });
  if (face_a.face >= 0) {
    const Vector3<Real> normal = normal_of(a, face_a.face);
    best = {normal, face_a.separation, face_a.vertex - (Real(.5) * face_a.separation) * normal, face_a.face};
  }
  const BestFace<Real> face_b = best_face(b, bounds_b, best.separation + problem.slack, [&](const Vector3<Real>& n) {
    return problem.in_b(problem.lowest_a(problem.cores.turn * n));
  });
  if (face_b.face >= 0) {
    const Vector3<Real> normal = cores.turn * normal_of(b, face_b.face);
    const Vector3<Real> vertex = cores.turn * face_b.vertex + cores.offset;
    best = {-normal, face_b.separation, vertex - (Real(.5) * face_b.separation) * normal, -1, face_b.face};
  }
  return best;
}

template <class T>
struct CoreEdge {
  Vector3<T> start, along;  // in a's frame
};

// Whether the cross product of an edge of a and one of b, or its opposite, may separate by more than `enough`. On the
// way from a to b, on_a is not beyond a's edge, nor on_b before b's.
template <class T>
struct EdgeAxis {
  Vector3<T> normal;  // not of length 1
  T length, apart;    // how far the edges are apart along it, times its length
  Truth<T> way, other_way;
};
template <class T>
inline EdgeAxis<T> edge_axis(const CoreEdge<T>& a, const CoreEdge<T>& b, const Vector3<T>& on_a, const Vector3<T>& on_b,
                             const T& slack, const T& enough) {
  const Vector3<T> normal = cross(a.along, b.along);
  const T square = dot(normal, normal), length = sqrt(square);
  const T apart = dot(normal, b.start - a.start), before_a = dot(normal, a.start - on_a),
          after_b = dot(normal, on_b - b.start);
  const T away = slack * length, least = enough * length;
  const Truth<T> across = square > T(parallel_2) * dot(a.along, a.along) * dot(b.along, b.along);
  const Truth<T> way = across & (before_a >= -away) & (after_b >= -away) & (apart > least);
  const Truth<T> other_way = across & (before_a <= away) & (after_b <= away) & (-apart > least);
  return {normal, length, apart, way, other_way};
}

// The middle of where two lines are closest, as far as their edges go. They are not parallel.
template <class Real>
inline Vector3<Real> middle_of_edges(const CoreEdge<Real>& a, const CoreEdge<Real>& b) {
  const Vector3<Real> between = b.start - a.start, normal = cross(a.along, b.along);
  const Real per_square = 1 / dot(normal, normal);
  const Real s = dot(cross(between, b.along), normal) * per_square,
             t = dot(cross(between, a.along), normal) * per_square;
  const Vector3<Real> on_a = a.start + min(max(s, 0), 1) * a.along, on_b = b.start + min(max(t, 0), 1) * b.along;
  return Real(.5) * (on_a + on_b);
}

// Measures the axes of two edges, if they may separate more than the best axis so far, and keeps the better.
template <class Problem, class Real>
inline void try_edges(const Problem& problem, const CoreEdge<Real>& a, const CoreEdge<Real>& b, CoreAxis<Real>& best) {
  const Real slack = problem.slack;
  const EdgeAxis<Real> edges = edge_axis(a, b, problem.on_a, problem.on_b, slack, best.separation + slack);
  if (!(edges.way | edges.other_way)) return;
  const auto measure = [&](const Vector3<Real>& axis, Real between_edges) {
    const Real separation = separation_along(problem, axis);
    // These two edges, and not others parallel to them.
    const bool are_deepest = between_edges <= separation + apart_slacks * slack;
    if ((separation > best.separation + slack) & are_deepest) best = {axis, separation, middle_of_edges(a, b)};
  };
  const Real per_length = 1 / edges.length;
  if (edges.way) measure(per_length * edges.normal, per_length * edges.apart);
  if (edges.other_way) measure(-per_length * edges.normal, -per_length * edges.apart);
}

// Where cores nearly touch, each with a corner, the line between the closest points may be better still.
template <class Problem, class Real>
inline void try_closest_points(const Problem& problem, CoreAxis<Real>& best) {
  const Real distance_2 = dot(problem.between, problem.between);
  if (!(distance_2 > problem.slack * problem.slack)) return;
  const Vector3<Real> axis = (1 / sqrt(distance_2)) * problem.between;
  const Real separation = separation_along(problem, axis);
  if (separation > best.separation + problem.slack) best = {axis, separation, Real(.5) * (problem.on_a + problem.on_b)};
}

// Whether the cores are so far apart that the line between their closest points has a direction.
template <class Problem>
inline bool are_apart(const Problem& problem) {
  return dot(problem.between, problem.between) > problem.touching * problem.touching;
}

// That line. Where a face separates as far, within rounding, its normal is the better: it comes from no difference.
template <class Problem>
inline auto closest_axis(const Problem& problem) {
  using Real = typename Problem::Number;
  const auto &a = problem.a, &b = problem.b;
  const Matrix3<Real>& turn = problem.cores.turn;
  const Real distance = sqrt(dot(problem.between, problem.between)), least = distance - problem.slack;
  CoreAxis<Real> best = {(1 / distance) * problem.between, distance, Real(.5) * (problem.on_a + problem.on_b)};
  const Facing<Real> face_a = facing(a, best.normal), face_b = facing(b, -transposed_times(turn, best.normal));
  if (face_a.cosine > least_cosine) {
    const Vector3<Real> normal = normal_of(a, face_a.face);
    if (height(a, face_a.face, problem.lowest_b(normal)) >= least) {
      best.normal = normal, best.face_a = face_a.face;
      return best;
    }
  }
  if (face_b.cosine > least_cosine) {
    const Vector3<Real> normal = turn * normal_of(b, face_b.face);
    if (height(b, face_b.face, problem.in_b(problem.lowest_a(normal))) >= least)
      best.normal = -normal, best.face_b = face_b.face;
  }
  return best;
}

// The axis, and the faces whose normals are nearest to it.
template <class Problem, class Real>
inline SeparatingAxis<Real> with_faces(const Problem& problem, const CoreAxis<Real>& axis) {
  const Facing<Real> face_a = axis.face_a >= 0 ? Facing<Real>{axis.face_a, 1} : facing(problem.a, axis.normal);
  const Vector3<Real> back = -transposed_times(problem.cores.turn, axis.normal);
  const Facing<Real> face_b = axis.face_b >= 0 ? Facing<Real>{axis.face_b, 1} : facing(problem.b, back);
  return {axis.normal, axis.separation, axis.middle, face_a.cosine, face_b.cosine, face_a.face, face_b.face, {}};
}

// The axis of a pair that is farther apart than margin.
template <class Real>
inline constexpr SeparatingAxis<Real> far_apart = {
    {0, 0, 0}, std::numeric_limits<Real>::infinity(), {0, 0, 0}, 0, 0, 0, 0, {}};

}  // namespace lockstep::rigid
