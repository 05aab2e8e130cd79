// Pairs of convex shapes for tests of convex_axes and convex_clip, and what holds of every manifold.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "common/rigid/convexes.h"
#include "common/rigid/make.h"
#include "common/rigid/narrow_phase.h"
#include "tests/exact_convex.h"

namespace lockstep::rigid::convex_pairs {

using Vector = Vector3<double>;
inline constexpr double pi = std::numbers::pi;

// Shapes, each a collider, in pairs: pair k is colliders 2 k and 2 k + 1.
struct Cases {
  World<double> world = make_world();
  std::vector<Pose<double>> pose;

  Cases() { begin_body(world, no_offset); }
  void box(const Vector& half, const Pose<double>& at) { add_box(world, half), pose.push_back(at); }
  void hull(int which, const Pose<double>& at) { add_hull(world, which), pose.push_back(at); }
  void sphere(double radius, const Pose<double>& at) { add_sphere(world, radius), pose.push_back(at); }
  void capsule(double half, double radius, const Pose<double>& at) {
    add_capsule(world, half, radius), pose.push_back(at);
  }
  // Adds a triangle. If the pose is at rest, its corners are the given ones; the collider stands at their middle.
  void triangle(const Vector& p, const Vector& q, const Vector& r, const Pose<double>& at) {
    add_mesh(world, Mesh{{p, q, r}, {{0, 1, 2}}});
    const Pose<double>& local = world.colliders.local[world.colliders.count - 1];
    pose.push_back({at.position + matrix_of(at.orientation) * local.position, at.orientation, 0});
  }
};

// The results of the kernels. Pair k is collider 2 k against 2 k + 1, or the other way round.
template <class Real>
struct Collided {
  World<Real> world;
  Array<Pose<Real>> pose;
  Pairs pairs;
  std::vector<Simplex> simplex;
  std::vector<SeparatingAxis<Real>> axis;
  std::vector<Manifold<Real>> manifold;

  Collided(const Cases& cases, bool turned_round = false) : world(convert<Real>(cases.world)) {
    for (const auto& [p, q, unused] : cases.pose)
      pose.push_back({{Real(p.x), Real(p.y), Real(p.z)}, {Real(q.x), Real(q.y), Real(q.z), Real(q.w)}, 0});
    for (int k = 0; k + 1 < static_cast<int>(pose.size()); k += 2)
      pairs.push_back(turned_round ? Pair{k + 1, k} : Pair{k, k + 1});
    simplex.resize(pairs.size());
    axis.resize(pairs.size());
    manifold.resize(pairs.size());
  }
  Placed<Real> placed() const { return {world.colliders, world.hulls, pose}; }
  void run(Gjk<Real>& gjk, ConvexAxes<Real>& convex_axes, ConvexClip<Real>& convex_clip, Real margin) {
    std::vector<Closest<Real>> closest(pairs.size());
    gjk(placed(), pairs, simplex, closest);
    convex_axes(placed(), pairs, simplex, closest, margin, axis);
    convex_clip(placed(), pairs, axis, margin, manifold);
  }
  void serial(Real margin) { run(serial::gjk, serial::convex_axes, serial::convex_clip, margin); }
  void openmp(Real margin) { run(openmp::gjk, openmp::convex_axes, openmp::convex_clip, margin); }
  ExactShape a(int k) const { return exact_collider(placed(), pairs[k].a); }
  ExactShape b(int k) const { return exact_collider(placed(), pairs[k].b); }
  double deepest(int k) const {
    double least = std::numeric_limits<double>::infinity();
    for (int i = 0; i < manifold[k].count; ++i) least = std::min<double>(least, manifold[k].point[i].separation);
    return least;
  }
};

inline double extent(const ExactShape& shape) {
  double most = 0;
  for (const Vector& p : shape.vertex)
    for (const Vector& q : shape.vertex) most = std::max(most, length(p - q));
  return most + 2 * shape.radius;
}

struct Random {
  std::mt19937 engine{1};
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
  Vector direction() {
    for (;;) {
      const Vector v = {in(-1, 1), in(-1, 1), in(-1, 1)};
      if (const double l = length(v); l > .1 && l < 1) return 1 / l * v;
    }
  }
  Quaternion<double> rotation() {
    const Vector axis = direction();
    const double half = in(0, pi);
    return {std::sin(half) * axis.x, std::sin(half) * axis.y, std::sin(half) * axis.z, std::cos(half)};
  }
  Pose<double> pose(const Vector& position) { return {position, rotation(), 0}; }
};

inline int random_hull(Hulls<double>& hulls, Random& random, int points, const Vector& half) {
  std::vector<Vector> all;
  for (int k = 0; k < points; ++k) {
    const Vector d = random.direction();
    all.push_back({half.x * d.x, half.y * d.y, half.z * d.z});
  }
  return make_hull(hulls, all);
}

inline Vector vector(const Vector3<float>& v) { return {v.x, v.y, v.z}; }

inline const Pose<double> at_rest = no_offset;
inline Pose<double> at(const Vector& position) { return {position, no_rotation, 0}; }
inline Pose<double> turned(const Vector& position, const Vector& axis, double angle) {
  const double s = std::sin(angle / 2);
  return {position, {s * axis.x, s * axis.y, s * axis.z, std::cos(angle / 2)}, 0};
}

// The distance of a point from the surface of a core with faces, right for points inside or within rounding of it.
inline double above_surface(const ExactShape& shape, const Vector& point) {
  double highest = -std::numeric_limits<double>::infinity();
  for (std::size_t f = 0; f < shape.face.size(); ++f)
    highest = std::max(highest, dot(shape.normal[f], point - shape.vertex[shape.face[f][0]]));
  return highest;
}

// The manifold has finite numbers, a unit normal, and points between the two surfaces.
inline void expect_sound(const Collided<float>& run, int k, float margin) {
  const Manifold<float>& m = run.manifold[k];
  ASSERT_GE(m.count, 0);
  ASSERT_LE(m.count, most_points);
  EXPECT_EQ(m.a, run.pairs[k].a);
  EXPECT_EQ(m.b, run.pairs[k].b);
  if (m.count == 0) return;
  EXPECT_NEAR(length(vector(m.normal)), 1, 1e-5) << k;
  const ExactShape a = run.a(k), b = run.b(k);
  for (int i = 0; i < m.count; ++i) {
    const auto& [position, separation] = m.point[i];
    EXPECT_TRUE(std::isfinite(position.x) && std::isfinite(position.y) && std::isfinite(position.z)) << k;
    EXPECT_LE(separation, margin) << k;
    const Vector half = .5 * separation * vector(m.normal);
    // If the cores are apart, the closest points on a thin face are known only to rounding divided by the face's width,
    // here about a hundredth of its length.
    const double rounding = (separation + a.radius + b.radius > 0 ? 1e-4 : 1e-5) * (extent(a) + extent(b));
    if (!a.face.empty() && a.radius == 0) {
      EXPECT_NEAR(above_surface(a, vector(position) - half), 0, rounding) << k << ' ' << i << ' ' << m.feature[i] % 256;
    }
    if (!b.face.empty() && b.radius == 0) {
      EXPECT_NEAR(above_surface(b, vector(position) + half), 0, rounding) << k << ' ' << i << ' ' << m.feature[i] % 256;
    }
    for (int j = 0; j < i; ++j) EXPECT_NE(m.feature[i], m.feature[j]) << k;
  }
}

inline std::vector<int> random_hulls(Hulls<double>& hulls, Random& random, int count, int least, int most) {
  std::vector<int> result;
  for (int k = 0; k < count; ++k)
    result.push_back(random_hull(hulls, random, least + k % (most - least + 1),
                                 {random.in(.3, 1), random.in(.3, 1), random.in(.3, 1)}));
  return result;
}

// Hulls and boxes at random places, up to `far` from one another.
inline Cases random_cases(int count, double far, int seed) {
  Random random{std::mt19937(seed)};
  Cases cases;
  const std::vector<int> small = random_hulls(cases.world.hulls, random, 20, 5, 12),
                         large = random_hulls(cases.world.hulls, random, 4, 24, 24);
  const auto shape = [&](const Pose<double>& pose) {
    const unsigned k = random.engine() % 1000;
    if (k % 5 == 0)
      cases.box({random.in(.2, .8), random.in(.2, .8), random.in(.2, .8)}, pose);
    else
      cases.hull(k % 40 == 1 ? large[k / 40 % 4] : small[k % 20], pose);
  };
  for (int k = 0; k < count; ++k) {
    const Vector centre = {random.in(-5, 5), random.in(-5, 5), random.in(-5, 5)};
    shape(random.pose(centre));
    shape(random.pose(centre + random.in(0, far) * random.direction()));
  }
  return cases;
}

}  // namespace lockstep::rigid::convex_pairs
