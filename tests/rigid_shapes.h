// Colliders for tests, put where a test wants them.
#pragma once

#include <cmath>
#include <random>
#include <type_traits>
#include <vector>

#include "common/rigid/make.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

// Colliders, placed; in double, as numbers that float has, so that both precisions and the oracle see the same.
struct Shapes {
  Hulls<double> hulls = make_world().hulls;
  Colliders<double> colliders;
  Array<Pose<double>> pose;

  int add(Kind kind, int hull, const Quad<double>& size, const Pose<double>& at) {
    const auto as_float = [](double x) { return static_cast<double>(static_cast<float>(x)); };
    Colliders<double>& c = colliders;
    c.kind.push_back(static_cast<std::int32_t>(kind)), c.hull.push_back(hull);
    c.size.push_back({as_float(size.x), as_float(size.y), as_float(size.z), as_float(size.w)});
    const auto& [p, q, unused] = at;
    pose.push_back({{as_float(p.x), as_float(p.y), as_float(p.z)},
                    {as_float(q.x), as_float(q.y), as_float(q.z), as_float(q.w)},
                    0});
    return c.count++;
  }
  int sphere(double radius, const Pose<double>& at) { return add(Kind::sphere, point_hull, {0, 0, 0, radius}, at); }
  int capsule(double half, double radius, const Pose<double>& at) {
    return add(Kind::capsule, segment_hull, {0, half, 0, radius}, at);
  }
  int hull(int hull, const Pose<double>& at) { return add(Kind::hull, hull, {1, 1, 1, 0}, at); }
  int plane(const Pose<double>& at) { return add(Kind::plane, -1, {0, 0, 0, 0}, at); }
  int box(const Vector3<double>& half, const Pose<double>& at) {
    return add(Kind::box, cube_hull, {half.x, half.y, half.z, 0}, at);
  }
};

inline Pose<double> at(const Vector3<double>& position, const Quaternion<double>& orientation = no_rotation) {
  return {position, orientation, 0};
}
inline Quaternion<double> turn(const Vector3<double>& axis, double angle) {
  const double s = std::sin(angle / 2) / std::sqrt(dot(axis, axis));
  return {s * axis.x, s * axis.y, s * axis.z, std::cos(angle / 2)};
}

template <class Real>
struct Rounded {
  Colliders<Real> colliders;
  Hulls<Real> hulls;
  Array<Pose<Real>> pose;
  Placed<Real> placed() const { return {colliders, hulls, pose}; }

  explicit Rounded(const Shapes& shapes) {
    const Colliders<double>& c = shapes.colliders;
    colliders.count = c.count, colliders.kind = c.kind, colliders.hull = c.hull;
    for (const Quad<double>& s : c.size) colliders.size.push_back({Real(s.x), Real(s.y), Real(s.z), Real(s.w)});
    World<double> library;
    library.hulls = shapes.hulls;
    if constexpr (std::is_same_v<Real, double>)
      hulls = shapes.hulls;
    else
      hulls = convert<Real>(library).hulls;
    for (const auto& [p, q, unused] : shapes.pose)
      pose.push_back({{Real(p.x), Real(p.y), Real(p.z)}, {Real(q.x), Real(q.y), Real(q.z), Real(q.w)}, 0});
  }
};

// Any orientation, none more likely than another.
inline Quaternion<double> any_turn(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Quaternion<double> q = {normal(random), normal(random), normal(random), normal(random)};
  const double s = 1 / std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  return {s * q.x, s * q.y, s * q.z, s * q.w};
}

}  // namespace lockstep::rigid
