// When, where and along which normal a pair meets that the tests of ccd_filters.h did not dismiss. In double, for a
// pair or for sixteen in lanes; differences of floats are exact there, unless one is 2^29 times the other.
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
// and d is the whole step. E is taken 16 times as large, for the extremes' rounding: as E = 496 u S, where S, the
// cubic's size, is at least M.
//
// A root need not be exact: any time of the interval of |f| <= E around it will do. Newton's last step s leaves at most
// s^2 / 2 of |f''| <= 24 M; so it ends with |s| <= 2^-25, which leaves 2^-46.4 M, where E is 2^-44.05 S. What halving
// leaves is at most 2^-48 wide, and |f'| <= 6 M.
#pragma once

#include "common/production_cloth/ccd_nearest.h"
#include "common/transcendental.h"

namespace lockstep::production_cloth::meeting {

template <class V>
struct Impact {
  V time;  // share of the step
  V weight[4];
  Vector3<V> normal;
};

// What the search needs of a pair.
template <class V>
struct Pair {
  Spans<V> spans;
  V tolerance;  // m: nearer than this is touching
  V speed;      // m a step: no two points of the elements approach faster
};

template <class V>
inline V length(const Vector3<V>& v) {
  return sqrt(dot(v, v));
}

template <Kind kind, class V>
inline Pair<V> make_pair(const Spans<V>& spans) {
  Pair<V> pair = {spans, 0.f, 0.f};
  for (const Vector3<V>& most : spans.most)
    pair.tolerance = max(pair.tolerance, V(0x1p-26f) * max(most.x, max(most.y, most.z)));
  // Points of elements move with averages of their vertices' velocities.
  Vector3<V> velocity[4] = {{0.f, 0.f, 0.f}};
  for (int k = 0; k < 3; ++k) velocity[k + 1] = spans.end[k] - spans.start[k];
  V speed_2 = 0.f;
  for (int i = 0; i < first_of<kind>; ++i)
    for (int j = first_of<kind>; j < 4; ++j) {
      const Vector3<V> relative = velocity[i] - velocity[j];
      speed_2 = max(speed_2, dot(relative, relative));
    }
  pair.speed = sqrt(speed_2);
  return pair;
}

template <class V>
inline void spans_at(const Pair<V>& pair, V time, Vector3<V> (&span)[3]) {
  for (int k = 0; k < 3; ++k) span[k] = (V(1.f) - time) * pair.spans.start[k] + time * pair.spans.end[k];
}
template <Kind kind, class V>
inline Nearest<V> nearest_at(const Pair<V>& pair, V time) {
  Vector3<V> span[3];
  spans_at(pair, time, span);
  return nearest<kind>(span);
}

// The first time from `from` to `to` at which the pair touches, or a negative number, where `going`. Elements that are
// `distance` apart do not touch for distance / speed. If the rounds run out, the pair counts as touching.
template <Kind kind, class V>
inline V advance(const Pair<V>& pair, V from, V to, MaskOf<V> going) {
  constexpr int most_rounds = 64;
  V time = from;
  for (int round = 0; round < most_rounds; ++round) {
    const V distance = length(nearest_at<kind>(pair, time).apart);
    going &= distance > pair.tolerance;
    if (none(going)) break;
    time = select(going, time + (distance - V(.5f) * pair.tolerance) / pair.speed, time);
    const MaskOf<V> goes_on = going & (time <= to);
    time = select(going & !goes_on, V(-1.f), time);
    going = goes_on;
  }
  return time;
}

// The cubic and its derivative, in Bernstein's basis.
template <class V>
inline V value_at(const Cubic<V>& f, V t) {
  const V s = V(1.f) - t;
  return s * s * (s * f.b0 + t * f.b1_3) + t * t * (s * f.b2_3 + t * f.b3);
}
template <class V>
struct Slope {
  V d0, d1, d2;
  V at(V t) const {
    const V s = V(1.f) - t;
    return s * (s * d0 + V(2.f) * t * d1) + t * t * d2;
  }
};
template <class V>
inline Slope<V> slope_of(const Cubic<V>& f) {
  return {f.b1_3 - V(3.f) * f.b0, f.b2_3 - f.b1_3, V(3.f) * f.b3 - f.b2_3};
}

// Where `open`, the root between two times where f has different signs, or the one time if they are equal: Newton's
// steps, and halving where these lead out of the interval or do not shrink it fast.
template <class V>
inline V root_between(const Cubic<V>& f, const Slope<V>& slope, V left, V right, V at_left, MaskOf<V> open) {
  constexpr int most_rounds = 100;
  const MaskOf<V> rises = V(0.f) > at_left;
  const MaskOf<V> falls = at_left > V(0.f);
  V t = V(.5f) * (left + right), last = right - left;
  for (int round = 0; round < most_rounds && any(open); ++round) {
    const V value = value_at(f, t);
    const MaskOf<V> is_left = (rises & (value < V(0.f))) | (falls & (value > V(0.f)));
    left = select(is_left, t, left), right = select(is_left, right, t);
    const V next = t - value / slope.at(t), step = abs(next - t), middle = V(.5f) * (left + right);
    const MaskOf<V> goes_on = (step > V(0x1p-25f)) & (right - left > V(0x1p-48f));
    const MaskOf<V> halves = goes_on & !((next > left) & (next < right) & (step <= V(.5f) * last));
    const V chosen = select(halves, middle, max(min(next, right), left));
    last = select(halves, right - middle, step);
    t = select(open, chosen, t);
    open &= goes_on;
  }
  return t;
}

// Extremes of f, or two other times of [0, 1] that do no harm, in order.
template <class V>
struct Extremes {
  V first, second;
};
template <class V>
inline Extremes<V> extremes_of(const Slope<V>& slope) {
  // a t^2 + 2 b t + c
  const V a = slope.d0 - V(2.f) * slope.d1 + slope.d2, b = slope.d1 - slope.d0, c = slope.d0;
  const V root = sqrt(max(b * b - a * c, V(0.f))), q = select(b < V(0.f), root - b, -root - b);
  const auto time = [](V over, V under) {
    const V t = over / under;
    return select(t > V(0.f), min(t, V(1.f)), V(0.f));
  };
  const V t = time(q, a), u = time(c, q);
  return {min(t, u), max(t, u)};
}

// The first time at which the pair touches, or a negative number.
template <Kind kind, class V>
inline V first_touch(const Pair<V>& pair, const Cubic<V>& f) {
  const V rounding = V(16.f) * rounding_of_middle(f);
  const V greatest = max(max(abs(f.b0), abs(f.b3)), max(abs(f.b1_3), abs(f.b2_3)) / V(3.f));
  const V doubt_3 = V(160.f) * rounding / greatest;  // d^3 of the above
  V touch = -1.f;
  MaskOf<V> open = !never_in_plane(f);
  const auto search = [&](MaskOf<V> doubtful, V from, V to) {
    if (any(doubtful)) touch = select(doubtful, advance<kind>(pair, from, to, doubtful), touch);
  };
  const auto look_at = [&](V time) {
    const V distance = length(nearest_at<kind>(pair, time).apart);
    const MaskOf<V> apart = distance > pair.tolerance;
    touch = select(open & !apart, time, touch);
    const V away = (distance - pair.tolerance) / (V(2.f) * pair.speed);  // twice, for rounding
    const MaskOf<V> doubtful = open & apart & !(away * away * away > doubt_3);
    if (any(doubtful)) {
      const V doubt = cbrt(doubt_3);
      search(doubtful, max(time - doubt, V(0.f)), min(time + doubt, V(1.f)));
    }
  };
  const MaskOf<V> throughout = open & !(doubt_3 < V(1.f));
  search(throughout, 0.f, 1.f);
  open &= !throughout;

  const Slope<V> slope = slope_of(f);
  const auto [first, second] = extremes_of(slope);
  // Times to look at: node k if at[2 k], and the root between nodes k and k + 1 if at[2 k + 1].
  const V node[4] = {0.f, first, second, 1.f};
  V value[4];
  MaskOf<V> at[7];
  for (int k = 0; k < 4; ++k) {
    value[k] = value_at(f, node[k]);
    at[2 * k] = abs(value[k]) <= rounding;
    if (k > 0)
      at[2 * k - 1] = ((value[k - 1] < V(0.f)) & (value[k] > V(0.f))) | ((value[k - 1] > V(0.f)) & (value[k] < V(0.f)));
  }
  while (any(open)) {
    V left = 0.f, right = 0.f, at_left = 0.f;
    MaskOf<V> searching = open;
    for (int k = 0; k < 7; ++k) {
      const MaskOf<V> next = searching & at[k];
      left = select(next, node[k / 2], left), right = select(next, node[(k + 1) / 2], right);
      at_left = select(next, value[k / 2], at_left);
      at[k] &= !next, searching &= !next;
    }
    open &= !searching;
    look_at(root_between(f, slope, left, right, at_left, open));
    open &= touch < V(0.f);
  }
  return touch;
}

// v over its length, or 0 where it is too short for that to have a meaning.
template <class V>
inline Vector3<V> unit_or_none(const Vector3<V>& v, V least_length) {
  const V of_v = length(v);
  return select(of_v > least_length, (V(1.f) / of_v) * v, Vector3<V>{0.f, 0.f, 0.f});
}

template <Kind kind, class V>
inline Vector3<V> normal_at(const Pair<V>& pair, V time, const V (&weight)[4]) {
  constexpr double least_sine = 1e-6;  // of the angle between two edges, or between normal and velocity
  const V zero = 0.f;
  Vector3<V> span[3], velocity = {zero, zero, zero};
  spans_at(pair, time, span);
  for (int k = 0; k < 3; ++k) velocity = velocity + weight[k + 1] * (pair.spans.end[k] - pair.spans.start[k]);
  const Vector3<V> e = kind == Kind::point_triangle ? span[1] - span[0] : span[0];
  const Vector3<V> f = kind == Kind::point_triangle ? span[2] - span[0] : span[2] - span[1];
  Vector3<V> normal = unit_or_none(cross(e, f), V(least_sine) * length(e) * length(f));
  // Also where there is no normal yet.
  const MaskOf<V> unclear = abs(dot(normal, velocity)) <= V(least_sine) * length(velocity);
  if (any(unclear)) {
    const Vector3<V> apart = nearest_at<kind>(pair, max(time - V(.015625f), zero)).apart;
    const Vector3<V> earlier = unit_or_none(apart, V(4.f) * pair.tolerance);
    const Vector3<V> against = unit_or_none(-velocity, pair.tolerance);
    const Vector3<V> any_of_them = select(dot(normal, normal) > zero, normal, Vector3<V>{zero, zero, 1.f});
    const Vector3<V> or_against = select(dot(against, against) > zero, against, any_of_them);
    normal = select(unclear, select(dot(earlier, velocity) < zero, earlier, or_against), normal);
  }
  return select(dot(normal, velocity) > zero, -normal, normal);
}

// Which pairs meet; of these, the impact.
template <Kind kind, class V>
inline MaskOf<V> find_impact(const Corners<V>& corners, Impact<V>& impact) {
  const Pair<V> pair = make_pair<kind>(spans_of(corners));
  impact.time = first_touch<kind>(pair, cubic_of(pair.spans));
  const MaskOf<V> meets = impact.time >= V(0.f);
  if (none(meets)) return meets;
  const Nearest<V> at_impact = nearest_at<kind>(pair, impact.time);
  for (int i = 0; i < 4; ++i) impact.weight[i] = at_impact.weight[i];
  impact.normal = normal_at<kind>(pair, impact.time, impact.weight);
  return meets;
}

}  // namespace lockstep::production_cloth::meeting
