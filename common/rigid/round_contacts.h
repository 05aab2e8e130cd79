// The formulas of the kernel spheres, for a number or for lanes: a point or a segment against a point, a segment or a
// box, in closed form; then the radii.
//
// Two segments: the lines' closest points, each clamped to its segment after the other (Ericson, Real-Time Collision
// Detection (2005), 5.1.9). The cross product of the directions is computed from their difference, so that it keeps all
// its digits when they are nearly parallel.
//
// Segment and box: along the segment, the squared distance from the box is convex. It is a parabola between the points
// where a coordinate passes a side of the box. There are six of these points; the sign of the slope at each says
// whether the minimum comes before or after it. On the piece that remains, the box is a face, an edge or a corner, and
// the closest point is a quotient.
//
// Cores that meet: the difference of a segment and a box is bounded by planes along the three axes of the box and
// across the segment and each of these axes; the nearest plane gives the exact depth. For two segments it is the plane
// that holds both, at depth 0.
//
// Two points: a capsule that lies on a face, along an edge or along another capsule has a point at each end of the
// stretch over which it does, so that it does not spin. Both separations are measured along the one normal. All points
// of convex shapes are at least their distance apart along the normal at the closest two; so the deeper end has the
// exact depth, or the closest point remains the only one.
//
// Lanes compute the rare cases where any lane has one. Lengths are in metres. The large formulas are inlined by an
// attribute: g++ would call them, and pass lanes through memory.
#pragma once

#include "common/math.h"
#include "common/rigid/round.h"
#include "common/rigid/truth.h"
#include "common/vector3.h"

namespace lockstep::rigid {

// One point, or two that share a normal. The normal is a unit vector from the first shape to the second; positions are
// relative to the first shape. Without a second point, position[1] and separation[1] are 0.
template <class T>
struct RoundContact {
  Vector3<T> normal;
  Vector3<T> position[2];
  T separation[2];
  Truth<T> two;
};

template <class T>
inline RoundContact<T> one_point(const Vector3<T>& normal, const Vector3<T>& position, const T& separation) {
  return {normal, {position, {T(0), T(0), T(0)}}, {separation, T(0)}, all_false<T>()};
}

// Replaces the one point by both ends of the stretch low .. high where `lies` holds, and where the deeper end is as
// deep as the one point within `tolerance`. end(x, position) sets the position of an end and returns its separation.
template <class T, class End>
inline void take_ends(const Truth<T>& lies, const T& low, const T& high, const T& tolerance, const End& end,
                      RoundContact<T>& contact) {
  if (!any(lies)) return;
  Vector3<T> position[2];
  const T separation[] = {end(low, position[0]), end(high, position[1])};
  contact.two = lies & (abs(min(separation[0], separation[1]) - contact.separation[0]) <= tolerance);
  for (int k = 0; k < 2; ++k) {
    contact.position[k] = select(contact.two, position[k], contact.position[k]);
    contact.separation[k] = select(contact.two, separation[k], contact.separation[k]);
  }
}

// Two spheres; the second is around d.
template <class T>
inline RoundContact<T> contact_of_points(const Vector3<T>& d, const T& radius_a, const T& radius_b) {
  const T distance = sqrt(dot(d, d));
  const Vector3<T> up = {T(0), T(1), T(0)};
  const Vector3<T> normal = select(distance > nothing, T(1) / max(distance, T(nothing)) * d, up);
  const T separation = distance - (radius_a + radius_b);
  return one_point(normal, (radius_a + T(.5) * separation) * normal, separation);
}

// Segments of half lengths `half_a` around the origin and `half_b` around d, along the unit vectors u and `along_b`.
template <class T>
[[gnu::always_inline]] inline RoundContact<T> contact_of_segments(const Vector3<T>& d, const Vector3<T>& u,
                                                                  const T& half_a, const Vector3<T>& along_b,
                                                                  const T& half_b, const T& radius_a,
                                                                  const T& radius_b) {
  const Vector3<T> v = select(dot(u, along_b) < T(0), -along_b, along_b);
  const Vector3<T> across = cross(u, v - u);
  const T sine_2 = dot(across, across);
  const T uv = dot(u, v), ud = dot(u, d), vd = dot(v, d);
  T s = clamped(dot(cross(d, v), across) / max(sine_2, T(nothing * nothing)), -half_a, half_a);
  T t = clamped(uv * s - vd, -half_b, half_b);
  s = clamped(uv * t + ud, -half_a, half_a);

  // Where the closest point is not an end, w is perpendicular to the segment; the rest that rounding leaves along the
  // segment would tilt the normal.
  Vector3<T> w = (d + t * v) - s * u;
  w = w - select(abs(t) < half_b, dot(w, v), T(0)) * v;
  w = w - select(abs(s) < half_a, dot(w, u), T(0)) * u;
  const T radii = radius_a + radius_b, size = half_a + half_b + radii;
  const T distance = sqrt(dot(w, w));
  Vector3<T> normal = T(1) / max(distance, T(nothing)) * w;
  if (const Truth<T> meet = distance <= meeting * size; any(meet)) {
    Vector3<T> other =
        select(sine_2 > T(1e-12), T(1) / sqrt(max(sine_2, T(nothing * nothing))) * across, perpendicular(u));
    other = select(dot(other, d) < T(0), -other, other);
    normal = select(meet, other, normal);
  }

  const auto at = [&](const T& s, const T& t, Vector3<T>& position) {
    const Vector3<T> a = s * u, b = d + t * v;
    position = T(.5) * ((a + b) + (radius_a - radius_b) * normal);
    return dot(normal, b - a) - radii;
  };
  Vector3<T> closest;
  const T exact = at(s, t, closest);
  RoundContact<T> contact = one_point(normal, closest, exact);

  // Both ends of the stretch of u beside which v lies. The part of their true distance across the normal grows as the
  // sine.
  const T low = max(-half_a, ud - uv * half_b), high = min(half_a, ud + uv * half_b);
  const T stretch = high - low, limit = nearly * radii;
  const Truth<T> beside = (stretch > limit) & (sine_2 * (stretch * stretch) <= limit * limit);
  const auto end = [&](const T& s, Vector3<T>& position) {
    return at(s, clamped(uv * s - vd, -half_b, half_b), position);
  };
  take_ends(beside, low, high, meeting * size, end, contact);
  return contact;
}

// A box around the origin, along the axes, and a sphere. Inside the box, the way out is through the nearest face.
template <class T>
inline RoundContact<T> contact_of_box_and_point(const Vector3<T>& half, const Vector3<T>& centre, const T& radius) {
  const Vector3<T> w = excess(centre, half);
  const T distance = sqrt(dot(w, w));
  Vector3<T> normal = T(1) / max(distance, T(nothing)) * w;
  if (const Truth<T> inside = distance <= nothing; any(inside)) {
    const T x = abs(centre.x) - half.x, y = abs(centre.y) - half.y, z = abs(centre.z) - half.z;
    const T sx = select(centre.x < T(0), T(-1), T(1)), sy = select(centre.y < T(0), T(-1), T(1));
    const T sz = select(centre.z < T(0), T(-1), T(1));
    const Truth<T> is_x = (x >= y) & (x >= z), is_y = y >= z;
    const Vector3<T> out = {select(is_x, sx, T(0)), select(is_x, T(0), select(is_y, sy, T(0))),
                            select(is_x | is_y, T(0), sz)};
    normal = select(inside, out, normal);
  }
  const Vector3<T> below = foot(centre, normal, half, T(0));
  const Vector3<T> middle = T(.5) * ((below + centre) - radius * normal);
  return one_point(normal, middle, dot(normal, centre - below) - radius);
}

// A segment in the axes of a box around the origin: its points are centre + t along, |t| <= half_length.
template <class T>
struct BoxSegment {
  Vector3<T> box;  // half its sides
  Vector3<T> centre, along, per_along;
  T half_length, radius;
};

// t of the closest point of the segment.
template <class T>
inline T closest_to_box(const BoxSegment<T>& p) {
  const Vector3<T>&half = p.box, &c = p.centre, &u = p.along;

  // The piece low .. high that holds the minimum. Where coordinate i passes a side, it adds nothing to the slope.
  T low = -p.half_length, high = p.half_length;
  const auto cut = [&](const T& t, const T& c_j, const T& u_j, const T& half_j, const T& c_k, const T& u_k,
                       const T& half_k) {
    const T slope = u_j * excess(c_j + t * u_j, half_j) + u_k * excess(c_k + t * u_k, half_k);
    const Truth<T> inside = (t > -p.half_length) & (t < p.half_length);
    low = select(inside & (slope < T(0)), max(t, low), low);
    high = select(inside & (slope >= T(0)), min(t, high), high);
  };
  cut((-half.x - c.x) * p.per_along.x, c.y, u.y, half.y, c.z, u.z, half.z);
  cut((half.x - c.x) * p.per_along.x, c.y, u.y, half.y, c.z, u.z, half.z);
  cut((-half.y - c.y) * p.per_along.y, c.z, u.z, half.z, c.x, u.x, half.x);
  cut((half.y - c.y) * p.per_along.y, c.z, u.z, half.z, c.x, u.x, half.x);
  cut((-half.z - c.z) * p.per_along.z, c.x, u.x, half.x, c.y, u.y, half.y);
  cut((half.z - c.z) * p.per_along.z, c.x, u.x, half.x, c.y, u.y, half.y);

  // On that piece, the coordinates outside the box are those that are outside in its middle.
  const T middle = T(.5) * (low + high);
  T above = T(0), below = T(0);
  const auto add = [&](const T& c_i, const T& u_i, const T& half_i) {
    const T outside = excess(c_i + middle * u_i, half_i);
    above = above + select(outside == T(0), T(0), u_i * (select(outside > T(0), half_i, -half_i) - c_i));
    below = below + select(outside == T(0), T(0), u_i * u_i);
  };
  add(c.x, u.x, half.x), add(c.y, u.y, half.y), add(c.z, u.z, half.z);
  return clamped(select(below > T(0), above / below, middle), low, high);
}

// Of a segment that passes through the box, the plane of least depth: its normal, and t of the point that leaves the
// box last along it.
template <class T>
struct WayOut {
  Vector3<T> normal;
  T t;
};

template <class T>
inline WayOut<T> least_depth(const BoxSegment<T>& p) {
  const Vector3<T>&half = p.box, &c = p.centre, &u = p.along;
  const T half_length = p.half_length, zero = T(0), one = T(1);
  T best = T(-1e30f);
  WayOut<T> way = {{zero, zero, zero}, zero};
  const auto face = [&](const T& c_i, const T& u_i, const T& half_i, const Vector3<T>& axis) {
    const T separation = abs(c_i) - (half_i + half_length * abs(u_i));
    const Truth<T> better = separation > best;
    best = select(better, separation, best);
    way.normal = select(better, select(c_i < zero, -axis, axis), way.normal);
    way.t = select(better, select((u_i < zero) ^ (c_i < zero), half_length, -half_length), way.t);
  };
  face(c.x, u.x, half.x, {one, zero, zero});
  face(c.y, u.y, half.y, {zero, one, zero});
  face(c.z, u.z, half.z, {zero, zero, one});

  // `across` is the cross product of an axis of the box and the segment; its length is the sine of their angle.
  const auto edge = [&](const Vector3<T>& across) {
    const T sine_2 = dot(across, across), per_sine = T(1) / sqrt(max(sine_2, T(nothing * nothing)));
    const T distance = dot(c, across);
    const Vector3<T> out = select(distance < zero, -per_sine, per_sine) * across;
    const Vector3<T> size = {abs(out.x), abs(out.y), abs(out.z)};
    const T separation = abs(distance) * per_sine - dot(half, size);
    const Vector3<T> corner = foot(c, out, half, zero);
    const Truth<T> better = (sine_2 > T(1e-12)) & (separation > best);
    // From the edge to the closest point: along u without its part along the edge.
    const Vector3<T> flat = {select(out.x == zero, zero, u.x), select(out.y == zero, zero, u.y),
                             select(out.z == zero, zero, u.z)};
    const T t = clamped(dot(flat, corner - c) / max(sine_2, T(nothing * nothing)), -half_length, half_length);
    best = select(better, separation, best);
    way.normal = select(better, out, way.normal);
    way.t = select(better, t, way.t);
  };
  edge({zero, -u.z, u.y});
  edge({u.z, zero, -u.x});
  edge({-u.y, u.x, zero});
  return way;
}

// The stretch of the segment above a face, where the normal leaves one side of the box; or along an edge, where it
// leaves two sides and the segment moves away from neither.
template <class T>
struct Stretch {
  T low, high;
  T off_2;  // squared sine of the angle between the segment and the edge; 0 above a face
};

// `slack`: how far beyond the sides the closest point can be.
template <class T>
inline Stretch<T> stretch_beside(const BoxSegment<T>& p, const Vector3<T>& normal, const T& slack) {
  T low = -p.half_length, high = p.half_length, off_2 = T(0);
  const auto clip = [&](const T& normal_i, const T& c_i, const T& u_i, const T& per_u_i, const T& half_i) {
    const Truth<T> side = abs(normal_i) > nearly;
    const T reach = half_i + slack;
    const T from = (-reach - c_i) * per_u_i, to = (reach - c_i) * per_u_i;
    low = select(side, low, max(min(from, to), low));
    high = select(side, high, min(max(from, to), high));
    off_2 = off_2 + select(side, u_i * u_i, T(0));
    return side;
  };
  const Vector3<T>&c = p.centre, &u = p.along;
  const Truth<T> x = clip(normal.x, c.x, u.x, p.per_along.x, p.box.x);
  const Truth<T> y = clip(normal.y, c.y, u.y, p.per_along.y, p.box.y);
  const Truth<T> z = clip(normal.z, c.z, u.z, p.per_along.z, p.box.z);
  return {low, high, select((x & y) | (x & z) | (y & z), off_2, T(0))};
}

// A box around the origin, along the axes, with half the sides `half`, and a capsule: a segment of half length
// `half_length` around c, along the unit vector u.
template <class T>
[[gnu::always_inline]] inline RoundContact<T> contact_of_box_and_segment(const Vector3<T>& half, const Vector3<T>& c,
                                                                         const Vector3<T>& u, const T& half_length,
                                                                         const T& radius) {
  const BoxSegment<T> p = {half, c, u, {T(1) / u.x, T(1) / u.y, T(1) / u.z}, half_length, radius};
  T t = closest_to_box(p);
  const Vector3<T> w = excess(c + t * u, half);
  T distance = sqrt(dot(w, w));
  const T size = half.x + half.y + half.z + half_length + radius;
  Vector3<T> normal = T(1) / max(distance, T(nothing)) * w;
  if (const Truth<T> meet = distance <= meeting * size; any(meet)) {
    const WayOut<T> way = least_depth(p);
    normal = select(meet, way.normal, normal);
    t = select(meet, way.t, t);
    distance = select(meet, T(0), distance);
  }

  const Stretch<T> stretch = stretch_beside(p, normal, nearly * distance + meeting * size);
  // Of segments through the box, the deepest end is within the stretch; of those parallel to a face, both ends are.
  t = select(distance == T(0), clamped(t, stretch.low, stretch.high), t);

  const auto at = [&](const T& t, const T& tilt, Vector3<T>& position) {
    const Vector3<T> x = c + t * u, below = foot(x, normal, half, tilt);
    position = T(.5) * ((below + x) - radius * normal);
    return dot(normal, x - below) - radius;
  };
  Vector3<T> closest;
  const T exact = at(t, T(meeting), closest);
  RoundContact<T> contact = one_point(normal, closest, exact);

  const T off = stretch.off_2 * (T(4) * half_length * half_length), limit = nearly * radius;
  const Truth<T> lies = (stretch.high - stretch.low > limit) & (off <= limit * limit);
  const auto end = [&](const T& t, Vector3<T>& position) { return at(t, T(nearly), position); };
  take_ends(lies, stretch.low, stretch.high, meeting * size, end, contact);
  return contact;
}

}  // namespace lockstep::rigid
