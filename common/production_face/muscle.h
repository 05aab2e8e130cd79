// Muscle: tension along a fibre of a tetrahedron. For a number or for lanes.
//
//   t = sigma (a d f(l) + p(l)),   l = |F w|,
//
// where w is the fibre's direction at rest, a unit vector; l its stretch; a the activation, from 0 to 1; d the share of
// the tetrahedron that is muscle; sigma the greatest tension, Pa. f is what an active muscle can pull, most at its
// length at rest and nothing below .4 and above 1.6 of it; p is what a passive one resists when it is stretched, an
// exponential that goes on as a line from 1.4. Both have a continuous slope.
//
//   P += (t / l) (F w) w^T,   dP += [(t / l) dF w + c (F w) (F w . dF w)] w^T,   c = (t' - t / l) / l^2
//
// The energy is the integral of t over l. The derivative is made definite by taking 0 for t' where it is negative.
//
// Source: Teran, Sifakis, Irving and Fedkiw, Robust quasistatic finite elements and flesh simulation, SCA 2005; Zajac,
//         Muscle and tendon, Crit. Rev. Biomed. Eng. 17 (1989).
#pragma once

#include "common/math.h"
#include "common/transcendental.h"

namespace lockstep::production_face {

// What a curve gives at a stretch, its slope, and its integral from where it begins.
template <class T>
struct Curve {
  T value, slope, integral;
};

// f.
template <class T>
inline Curve<T> active_curve(const T& stretch) {
  const T e = stretch - T(1), size = abs(e), from_end = size - T(.6f);
  const auto is_middle = size < T(.4f), is_inside = size < T(.6f), is_long = e > T(0);
  const T middle = T(1) - T(25.f / 6) * e * e, side = T(25.f / 3) * from_end * from_end;
  const T side_slope = T(50.f / 3) * from_end, of_side = T(25.f / 9) * from_end * from_end * from_end;
  // The integrals of a side and of the middle.
  const T one_side(25.f / 9 * .008f), half_middle(.4f - 25.f / 18 * .064f);
  const T whole = T(2) * (one_side + half_middle);
  const T in_middle = one_side + half_middle + e * (T(1) - T(25.f / 18) * e * e);
  const T in_side = select(is_long, whole + of_side, T(0) - of_side);
  const T outside = select(is_long, whole, T(0));
  return {select(is_middle, middle, select(is_inside, side, T(0))),
          select(is_middle, T(-25.f / 3) * e, select(is_inside, select(is_long, side_slope, T(0) - side_slope), T(0))),
          select(is_middle, in_middle, select(is_inside, in_side, outside))};
}

// p.
template <class T>
inline Curve<T> passive_curve(const T& stretch) {
  constexpr float rate = 6.6f, scale = .05f, end = .4f;
  const T e = stretch - T(1), bounded = min(max(e, T(0)), T(end)), beyond = max(e - T(end), T(0));
  const T growth = exp(T(rate) * bounded);
  const T value = T(scale) * (growth - T(rate) * bounded - T(1)), slope = T(scale * rate) * (growth - T(1));
  const T integral = T(scale) * ((growth - T(1)) / T(rate) - bounded * (T(1) + T(.5f * rate) * bounded));
  return {value + beyond * slope, slope, integral + beyond * (value + T(.5f) * beyond * slope)};
}

// Of a tetrahedron, per its volume.
template <class T>
struct Tension {
  T per_stretch;  // t / l, Pa
  T along;        // c, Pa
  T energy;       // J/m^3
};

// `pull` is sigma a d, Pa; `passive` is sigma, 0 where there is no muscle. `definite`: negative slopes count as 0.
template <class T, class Mask>
inline Tension<T> tension(const T& stretch, const T& pull, const T& passive, const Mask& definite) {
  const Curve<T> f = active_curve(stretch), p = passive_curve(stretch);
  const T t = pull * f.value + passive * p.value, slope = pull * f.slope + passive * p.slope;
  // Below .4 there is no tension, so that a fibre without length pulls in no direction.
  const auto pulls = stretch > T(.25f);
  const T per_stretch = select(pulls, t / select(pulls, stretch, T(1)), T(0));
  const T kept = select(definite, max(slope, T(0)), slope);
  const T along = select(pulls, (kept - per_stretch) / select(pulls, stretch * stretch, T(1)), T(0));
  return {per_stretch, along, pull * f.integral + passive * p.integral};
}

}  // namespace lockstep::production_face
