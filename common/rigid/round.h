// Which formula of spheres a pair of kinds takes, and the small steps of those formulas (round_contacts.h), for T a
// number or floatv.
#pragma once

#include "common/math.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

enum class RoundForm : std::int32_t { points, segments, box_point, box_segment };
inline constexpr int round_forms = 4;

// Of two kinds of which none but sphere, capsule and box occurs, and box at most once. A sphere among capsules is a
// segment of no length.
inline RoundForm round_form(Kind a, Kind b) {
  const bool capsule = a == Kind::capsule || b == Kind::capsule;
  if (a == Kind::box || b == Kind::box) return capsule ? RoundForm::box_segment : RoundForm::box_point;
  return capsule ? RoundForm::segments : RoundForm::points;
}

// The feature of a point: it is the only one, or the lower or upper end, along the capsule's axis, of the stretch on
// which the capsule lies on the other shape.
inline constexpr std::int32_t only_point = 0, lower_end = 1, upper_end = 2;

// Cores nearer than this times the sum of the shapes' sizes have no direction from one to the other but rounding: the
// coordinates of both are good to about 1e-7 of that sum.
inline constexpr float meeting = 1e-6f;

// Nearly parallel, so that two points are worth having. What is taken for the distance of a point aside is the part of
// it along the normal. It is less than the distance by the fraction e^2 / 2 where the part across the normal is e of
// it: half a percent. Points nearer to each other than this of the radii are one.
inline constexpr float nearly = .1f;

// Lengths below this are nothing, m: their squares are well above where float loses digits.
inline constexpr float nothing = 1e-15f;

template <class T>
inline T clamped(T x, T low, T high) {
  return min(max(x, low), high);
}
// By how far x is outside -half .. half, with its sign; 0 inside.
template <class T>
inline T excess(T x, T half) {
  return x - clamped(x, -half, half);
}
template <class T>
inline Vector3<T> excess(const Vector3<T>& x, const Vector3<T>& half) {
  return {excess(x.x, half.x), excess(x.y, half.y), excess(x.z, half.z)};
}

// Unit, perpendicular to the unit vector u: Duff et al., J. Computer Graphics Techniques 6 (2017).
template <class T>
inline Vector3<T> perpendicular(const Vector3<T>& u) {
  const T sign = select(u.z < T(0), T(-1), T(1));
  const T a = T(-1) / (sign + u.z);
  return {u.x * u.y * a, sign + u.y * u.y * a, -u.y};
}

// The point of a box that the point x beside it rests on, one coordinate at a time: on the side that the normal leaves
// by more than `tilt`, and otherwise below x.
template <class T>
inline T foot(T x, T normal, T half, T tilt) {
  return select(abs(normal) > tilt, select(normal > T(0), half, -half), clamped(x, -half, half));
}
template <class T>
inline Vector3<T> foot(const Vector3<T>& x, const Vector3<T>& normal, const Vector3<T>& half, const T& tilt) {
  return {foot(x.x, normal.x, half.x, tilt), foot(x.y, normal.y, half.y, tilt), foot(x.z, normal.z, half.z, tilt)};
}

}  // namespace lockstep::rigid
