// The contact of two boxes' faces, or of two of their edges, for T a number or sixteen lanes.
//
// Two faces are seen along the normal, from the reference face: a rectangle, and in its plane a parallelogram, the
// incident face, whose points have a separation each. The corners of what they have in common are candidates, each in a
// slot of its own: two for each edge of the parallelogram, where it enters the rectangle (or begins in it) and where it
// leaves, by Liang and Barsky; one for each corner of the rectangle within the parallelogram. Fixed slots, instead of
// the usual list that grows and shrinks plane by plane, let sixteen pairs fill the same slots at once.
#pragma once

#include "common/rigid/box_axes.h"
#include "common/rigid/keep_four.h"
#include "common/rigid/manifold.h"

namespace lockstep::rigid {

// Two faces, seen along the normal. The origin is the middle of the reference face, x and y run along it and z out of
// it.
template <class T>
struct BoxFaces {
  T half_x, half_y;            // of the reference face
  Vector3<T> normal;           // z > 0
  Vector3<T> middle, p, q;     // incident face: its middle and its half sides, as x, y and separation
  T lowest;                    // separation of the incident face's deepest corner, rounded as the axis's is
  T size;                      // the largest half side
  Vector3<T> origin, x, y, z;  // in the world
  Integer<T> feature;          // of slot 0
};

template <class T>
[[gnu::always_inline]] inline BoxFaces<T> see_faces(const BoxPair<T>& boxes, const Pose<T>& pose, const Truth<T>& on_b,
                                                    const Integer<T>& axis, const Three<T>& normal) {
  using I = Integer<T>;
  BoxPair<T> from_reference = boxes;
  if (any(on_b)) from_reference = select(on_b, swapped(boxes), boxes);
  const auto& [half_a, half_b, t, r] = from_reference;
  const I x = next(axis), y = next(x);
  const T up = select(normal[axis] < T(0), T(-1), T(1));
  const Three<T> row_x = r[x], row_y = r[y], row_z = {up * r[axis][0], up * r[axis][1], up * r[axis][2]};
  const I incident = longest(row_z), p = next(incident), q = next(p);
  const T facing = select(row_z[incident] < T(0), T(1), T(-1)), out = facing * half_b[incident];

  BoxFaces<T> faces;
  faces.half_x = half_a[x], faces.half_y = half_a[y];
  faces.normal = {normal[x], normal[y], up * normal[axis]};
  // Along the normal, one unit of height is this much separation.
  const T per_height = 1 / faces.normal.z;
  faces.lowest = (up * t[axis] - (half_a[axis] + reach_of_b(from_reference, axis))) * per_height;
  const auto seen = [&](T x, T y, T separation) {
    return Vector3<T>{x - faces.normal.x * separation, y - faces.normal.y * separation, separation};
  };
  faces.p = seen(half_b[p] * row_x[p], half_b[p] * row_y[p], half_b[p] * row_z[p] * per_height);
  faces.q = seen(half_b[q] * row_x[q], half_b[q] * row_y[q], half_b[q] * row_z[q] * per_height);
  faces.middle =
      seen(t[x] + out * row_x[incident], t[y] + out * row_y[incident], faces.lowest + abs(faces.p.z) + abs(faces.q.z));
  faces.size = largest_half(boxes);

  const Matrix3<T> m = matrix_of(pose.orientation);
  const Three<Vector3<T>> column = {m.x, m.y, m.z};
  faces.x = column[x], faces.y = column[y], faces.z = up * column[axis];
  faces.origin = pose.position + half_a[axis] * faces.z;
  faces.feature = ((select(on_b, I(6), 0) + 2 * axis + select(up > T(0), I(1), 0)) * 6 + 2 * incident +
                   select(facing > T(0), I(1), 0)) *
                  slots;
  return faces;
}

// A point that both faces have, seen along the normal, and the slot that it comes from.
template <class T>
struct BoxPoint {
  T x, y, separation;
  Integer<T> slot;
};
template <class T>
[[gnu::always_inline]] inline void take(const Truth<T>& mask, const BoxPoint<T>& from, BoxPoint<T>& to) {
  where(mask, to.x) = from.x, where(mask, to.y) = from.y, where(mask, to.separation) = from.separation,
              where(mask, to.slot) = from.slot;
}

// All candidates, and which are valid. What keep_four.h asks for is measured seen along the normal.
template <class T>
struct BoxPoints {
  using Point = BoxPoint<T>;

  T x[slots], y[slots], separation[slots];
  Truth<T> valid[slots];
  T preference, same;  // m: a point is deeper, or another one, by more than this

  [[gnu::always_inline]] void set(int k, const Truth<T>& is_valid, const T& at_x, const T& at_y,
                                  const T& its_separation) {
    valid[k] = is_valid, x[k] = at_x, y[k] = at_y, separation[k] = its_separation;
  }
  template <class Action>
  [[gnu::always_inline]] void each(const Action& action) const {
#pragma GCC unroll 13
    for (int k = 0; k < slots; ++k)
      if (any(valid[k])) action(Point{x[k], y[k], separation[k], Integer<T>(k)}, valid[k]);
  }
  [[gnu::always_inline]] const T& deeper_by() const { return preference; }
  [[gnu::always_inline]] T distance_2(const Point& point, const Point& deepest) const {
    const T along_x = point.x - deepest.x, along_y = point.y - deepest.y;
    return along_x * along_x + along_y * along_y;
  }
  [[gnu::always_inline]] T least_distance_2() const { return same * same; }
  [[gnu::always_inline]] auto side(const Point& deepest, const Point& farthest) const {
    const T along_x = farthest.x - deepest.x, along_y = farthest.y - deepest.y, from_x = deepest.x, from_y = deepest.y;
    return [=](const Point& point) { return along_x * (point.y - from_y) - along_y * (point.x - from_x); };
  }
  [[gnu::always_inline]] T least_side(const T& distance_2) const { return same * sqrt(distance_2); }
};

// Signs of p and q at corner k, counterclockwise; and of x and y.
inline constexpr float sign_p[] = {1, -1, -1, 1}, sign_q[] = {1, 1, -1, -1};

template <class T>
[[gnu::always_inline]] inline Vector3<T> corner(const BoxFaces<T>& faces, const T& p, const T& q) {
  const Vector3<T>& middle = faces.middle;
  return {middle.x + p * faces.p.x + q * faces.q.x, middle.y + p * faces.p.y + q * faces.q.y,
          faces.lowest + ((abs(faces.p.z) + p * faces.p.z) + (abs(faces.q.z) + q * faces.q.z))};
}

// The part of a line that is within |x| <= half: from start on, t from near to far of a step, whose inverse length is
// given.
template <class T>
struct Span {
  T near, far;
};
template <class T>
[[gnu::always_inline]] inline Span<T> span_within(const T& start, const T& step, const T& per_step, const T& half) {
  const T towards = select(step < T(0), -start, start);
  return {(-half - towards) * per_step, (half - towards) * per_step};
}
template <class T>
[[gnu::always_inline]] inline T inverse_length(const T& step) {
  return T(1) / max(abs(step), T(1e-30f));
}

// All candidates. At least one is valid.
template <class T>
[[gnu::always_inline]] inline void find_candidates(const BoxFaces<T>& faces, const T& separation,
                                                   BoxPoints<T>& points) {
  const Vector3<T>&middle = faces.middle, &p = faces.p, &q = faces.q;
  const T widening = T(face_widening) * faces.size, half_x = faces.half_x + widening, half_y = faces.half_y + widening;
  Truth<T> found = all_false<T>();

  // Edge k leads from corner k to the next: along -p, -q, p and q.
  const T per_p_x = inverse_length(T(2) * p.x), per_p_y = inverse_length(T(2) * p.y);
  const T per_q_x = inverse_length(T(2) * q.x), per_q_y = inverse_length(T(2) * q.y);
#pragma GCC unroll 4
  for (int k = 0; k < 4; ++k) {
    const bool along_p = k % 2 == 0;
    const Vector3<T> start = corner(faces, T(sign_p[k]), T(sign_q[k])),
                     step = T(k < 2 ? -2.f : 2.f) * (along_p ? p : q);
    const Span<T> x = span_within(start.x, step.x, along_p ? per_p_x : per_q_x, half_x);
    const Span<T> y = span_within(start.y, step.y, along_p ? per_p_y : per_q_y, half_y);
    const T enter = max(max(x.near, y.near), T(0)), exit = min(min(x.far, y.far), T(1));
    const Truth<T> within = enter <= exit;
    points.set(2 * k, within, start.x + enter * step.x, start.y + enter * step.y, start.z + enter * step.z);
    points.set(2 * k + 1, within & (exit < T(1)), start.x + exit * step.x, start.y + exit * step.y,
               start.z + exit * step.z);
    found = found | within;
  }

  // A corner of the reference face is middle + s p + t q; within the incident face if |s|, |t| < 1, by a little more
  // than those are within that an edge above finds.
  const T area = p.x * q.y - p.y * q.x, per_area = T(1) / area, inside = T(.5f) * widening;
  const T most_s = abs(area) - inside * max(abs(q.x), abs(q.y)), most_t = abs(area) - inside * max(abs(p.x), abs(p.y));
#pragma GCC unroll 4
  for (int k = 0; k < 4; ++k) {
    const T x = T(sign_p[k]) * faces.half_x, y = T(sign_q[k]) * faces.half_y;
    const T from_x = x - middle.x, from_y = y - middle.y;
    const T s = from_x * q.y - from_y * q.x, t = p.x * from_y - p.y * from_x;
    const Truth<T> within_s = abs(s) < most_s, within_t = abs(t) < most_t, within = within_s & within_t;
    points.set(8 + k, within, x, y, middle.z + (s * p.z + t * q.z) * per_area);
    found = found | within;
  }

  // Boxes apart may be so diagonally: no part of one is over the other. Then the deepest corner stands for them.
  const Vector3<T> lowest = corner(faces, select(p.z < T(0), T(1), T(-1)), select(q.z < T(0), T(1), T(-1)));
  points.set(12, !found, lowest.x, lowest.y, separation);
}

template <class T>
[[gnu::always_inline]] inline void put_in_order(BoxPoint<T>& a, BoxPoint<T>& b) {
  const Truth<T> wrong = b.slot < a.slot;
  const BoxPoint<T> before = a;
  take(wrong, b, a), take(wrong, before, b);
}

// Of the candidates at most four, in the order of their slots, and where there is none, the slot `slots`. Of equals the
// one in the first slot is kept, and no point that is nearer than same_point to the first, or to the line. The axis
// says that the boxes are within margin: if the deepest is not, by rounding, or as boxes that are apart may be so
// diagonally, it takes the axis's separation.
template <class T>
[[gnu::always_inline]] inline void find_points(const BoxFaces<T>& faces, const T& separation, const T& margin,
                                               BoxPoint<T> (&point)[most_points]) {
  BoxPoints<T> points;
  points.preference = T(axis_preference) * faces.size, points.same = T(same_point) * faces.size;
  find_candidates(faces, separation, points);
  auto deepest = find_deepest<T>(points);
#pragma GCC unroll 13
  for (int k = 0; k < slots; ++k) points.valid[k] = points.valid[k] & (points.separation[k] <= margin);
  where(deepest.point.separation > margin, deepest.point.separation) = separation;
  auto four = find_others<T>(points, deepest);
  for (auto* kept : {&four.farthest, &four.left, &four.right})
    where(!kept->there, kept->point.slot) = Integer<T>(slots);
  BoxPoint<T>&first = four.deepest.point, &second = four.farthest.point, &left = four.left.point,
  &right = four.right.point;
  put_in_order(first, second), put_in_order(left, right), put_in_order(first, left), put_in_order(second, right);
  put_in_order(second, left);
  point[0] = first, point[1] = second, point[2] = left, point[3] = right;
}

// From the reference face's frame to the world: a direction.
template <class T>
[[gnu::always_inline]] inline Vector3<T> in_world(const BoxFaces<T>& faces, const Vector3<T>& v) {
  return v.x * faces.x + v.y * faces.y + v.z * faces.z;
}

// The point of two edges, a's axis i and b's axis j: midway between their closest points. Of the normal, along a's axes
// and along b's.
template <class T>
struct EdgePoint {
  Vector3<T> normal, position;  // in the world
  Integer<T> feature;
};
template <class T>
[[gnu::always_inline]] inline EdgePoint<T> edge_point(const BoxPair<T>& boxes, const Pose<T>& pose_a,
                                                      const Integer<T>& i, const Integer<T>& j, const Three<T>& normal,
                                                      const Three<T>& normal_b) {
  using I = Integer<T>;
  const auto& [half_a, half_b, t, r] = boxes;
  // The edge of a that is foremost along the normal, and the edge of b that is hindmost: their middles.
  Three<T> on_a, on_b = t;
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) on_a[k] = select(i == I(k), T(0), select(normal[k] < T(0), -half_a[k], half_a[k]));
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    const T along = select(j == I(k), T(0), select(normal_b[k] < T(0), half_b[k], -half_b[k]));
    on_b = {on_b[0] + along * r[0][k], on_b[1] + along * r[1][k], on_b[2] + along * r[2][k]};
  }
  // Seen along the normal they cross where b's has no distance from a's line: along that distance, and not along the
  // edges, which may be all but parallel, rounding moves them no farther apart than it moves points.
  const I i1 = next(i), i2 = next(i1), j1 = next(j), j2 = next(j1);
  const Three<T> direction = {r[0][j], r[1][j], r[2][j]},
                 between = {on_b[0] - on_a[0], on_b[1] - on_a[1], on_b[2] - on_a[2]};
  const T across = between[i1] * normal[i2] - between[i2] * normal[i1],
          slope = direction[i1] * normal[i2] - direction[i2] * normal[i1];
  const auto within = [](const T& x, const T& half) { return min(max(x, -half), half); };
  const T along_edge_b = within(-across / slope, half_b[j]);
  const T along_edge_a = within(between[i] + along_edge_b * direction[i], half_a[i]);
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
    on_b[k] = on_b[k] + along_edge_b * direction[k];
    on_a[k] = select(i == I(k), along_edge_a, on_a[k]);
  }

  const Matrix3<T> m = matrix_of(pose_a.orientation);
  const auto edge = [](const I& axis, const Truth<T>& next, const Truth<T>& after) {
    return I(4) * axis + select(next, I(1), I(0)) + select(after, I(2), I(0));
  };
  const I edge_a = edge(i, !(normal[i1] < T(0)), !(normal[i2] < T(0)));
  const I edge_b = edge(j, normal_b[j1] < T(0), normal_b[j2] < T(0));
  const Vector3<T> twice = {on_a[0] + on_b[0], on_a[1] + on_b[1], on_a[2] + on_b[2]};
  return {m * Vector3<T>{normal[0], normal[1], normal[2]}, pose_a.position + m * (T(.5f) * twice),
          I(first_edge_feature) + I(12) * edge_a + edge_b};
}

}  // namespace lockstep::rigid
