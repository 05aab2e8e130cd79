// When, where and along which normal a pair meets that the tests of ccd_filters.h did not dismiss. In double, for one
// pair; differences of floats are exact there, unless one is 2^29 times the other.
//
// The vertices of a pair that meets are in one plane: the cubic f of Cubic is 0. So the pair is tested at f's roots,
// and at its extremes and both ends where f is 0 within rounding. At each of these times, in order, the distance of the
// elements decides. That is a better test than whether the weights are inside: it has an answer for parallel edges and
// needles, and its tolerance is a length.
//
// No time is missed. Let E be the rounding of f, and M the greatest magnitude of f's coefficients in Bernstein's basis.
// Their greatest is at most 5 times the greatest of f itself (equal for Chebyshev's polynomial). By Remez' inequality,
// |f| <= E holds in [0, 1] at times of total measure d, with max |f| <= E T_3(2/d - 1) <= 32 E / d^3; so
// d <= (160 E / M)^(1/3). Each interval of such times contains a root, an extreme, or an end of [0, 1] - else f would
// be monotone with one sign, and not E at both ends of the interval. So a pair that meets is looked at within d of when
// it does. There, its distance is at most d times the greatest relative speed. If it is less than that, but not within
// the tolerance, the pair is in doubt: then time is searched from d before to d after by conservative advancement,
// which no pair escapes. That is rare, but for pairs that move in their common plane: M is 0 but for rounding there,
// and d is the whole step. E is taken 16 times as large, for the extremes' rounding.
#pragma once

#include <cmath>

#include "common/production_cloth/ccd_nearest.h"

namespace lockstep::production_cloth::meeting {

struct Impact {
  double time;  // share of the step
  double weight[4];
  Vector3<double> normal;
};

// What the search needs of a pair.
struct Pair {
  Spans<double> spans;
  double tolerance;  // m: nearer than this is touching
  double speed;      // m a step: no two points of the elements approach faster
};

inline double length(const Vector3<double>& v) { return std::sqrt(dot(v, v)); }

template <Kind kind>
inline Pair make_pair(const Spans<double>& spans) {
  Pair pair = {spans, 0, 0};
  for (const Vector3<double>& most : spans.most)
    pair.tolerance = max(pair.tolerance, 0x1p-26 * max(most.x, max(most.y, most.z)));
  // Points of elements move with averages of their vertices' velocities.
  Vector3<double> velocity[4] = {{0, 0, 0}};
  for (int k = 0; k < 3; ++k) velocity[k + 1] = spans.end[k] - spans.start[k];
  double speed_2 = 0;
  for (int i = 0; i < first_of<kind>; ++i)
    for (int j = first_of<kind>; j < 4; ++j) {
      const Vector3<double> relative = velocity[i] - velocity[j];
      speed_2 = max(speed_2, dot(relative, relative));
    }
  pair.speed = std::sqrt(speed_2);
  return pair;
}

template <Kind kind>
inline Nearest<double> nearest_at(const Pair& pair, double time) {
  Vector3<double> span[3];
  for (int k = 0; k < 3; ++k) span[k] = (1 - time) * pair.spans.start[k] + time * pair.spans.end[k];
  return nearest<kind>(span);
}

// The first time from `from` to `to` at which the pair touches, or a negative number. Elements that are `distance`
// apart do not touch for distance / speed. If the rounds run out, the pair counts as touching.
template <Kind kind>
inline double advance(const Pair& pair, double from, double to) {
  constexpr int most_rounds = 64;
  double time = from;
  for (int round = 0; round < most_rounds; ++round) {
    const double distance = length(nearest_at<kind>(pair, time).apart);
    if (!(distance > pair.tolerance)) return time;
    time += (distance - pair.tolerance / 2) / pair.speed;
    if (!(time <= to)) return -1;
  }
  return time;
}

// The cubic and its derivative, in Bernstein's basis.
inline double value_at(const Cubic<double>& f, double t) {
  const double s = 1 - t;
  return s * s * (s * f.b0 + t * f.b1_3) + t * t * (s * f.b2_3 + t * f.b3);
}
struct Slope {
  double d0, d1, d2;
  double at(double t) const { return (1 - t) * ((1 - t) * d0 + 2 * t * d1) + t * t * d2; }
};
inline Slope slope_of(const Cubic<double>& f) { return {f.b1_3 - 3 * f.b0, f.b2_3 - f.b1_3, 3 * f.b3 - f.b2_3}; }

// The root between two times where f has different signs: Newton's steps, and halving where these lead out of the
// interval or do not shrink it fast.
inline double root_between(const Cubic<double>& f, const Slope& slope, double left, double right, double at_left) {
  constexpr int most_rounds = 100;
  double t = (left + right) / 2, last = right - left;
  for (int round = 0; round < most_rounds; ++round) {
    const double value = value_at(f, t);
    if (value == 0) return t;
    ((value < 0) == (at_left < 0) ? left : right) = t;
    double next = t - value / slope.at(t);
    if (!(next > left && next < right && std::abs(next - t) <= last / 2)) next = (left + right) / 2;
    last = std::abs(next - t);
    t = next;
    if (last <= 0x1p-46) break;
  }
  return t;
}

// Extremes of f, or two other times of [0, 1] that do no harm, in order.
struct Extremes {
  double first, second;
};
inline Extremes extremes_of(const Slope& slope) {
  const double a = slope.d0 - 2 * slope.d1 + slope.d2, b = slope.d1 - slope.d0, c = slope.d0;  // a t^2 + 2 b t + c
  const double root = std::sqrt(max(b * b - a * c, 0.)), q = b < 0 ? root - b : -root - b;
  const auto time = [](double over, double under) {
    const double t = over / under;
    return t > 0 ? min(t, 1.) : 0.;
  };
  const double t = time(q, a), u = time(c, q);
  return {min(t, u), max(t, u)};
}

// The first time at which the pair touches, or a negative number.
template <Kind kind>
inline double first_touch(const Pair& pair, const Cubic<double>& f) {
  const double rounding = 16 * rounding_of_middle(f);
  const double greatest = max(max(abs(f.b0), abs(f.b3)), max(abs(f.b1_3), abs(f.b2_3)) / 3);
  const double doubt_3 = 160 * rounding / greatest;  // d^3 of the above
  if (!(doubt_3 < 1)) return advance<kind>(pair, 0, 1);

  const auto touch_near = [&](double time) {
    const double distance = length(nearest_at<kind>(pair, time).apart);
    if (!(distance > pair.tolerance)) return time;
    const double away = (distance - pair.tolerance) / (2 * pair.speed);  // twice, for rounding
    if (away * away * away > doubt_3) return -1.;
    const double doubt = std::cbrt(doubt_3);
    return advance<kind>(pair, max(time - doubt, 0.), min(time + doubt, 1.));
  };
  const Slope slope = slope_of(f);
  const auto [first, second] = extremes_of(slope);
  const double node[4] = {0, first, second, 1};
  double before = f.b0;
  for (int k = 0; k < 4; ++k) {
    const double value = value_at(f, node[k]);
    if (k > 0 && ((before < 0 && value > 0) || (before > 0 && value < 0)))
      if (const double time = touch_near(root_between(f, slope, node[k - 1], node[k], before)); time >= 0) return time;
    if (abs(value) <= rounding)
      if (const double time = touch_near(node[k]); time >= 0) return time;
    before = value;
  }
  return -1;
}

// v over its length, or 0 where it is too short for that to have a meaning.
inline Vector3<double> unit_or_none(const Vector3<double>& v, double least_length) {
  const double of_v = length(v);
  return of_v > least_length ? (1 / of_v) * v : Vector3<double>{0, 0, 0};
}

template <Kind kind>
inline Vector3<double> normal_at(const Pair& pair, double time, const double (&weight)[4]) {
  constexpr double least_sine = 1e-6;  // of the angle between two edges, or between normal and velocity
  Vector3<double> span[3], velocity = {0, 0, 0};
  for (int k = 0; k < 3; ++k) {
    span[k] = (1 - time) * pair.spans.start[k] + time * pair.spans.end[k];
    velocity = velocity + weight[k + 1] * (pair.spans.end[k] - pair.spans.start[k]);
  }
  const Vector3<double> e = kind == Kind::point_triangle ? span[1] - span[0] : span[0];
  const Vector3<double> f = kind == Kind::point_triangle ? span[2] - span[0] : span[2] - span[1];
  Vector3<double> normal = unit_or_none(cross(e, f), least_sine * length(e) * length(f));
  if (abs(dot(normal, velocity)) <= least_sine * length(velocity)) {  // also where there is no normal yet
    const Vector3<double> apart = nearest_at<kind>(pair, max(time - .015625, 0.)).apart;
    const Vector3<double> earlier = unit_or_none(apart, 4 * pair.tolerance);
    const Vector3<double> against = unit_or_none(-velocity, pair.tolerance);
    if (dot(earlier, velocity) < 0)
      normal = earlier;
    else if (dot(against, against) > 0)
      normal = against;
    else if (!(dot(normal, normal) > 0))
      normal = {0, 0, 1};
  }
  return dot(normal, velocity) > 0 ? -normal : normal;
}

template <Kind kind>
inline bool find_impact(const Corners<double>& corners, Impact& impact) {
  const Pair pair = make_pair<kind>(spans_of(corners));
  const Cubic<double> f = cubic_of(pair.spans);
  if (never_in_plane(f)) return false;
  impact.time = first_touch<kind>(pair, f);
  if (!(impact.time >= 0)) return false;
  const Nearest<double> at_impact = nearest_at<kind>(pair, impact.time);
  for (int i = 0; i < 4; ++i) impact.weight[i] = at_impact.weight[i];
  impact.normal = normal_at<kind>(pair, impact.time, impact.weight);
  return true;
}

}  // namespace lockstep::production_cloth::meeting
