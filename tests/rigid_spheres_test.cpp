// Spheres and capsules against spheres, capsules and boxes: closed forms, an exact oracle on random and on degenerate
// pairs, both orders of a pair, and both versions against each other.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>

#include "common/rigid/narrow_phase.h"
#include "tests/exact_convex.h"
#include "tests/rigid_shapes.h"

namespace lockstep::rigid {
namespace {

template <class Real>
std::vector<Manifold<Real>> collide(const Shapes& shapes, const Pairs& pairs, double margin) {
  std::vector<Manifold<Real>> manifolds(pairs.size());
  serial::spheres(Rounded<Real>(shapes).placed(), pairs, static_cast<Real>(margin), manifolds);
  return manifolds;
}

constexpr double everything = 1e9;

// The oracle does not divide by the length of a segment that has none.
ExactShape exact(const Shapes& shapes, int k) {
  ExactShape shape = exact_collider(Placed<double>{shapes.colliders, shapes.hulls, shapes.pose}, k);
  if (shape.vertex.size() == 2 && length(shape.vertex[1] - shape.vertex[0]) == 0)
    shape = exact_shape({shape.vertex[0]}, {}, shape.radius);
  return shape;
}
double size_of(const Shapes& shapes, const Pair& pair) {
  const auto size = [&](int k) {
    const Quad<double>& s = shapes.colliders.size[k];
    return s.x + s.y + s.z + s.w;
  };
  return size(pair.a) + size(pair.b);
}

// Distance of a point from a core.
double distance_from(const ExactShape& shape, const Vector3<double>& point) {
  ExactShape core = shape;
  core.radius = 0;
  return std::abs(exact_separation(core, exact_shape({point}, {})).separation);
}

// What must hold of the points of one pair, whatever it is:
//   - at least one point; a unit normal; no NaN
//   - the least separation is the exact distance, or depth, within 1e-5 of the shapes' size
//   - moved along the normal by as much, the shapes just touch: no gap nor overlap along it beyond what the normal's
//     own rounding gives. Coordinates are good to some 2e-7 of the size in float, so a normal between points a distance
//     apart is good to 2e-7 size / distance
//   - the deepest point is midway between the surfaces; of two, what separates the surfaces across the normal is up to
//     a tenth of the radii on the side that the normal leaves, and on others as much of the distance twice, for the
//     tilt and for the point beyond the edge; half of it counts
template <class Real>
void expect_exact(const Shapes& shapes, const Pair& pair, const Manifold<Real>& m) {
  const ExactShape a = exact(shapes, pair.a), b = exact(shapes, pair.b);
  const double size = size_of(shapes, pair), radii = a.radius + b.radius;
  const double separation = exact_separation(a, b).separation;
  const Vector3<double> n = {m.normal.x, m.normal.y, m.normal.z};
  ASSERT_TRUE(m.count == 1 || m.count == 2) << m.count;
  EXPECT_EQ(m.a, pair.a);
  EXPECT_EQ(m.b, pair.b);
  EXPECT_NEAR(length(n), 1, 1e-6);
  int deepest = 0;
  for (int k = 1; k < m.count; ++k)
    if (m.point[k].separation < m.point[deepest].separation) deepest = k;
  const double found = m.point[deepest].separation;
  EXPECT_NEAR(found, separation, 1e-5 * size);
  const double apart = separation + radii;
  // Below 1e-6, to the same 2e-7, normals do not come from it.
  const double turned = apart > .8e-6 * size ? 2e-7 * size / apart : 0;
  EXPECT_GE(separation_along(a, b, n) - radii, separation - (2e-5 + 2 * turned) * size);
  const Vector3<double> p = {m.point[deepest].position.x, m.point[deepest].position.y, m.point[deepest].position.z};
  const double surface = (2e-5 + turned) * size + (m.count == 2 ? .05 * radii + .15 * std::abs(apart) : 0);
  EXPECT_NEAR(distance_from(a, p - found / 2 * n), a.radius, surface);
  EXPECT_NEAR(distance_from(b, p + found / 2 * n), b.radius, surface);
}

template <class Real>
void expect_all_exact(const Shapes& shapes, const Pairs& pairs) {
  const std::vector<Manifold<Real>> manifolds = collide<Real>(shapes, pairs, everything);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    SCOPED_TRACE("pair " + std::to_string(k));
    expect_exact(shapes, pairs[k], manifolds[k]);
    if (testing::Test::HasFailure()) return;
  }
}

// Pairs of any kinds that the kernel takes, near one another. Some are parallel, or nearly; some have coordinates in
// common.
void random_pairs(int count, std::uint32_t seed, Shapes& shapes, Pairs& pairs) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto one_in = [&](int n) { return random() % n == 0; };
  const auto add = [&](int kind, const Pose<double>& pose) {
    if (kind == 0) return shapes.sphere(uniform(.05, .5), pose);
    if (kind == 1) return shapes.capsule(one_in(8) ? 0 : uniform(.05, 1), uniform(.02, .3), pose);
    return shapes.box({uniform(.05, 1), uniform(.05, 1), uniform(.05, 1)}, pose);
  };
  for (int k = 0; k < count; ++k) {
    int kind_a = random() % 3, kind_b = random() % 3;
    if (kind_a == 2 && kind_b == 2) kind_b = 1;
    const Quaternion<double> q = any_turn(random);
    const Vector3<double> p = {uniform(-3, 3), uniform(-3, 3), uniform(-3, 3)};
    Quaternion<double> other = any_turn(random);
    const int how = random() % 6;
    if (how == 0) other = q;
    if (how == 1) other = q * turn({uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}, std::pow(10, uniform(-7, -1)));
    if (how == 2) other = q * turn({1, 0, 0}, std::numbers::pi / 2 + std::pow(10, uniform(-7, -1)));
    const double reach = uniform(0, 1.5);
    Vector3<double> d = {uniform(-reach, reach), uniform(-reach, reach), uniform(-reach, reach)};
    if (one_in(4)) d.x = 0;
    if (one_in(4)) d.y = 0;
    if (one_in(4)) d.z = 0;
    const int a = add(kind_a, at(p, q)), b = add(kind_b, at(p + matrix_of(q) * d, other));
    pairs.push_back({a, b});
  }
}

TEST(RigidSpheres, KeepClosedForms) {
  Shapes shapes;
  const int a = shapes.sphere(1, at({0, 0, 0})), b = shapes.sphere(.5, at({2, 0, 0}));
  const int lying = shapes.capsule(1, .25, at({0, 2, 0}, turn({0, 0, 1}, std::numbers::pi / 2)));  // along x, above a
  const int cube = shapes.box({1, 1, 1}, at({4, 0, 0}));
  const std::vector<Manifold<double>> m =
      collide<double>(shapes, {{a, b}, {a, lying}, {b, cube}, {lying, cube}}, everything);
  EXPECT_DOUBLE_EQ(m[0].point[0].separation, .5);
  EXPECT_DOUBLE_EQ(m[0].point[0].position.x, 1.25);
  EXPECT_DOUBLE_EQ(m[0].normal.x, 1);
  EXPECT_NEAR(m[1].point[0].separation, .75, 1e-12);
  EXPECT_NEAR(m[1].point[0].position.y, 1.375, 1e-12);
  EXPECT_NEAR(m[2].point[0].separation, .5, 1e-12);
  EXPECT_NEAR(m[3].point[0].separation, std::sqrt(5) - .25, 1e-7);  // the cosine of pi / 4 squared is no double
}

TEST(RigidSpheres, TouchWithinTheMarginAlone) {
  Shapes shapes;
  const int a = shapes.sphere(1, at({0, 0, 0})), b = shapes.sphere(1, at({2.5, 0, 0})),
            c = shapes.sphere(1, at({0, 2, 0}));
  EXPECT_EQ(collide<float>(shapes, {{a, b}}, .5)[0].count, 1);
  EXPECT_EQ(collide<float>(shapes, {{a, b}}, .49)[0].count, 0);
  EXPECT_EQ(collide<float>(shapes, {{a, c}}, 0)[0].count, 1);
}

TEST(RigidSpheres, AreExactOnRandomPairs) {
  Shapes shapes;
  Pairs pairs;
  random_pairs(20000, 1, shapes, pairs);
  expect_all_exact<float>(shapes, pairs);
  expect_all_exact<double>(shapes, pairs);
}

TEST(RigidSpheres, AreExactWhereShapesAreDegenerate) {
  Shapes shapes;
  Pairs pairs;
  const double quarter = std::numbers::pi / 2;
  const auto pair = [&](int a, int b) { pairs.push_back({a, b}); };
  const int point = shapes.sphere(.5, at({0, 0, 0})), same = shapes.sphere(.25, at({0, 0, 0}));
  const int none = shapes.capsule(0, .5, at({0, 0, 0})),
            none_too = shapes.capsule(0, .25, at({0, 0, 0}, turn({1, 2, 3}, 1)));
  const int along = shapes.capsule(1, .25, at({0, 0, 0})),
            against = shapes.capsule(1, .25, at({0, 0, 0}, turn({1, 0, 0}, 2 * quarter)));
  const int crossing = shapes.capsule(1, .25, at({0, 0, 0}, turn({1, 0, 0}, quarter)));
  for (const int a : {point, same, none, none_too, along, against, crossing})
    for (const int b : {point, same, none, none_too, along, against, crossing})
      if (a < b) pair(a, b);
  // In line, overlapping, touching and apart; parallel beside one another; at the end of one another; spheres without a
  // radius
  for (const double y : {.5, 1., 2., 2.5, 3.}) pair(along, shapes.capsule(1, .25, at({0, y, 0})));
  for (const double y : {.5, 1., 2., 2.5, 3.})
    pair(along, shapes.capsule(1, .25, at({.25, y, .25}, turn({0, 0, 1}, 2 * quarter))));
  for (const double y : {-1., 0., 1.}) pair(along, shapes.capsule(1, .25, at({0, y, 1}, turn({1, 0, 0}, quarter))));
  pair(along, shapes.capsule(1, 0, at({0, 0, 0}, turn({1, 0, 0}, quarter))));
  pair(shapes.sphere(0, at({1, 1, 1})), shapes.sphere(0, at({1, 1, 1})));

  // On every side, edge and corner of a box, inside and beyond, a point and segments in all main directions and aslant.
  const Vector3<double> half = {1, .5, .25};
  const int box = shapes.box(half, at({0, 0, 0}));
  for (const double x : {-1.5, -1., -.75, 0., .75, 1., 1.5})
    for (const double y : {-1.5, -1., -.75, 0., .75, 1., 1.5})
      for (const double z : {-1.5, -1., -.75, 0., .75, 1., 1.5}) {
        const Vector3<double> p = {x * half.x, y * half.y, z * half.z};
        pair(box, shapes.sphere(.125, at(p)));
        pair(box, shapes.capsule(0, .125, at(p)));
        for (const double h : {.125, .5, 3.}) {
          pair(box, shapes.capsule(h, .125, at(p)));
          pair(box, shapes.capsule(h, .125, at(p, turn({1, 0, 0}, quarter))));
          pair(box, shapes.capsule(h, .125, at(p, turn({0, 0, 1}, quarter))));
          pair(box, shapes.capsule(h, .125, at(p, turn({0, 0, 1}, quarter / 2))));
          pair(box, shapes.capsule(h, .125, at(p, turn({1, 0, 1}, quarter / 2))));
          pair(box, shapes.capsule(h, .125, at(p, turn({1, 0, 0}, quarter + 1e-5))));
        }
      }
  expect_all_exact<float>(shapes, pairs);
  expect_all_exact<double>(shapes, pairs);
}

// Where distances cancel: cores that nearly meet, at any angle.
TEST(RigidSpheres, AreExactWhereCoresNearlyMeet) {
  std::mt19937 random(3);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  Shapes shapes;
  Pairs pairs;
  for (int k = 0; k < 20000; ++k) {
    const double gap = std::pow(10, uniform(-9, -2)), angle = std::pow(10, uniform(-8, 0));
    const Quaternion<double> q = turn({uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}, uniform(0, 3));
    const Matrix3<double> axes = matrix_of(q);
    const Quaternion<double> turned = q * turn({0, 0, 1}, angle);
    const Vector3<double> centre = {uniform(-2, 2), uniform(-2, 2), uniform(-2, 2)};
    const double half_b = uniform(.1, 1);
    const Vector3<double> d = gap * axes.z + uniform(-1, 1) * axes.y + uniform(-1, 1) * half_b * matrix_of(turned).y;
    if (k % 2 == 0)
      pairs.push_back({shapes.capsule(1, .25, at(centre, q)), shapes.capsule(half_b, .25, at(centre + d, turned))});
    else  // over a face; the capsule within its plane is turned out of it, too
      pairs.push_back(
          {shapes.box({.75, 1, .5}, at(centre, q)),
           shapes.capsule(half_b, .25,
                          at(centre + .5 * axes.z + d, turned * turn({1, 0, 0}, std::pow(10, uniform(-8, 0)))))});
  }
  expect_all_exact<float>(shapes, pairs);
}

TEST(RigidSpheres, CapsulesThatLieHaveTwoPoints) {
  const double quarter = std::numbers::pi / 2;
  Shapes shapes;
  const int floor = shapes.box({2, .5, 1}, at({0, 0, 0}));
  const Quaternion<double> along_x = turn({0, 0, 1}, quarter), along_z = turn({1, 0, 0}, quarter);
  const int lying = shapes.capsule(1, .25, at({.5, .74, 0}, along_x)),
            beyond = shapes.capsule(1, .25, at({1.5, .74, 0}, along_x));
  const int slanted = shapes.capsule(1, .25, at({0, .75, 0}, turn({0, 0, 1}, quarter + .02)));
  const int over_edge = shapes.capsule(1, .25, at({0, .5 + .2, 1.1}, along_x));  // along the edge, beside the face
  const int upright = shapes.capsule(1, .25, at({0, 1.74, 0})),
            steep = shapes.capsule(1, .25, at({0, .74, .5}, turn({1, 0, 0}, .5)));
  const int across_edge =
      shapes.capsule(1, .25, at({0, .5 + .17, 1 + .17}, turn({-.5, 0, -std::sqrt(.5)}, std::numbers::pi / 3)));
  const int log_a = shapes.capsule(1, .25, at({0, 3, 0})), log_b = shapes.capsule(.75, .25, at({.49, 3.5, 0}));
  const int log_c = shapes.capsule(1, .25, at({-.49, 3, 0}, along_z)),
            log_d = shapes.capsule(1, .25, at({0, 3, .5}, turn({0, 0, 1}, .02)));
  const std::vector<Manifold<double>> m = collide<double>(shapes,
                                                          {{floor, lying},
                                                           {floor, beyond},
                                                           {floor, slanted},
                                                           {floor, over_edge},
                                                           {floor, upright},
                                                           {floor, steep},
                                                           {floor, across_edge},
                                                           {log_a, log_b},
                                                           {log_a, log_c},
                                                           {log_a, log_d}},
                                                          .02);
  const auto ends = [&](int k) { return std::minmax(m[k].point[0].position.x, m[k].point[1].position.x); };
  ASSERT_EQ(m[0].count, 2);
  EXPECT_NEAR(ends(0).first, -.5, 1e-6);
  EXPECT_NEAR(ends(0).second, 1.5, 1e-6);
  EXPECT_NEAR(m[0].point[0].separation, -.01, 1e-7);
  EXPECT_NEAR(m[0].point[0].position.y, .495, 1e-7);
  EXPECT_NE(m[0].feature[0], m[0].feature[1]);
  ASSERT_EQ(m[1].count, 2);  // up to the edge, and by a tenth of its distance beyond
  EXPECT_NEAR(ends(1).first, .5, 1e-6);
  EXPECT_NEAR(ends(1).second, 2, .1 * .25 + 1e-6);
  EXPECT_GE(ends(1).second, 2 - 1e-6);
  EXPECT_EQ(m[2].count, 2);  // the higher end is 2 sin .02 above the lower: 2 cm on either side of the middle
  EXPECT_EQ(m[3].count, 2);
  EXPECT_EQ(m[4].count, 1);
  EXPECT_EQ(m[5].count, 1);
  EXPECT_EQ(m[6].count, 1);
  ASSERT_EQ(m[7].count, 2);
  EXPECT_NEAR(std::min(m[7].point[0].position.y, m[7].point[1].position.y), 2.75, 1e-9);
  EXPECT_NEAR(std::max(m[7].point[0].position.y, m[7].point[1].position.y), 4, 1e-9);
  EXPECT_EQ(m[8].count, 1);
  EXPECT_EQ(m[9].count, 2);  // 2 cm off each end: less than a tenth of the radii
}

// A pair the other way round has the same points, and the opposite normal wherever the direction is determined.
TEST(RigidSpheres, DoNotDependOnTheOrderOfAPair) {
  Shapes shapes, turned;
  Pairs pairs, other;
  random_pairs(5000, 2, shapes, pairs);
  const int count = shapes.colliders.count;
  for (int k = count - 1; k >= 0; --k) {
    const Colliders<double>& c = shapes.colliders;
    turned.add(static_cast<Kind>(c.kind[k]), c.hull[k], c.size[k], shapes.pose[k]);
  }
  for (const auto& [a, b] : pairs) other.push_back({count - 1 - b, count - 1 - a});
  const std::vector<Manifold<double>> m = collide<double>(shapes, pairs, everything),
                                      n = collide<double>(turned, other, everything);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    double least_m = everything, least_n = everything;
    for (int p = 0; p < m[k].count; ++p) least_m = std::min(least_m, m[k].point[p].separation);
    for (int p = 0; p < n[k].count; ++p) least_n = std::min(least_n, n[k].point[p].separation);
    ASSERT_NEAR(least_m, least_n, 1e-5 * size_of(shapes, pairs[k])) << k;
    const ExactShape a = exact(shapes, pairs[k].a), b = exact(shapes, pairs[k].b);
    const double apart = least_m + a.radius + b.radius;
    if (apart < 1e-3) continue;
    // Axes of rounded quaternions are unit to 2e-7, so that closest points are off by as much of the size, differently
    // for either order.
    ASSERT_NEAR(length(m[k].normal + n[k].normal), 0, 4e-7 * size_of(shapes, pairs[k]) / apart) << k;
    // Of capsules, the stretch is measured along the first, and may be long enough along one alone.
    if (m[k].count != n[k].count) {
      ASSERT_TRUE(a.vertex.size() == 2 && b.vertex.size() == 2) << k;
      continue;
    }
    for (int p = 0; p < m[k].count; ++p) {
      double nearest = everything;
      for (int q = 0; q < n[k].count; ++q)
        nearest = std::min(nearest, length(m[k].point[p].position - n[k].point[q].position));
      // Of two, the ends are measured along the one or the other; one of parallel capsules is anywhere on a stretch of
      // a tenth of the radii.
      const bool parallel = a.vertex.size() == 2 && b.vertex.size() == 2;
      ASSERT_NEAR(nearest, 0, m[k].count == 2 ? .1 : parallel ? .1 * (a.radius + b.radius) : 1e-4) << k;
    }
  }
}

TEST(RigidSpheres, AreBitwiseTheSameInParallel) {
  Shapes shapes;
  Pairs pairs;
  random_pairs(5000, 4, shapes, pairs);
  for (int k = 0; k < 500; ++k) pairs.push_back(pairs[0]), pairs.push_back(pairs[1]);
  const Rounded<float> rounded(shapes);
  const int before = omp_get_max_threads();
  for (const float margin : {0.f, .05f, 1e9f})
    for (const std::size_t count :
         {std::size_t(0), std::size_t(1), std::size_t(15), std::size_t(16), std::size_t(17), pairs.size()}) {
      const std::span<const Pair> some(pairs.data(), count);
      std::vector<Manifold<float>> expected(count);
      serial::spheres(rounded.placed(), some, margin, expected);
      for (const int threads : {1, 2, 3, 8}) {
        omp_set_num_threads(threads);
        std::vector<Manifold<float>> manifolds(count);
        openmp::spheres(rounded.placed(), some, margin, manifolds);
        for (std::size_t k = 0; k < count; ++k)
          ASSERT_EQ(std::memcmp(&manifolds[k], &expected[k], sizeof(Manifold<float>)), 0)
              << k << " of " << count << ", margin " << margin;
      }
    }
  omp_set_num_threads(before);
}

}  // namespace
}  // namespace lockstep::rigid
