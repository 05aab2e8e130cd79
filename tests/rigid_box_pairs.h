// Random pairs of boxes of many kinds, and the bounds on the rounding of their contacts.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <span>

#include "common/rigid/box_pair.h"
#include "common/rigid/make.h"
#include "common/rigid/narrow_phase.h"
#include "tests/exact_convex.h"

namespace lockstep::rigid::box_pairs {

using Vector = Vector3<double>;

// Boxes in pairs: pair k is colliders 2 k and 2 k + 1.
template <class Real>
struct Boxes {
  Colliders<Real> colliders;
  Hulls<Real> hulls;
  Array<Pose<Real>> pose;
  Pairs pairs;

  void add(const Pose<Real>& place, const Vector3<Real>& half) {
    const int i = colliders.count++;
    colliders.kind.push_back(static_cast<std::int32_t>(Kind::box));
    colliders.body.push_back(i), colliders.group.push_back(i), colliders.hull.push_back(cube_hull);
    colliders.size.push_back({half.x, half.y, half.z, 0});
    pose.push_back(place);
    if (i % 2 == 1) pairs.push_back({i - 1, i});
  }
  Placed<Real> placed() const { return {colliders, hulls, pose}; }
  Vector3<Real> half(int i) const { return {colliders.size[i].x, colliders.size[i].y, colliders.size[i].z}; }
  ExactShape exact(int i) const { return exact_box(half(i), pose[i]); }
  double size(int pair) const {
    double largest = 0;
    for (const int i : {2 * pair, 2 * pair + 1})
      largest = std::max({largest, double(half(i).x), double(half(i).y), double(half(i).z)});
    return largest;
  }
};

template <class Real>
Array<Manifold<Real>> run(Collide<Real>& collide, const Boxes<Real>& boxes, Real margin, std::size_t count) {
  Array<Manifold<Real>> manifolds(count);
  if (count > 0) std::memset(static_cast<void*>(manifolds.data()), 0x77, count * sizeof(Manifold<Real>));
  collide(boxes.placed(), std::span(boxes.pairs).first(count), margin, manifolds);
  return manifolds;
}

template <class To>
Pose<To> rounded(const Pose<double>& pose) {
  const auto& [p, q, unused] = pose;
  return {{To(p.x), To(p.y), To(p.z)}, {To(q.x), To(q.y), To(q.z), To(q.w)}, 0};
}

inline Quaternion<double> about(const Vector& axis, double angle) {
  const double scale = std::sin(angle / 2) / length(axis);
  return {scale * axis.x, scale * axis.y, scale * axis.z, std::cos(angle / 2)};
}

struct Random {
  std::mt19937 engine;
  double within(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
  double log_within(double low, double high) { return std::exp(within(std::log(low), std::log(high))); }
  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(engine); }
  Vector vector(double most) { return {within(-most, most), within(-most, most), within(-most, most)}; }
  Vector direction() {
    std::normal_distribution<double> normal;
    const Vector v = {normal(engine), normal(engine), normal(engine)};
    return 1 / length(v) * v;
  }
  Quaternion<double> rotation() {
    std::normal_distribution<double> normal;
    const Quaternion<double> q = {normal(engine), normal(engine), normal(engine), normal(engine)};
    const double n = std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
    return {q.x / n, q.y / n, q.z / n, q.w / n};
  }
  // A turn about one of the axes by a multiple of `angle`, 45 or 90 degrees.
  Quaternion<double> square_rotation(double angle) {
    const Vector axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    return about(axes[below(3)], angle * below(8));
  }
  Vector half(double low, double high) { return {log_within(low, high), log_within(low, high), log_within(low, high)}; }
};

inline constexpr double pi = 3.14159265358979323846;
enum Sort { general, touching, tilted, aligned, equal_sizes, coincident, needles, ratio, crossing, sorts };

// Adds a pair of a sort. It is made in the frame of a, then moved as a whole to some place in the world.
inline void add_pair(Boxes<float>& boxes, Random& random, int sort) {
  Vector half_a = random.half(.2, 1), half_b = random.half(.2, 1);
  Pose<double> b = {random.vector(1.2), random.rotation(), 0};
  Quaternion<double> turn = random.rotation();
  Vector shift = random.vector(20);
  const auto push_apart = [&](double separation) {  // until the separation along the axis of least overlap is this
    const ExactSeparation now = separating_axis(exact_box(half_a, no_offset), exact_box(half_b, b));
    b.position = b.position + (separation - now.separation) * now.normal;
  };
  if (sort == touching) {
    push_apart(random.log_within(1e-7, .1) * (random.below(2) ? 1 : -1));
  } else if (sort == tilted) {  // one on the other, flush or very nearly
    const double tilt = random.below(4) == 0 ? 0 : random.log_within(1e-9, .3);
    b.orientation = about(random.direction(), tilt) * about({0, 1, 0}, random.below(2) ? random.within(0, 7) : 0);
    b.position = {random.within(-.5, .5), half_a.y + half_b.y, random.within(-.5, .5)};
    push_apart(random.below(4) == 0 ? 0 : random.log_within(1e-6, .05) * (random.below(2) ? 1 : -1));
  } else if (sort == aligned) {  // short numbers, for faces, edges and corners that meet exactly
    half_a = {.25 * (1 + random.below(4)), .25 * (1 + random.below(4)), .25 * (1 + random.below(4))};
    half_b = {.25 * (1 + random.below(4)), .25 * (1 + random.below(4)), .25 * (1 + random.below(4))};
    b = {{.25 * (random.below(17) - 8), .25 * (random.below(17) - 8), .25 * (random.below(17) - 8)}, no_rotation, 0};
    if (random.below(2)) b.orientation = random.square_rotation(pi / 4);
    turn = no_rotation, shift = {double(random.below(9)), double(random.below(9)), double(random.below(9))};
  } else if (sort == equal_sizes) {
    half_b = half_a;
    b.orientation =
        random.square_rotation(pi / 2) * about(random.direction(), random.below(2) ? 0 : random.log_within(1e-8, 1e-2));
    b.position = {0, 2 * half_a.y, 0};
    push_apart(random.below(2) ? 0 : random.within(-.02, .02));
  } else if (sort == coincident) {
    b.position = random.below(2) ? Vector{0, 0, 0} : random.vector(1e-6);
    if (random.below(2)) half_b = half_a, b.orientation = no_rotation;
  } else if (sort == needles) {
    half_a = {1, random.log_within(1e-3, 1e-2), random.log_within(1e-3, 1e-2)},
    half_b = {random.log_within(1e-3, 1e-2), 1, .5};
    if (random.below(2))
      b.orientation = about(random.direction(), random.log_within(1e-8, 1e-2)) * about({0, 0, 1}, pi / 2);
    push_apart(random.within(-.01, .01));
  } else if (sort == ratio) {
    half_a = random.half(20, 100), half_b = random.half(.02, .2);
    b.position = {random.within(-1, 1) * half_a.x, half_a.y, random.within(-1, 1) * half_a.z};
    push_apart(random.within(-.1, .1));
  } else if (sort == crossing) {  // edges across one another
    const double spread = random.log_within(1e-7, 1);
    b.orientation = about({0, 1, 0}, random.below(2) ? spread : pi / 2 - spread) * about({1, 0, 0}, pi / 4);
    half_a.x = half_b.x = 1;
    const Quaternion<double> up = about({1, 0, 0}, pi / 4 + random.below(2) * random.log_within(1e-6, .3));
    b.orientation = conjugate(up) * b.orientation;
    b.position =
        matrix_of(conjugate(up)) * Vector{random.within(-.5, .5), random.within(.3, 1.3), random.within(-.2, .2)};
    push_apart(random.within(-.05, .05));
  }
  const Matrix3<double> m = matrix_of(turn);
  boxes.add(rounded<float>({shift, turn, 0}), {float(half_a.x), float(half_a.y), float(half_a.z)});
  boxes.add(rounded<float>({shift + m * b.position, turn * b.orientation, 0}),
            {float(half_b.x), float(half_b.y), float(half_b.z)});
}

inline Boxes<float> random_boxes(int count, int seed) {
  Random random{std::mt19937(seed)};
  Boxes<float> boxes;
  for (int k = 0; k < count; ++k) add_pair(boxes, random, random.below(2) ? general : random.below(sorts));
  return boxes;
}

// Rounding, relative to size (u = 2^-24). A quaternion rounded to float is off from unit length by up to 2 u. The
// kernel takes this for a scale of the turn (4 u of size in the extents of each of the two boxes); the oracle
// normalises. The separation itself is good to 10 u size (common/rigid/box_pair.h). Edges left out as parallel cost
// axis_preference.
inline constexpr double u = 1. / (1 << 24);
inline constexpr double answer_bound = 4 * 4 * u + 10 * u + axis_preference;
// The bound on depth adds the cost of preferring one axis, and one deepest point, to another.
inline constexpr double depth_bound = answer_bound + 2 * axis_preference;
static_assert(depth_bound < 1e-5);
// For boxes that are apart, an axis across two edges at a small angle can point anywhere around them, and may give a
// separation larger than the faces' by any factor. Its rounding is 4 u / sine times the way between the centres, which
// is less than 4 size for near boxes. The oracle leaves out axes at a sine below least_sine.
inline constexpr double least_sine = .1, apart_bound = depth_bound + 4 * 4 * u / least_sine;

inline Vector vector_of(const Vector3<float>& v) { return {v.x, v.y, v.z}; }

inline constexpr int random_pairs = 200000;

}  // namespace lockstep::rigid::box_pairs
