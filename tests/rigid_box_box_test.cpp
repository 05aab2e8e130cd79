// Box against box: closed forms, an independent yes or no (libccd), the exact oracle (exact_convex.h), and both versions bit by bit, over
// random pairs of many kinds and degenerate ones.
#include <ccd/ccd.h>
#include <ccd/quat.h>
#include <gtest/gtest.h>
#include <omp.h>

#include <array>
#include <cmath>
#include <cstring>
#include <random>

#include "common/rigid/box_pair.h"
#include "common/rigid/make.h"
#include "common/rigid/narrow_phase.h"
#include "tests/exact_convex.h"

namespace lockstep::rigid {
namespace {

using Vector = Vector3<double>;

// Boxes two by two: pair k is of colliders 2 k and 2 k + 1.
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
    for (const int i : {2 * pair, 2 * pair + 1}) largest = std::max({largest, double(half(i).x), double(half(i).y), double(half(i).z)});
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

Quaternion<double> about(const Vector& axis, double angle) {
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
  // About one of the axes, by a multiple of 45 or 90 degrees.
  Quaternion<double> square_rotation(double angle) {
    const Vector axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    return about(axes[below(3)], angle * below(8));
  }
  Vector half(double low, double high) { return {log_within(low, high), log_within(low, high), log_within(low, high)}; }
};

constexpr double pi = 3.14159265358979323846;
enum Sort { general, touching, tilted, aligned, equal_sizes, coincident, needles, ratio, crossing, sorts };

// A pair of a sort, in the frame of a, then moved as a whole to some place in the world.
void add_pair(Boxes<float>& boxes, Random& random, int sort) {
  Vector half_a = random.half(.2, 1), half_b = random.half(.2, 1);
  Pose<double> b = {random.vector(1.2), random.rotation(), 0};
  Quaternion<double> turn = random.rotation();
  Vector shift = random.vector(20);
  const auto push_apart = [&](double separation) {  // to that far along the axis of least overlap
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
  } else if (sort == aligned) {  // all numbers short, so that faces, edges and corners meet exactly
    half_a = {.25 * (1 + random.below(4)), .25 * (1 + random.below(4)), .25 * (1 + random.below(4))};
    half_b = {.25 * (1 + random.below(4)), .25 * (1 + random.below(4)), .25 * (1 + random.below(4))};
    b = {{.25 * (random.below(17) - 8), .25 * (random.below(17) - 8), .25 * (random.below(17) - 8)}, no_rotation, 0};
    if (random.below(2)) b.orientation = random.square_rotation(pi / 4);
    turn = no_rotation, shift = {double(random.below(9)), double(random.below(9)), double(random.below(9))};
  } else if (sort == equal_sizes) {
    half_b = half_a;
    b.orientation = random.square_rotation(pi / 2) * about(random.direction(), random.below(2) ? 0 : random.log_within(1e-8, 1e-2));
    b.position = {0, 2 * half_a.y, 0};
    push_apart(random.below(2) ? 0 : random.within(-.02, .02));
  } else if (sort == coincident) {
    b.position = random.below(2) ? Vector{0, 0, 0} : random.vector(1e-6);
    if (random.below(2)) half_b = half_a, b.orientation = no_rotation;
  } else if (sort == needles) {
    half_a = {1, random.log_within(1e-3, 1e-2), random.log_within(1e-3, 1e-2)}, half_b = {random.log_within(1e-3, 1e-2), 1, .5};
    if (random.below(2)) b.orientation = about(random.direction(), random.log_within(1e-8, 1e-2)) * about({0, 0, 1}, pi / 2);
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
    b.position = matrix_of(conjugate(up)) * Vector{random.within(-.5, .5), random.within(.3, 1.3), random.within(-.2, .2)};
    push_apart(random.within(-.05, .05));
  }
  const Matrix3<double> m = matrix_of(turn);
  boxes.add(rounded<float>({shift, turn, 0}), {float(half_a.x), float(half_a.y), float(half_a.z)});
  boxes.add(rounded<float>({shift + m * b.position, turn * b.orientation, 0}), {float(half_b.x), float(half_b.y), float(half_b.z)});
}

Boxes<float> random_boxes(int count, int seed) {
  Random random{std::mt19937(seed)};
  Boxes<float> boxes;
  for (int k = 0; k < count; ++k) add_pair(boxes, random, random.below(2) ? general : random.below(sorts));
  return boxes;
}

// Rounding, relative to size (u = 2^-24): a quaternion rounded to float is off from unit length by up to 2 u, which the kernel takes for a
// scale of turn (4 u of size in each of two boxes' extents), where the oracle normalises; the separation itself is good to 10 u size
// (common/rigid/box_pair.h); and edges left out as parallel cost axis_preference.
constexpr double u = 1. / (1 << 24);
constexpr double answer_bound = 4 * 4 * u + 10 * u + axis_preference;
// Depth: as above, and what the preferences of one axis and of one deepest point to another cost.
constexpr double depth_bound = answer_bound + 2 * axis_preference;
static_assert(depth_bound < 1e-5);
// Of boxes that are apart, an axis across two edges at a small angle can be anywhere around them, may let them look farther apart than the
// faces do by any factor, and is rounded by 4 u / sine, times the way between the centres of boxes that are near, less than 4 size. Those
// at a sine below least_sine are not asked for.
constexpr double least_sine = .1, apart_bound = depth_bound + 4 * 4 * u / least_sine;

// ---- closed forms

struct OnePair {
  Pose<float> a, b;
  Vector3<float> half_a, half_b;
  Manifold<float> collide(float margin) const {
    Boxes<float> boxes;
    boxes.add(a, half_a), boxes.add(b, half_b);
    return run<float>(serial::box_box, boxes, margin, 1)[0];
  }
};
Pose<float> at(double x, double y, double z, const Quaternion<double>& q = {0, 0, 0, 1}) { return rounded<float>({{x, y, z}, q, 0}); }

TEST(BoxBox, AlignedBoxesTouchInTheRectangleTheyShare) {
  const OnePair pair = {at(0, 0, 0), at(.5f, 1.75f, .25f), {1, 1, 1}, {1, .875f, .5f}};  // .125 deep, along y
  const Manifold<float> m = pair.collide(0);
  ASSERT_EQ(m.count, 4);
  EXPECT_EQ(m.normal.x, 0);
  EXPECT_EQ(m.normal.y, 1);
  EXPECT_EQ(m.normal.z, 0);
  float low_x = 9, high_x = -9, low_z = 9, high_z = -9;
  for (int k = 0; k < 4; ++k) {
    const auto& [p, separation] = m.point[k];
    EXPECT_EQ(separation, -.125f);
    EXPECT_EQ(p.y, 1 - .0625f);
    low_x = std::min(low_x, p.x), high_x = std::max(high_x, p.x), low_z = std::min(low_z, p.z), high_z = std::max(high_z, p.z);
  }
  EXPECT_NEAR(low_x, -.5f, 5e-6);
  EXPECT_NEAR(high_x, 1, 5e-6);
  EXPECT_NEAR(low_z, -.25f, 5e-6);
  EXPECT_NEAR(high_z, .75f, 5e-6);
}

TEST(BoxBox, TouchingIsContactAndAHairApartIsNot) {
  for (const float gap : {0.f, 1e-6f, .01f}) {
    const OnePair pair = {at(0, 0, 0), at(0, 2 + gap, 0), {1, 1, 1}, {1, 1, 1}};
    EXPECT_EQ(pair.collide(0).count, gap > 0 ? 0 : 4) << gap;
    const Manifold<float> m = pair.collide(.02f);
    ASSERT_EQ(m.count, 4) << gap;
    for (int k = 0; k < 4; ++k) EXPECT_NEAR(m.point[k].separation, gap, 1e-6);
  }
}

TEST(BoxBox, CrossedEdgesTouchInOnePoint) {
  // Two square beams, edge on edge, one along x and one along z: sqrt(2) each from centre to edge.
  const float up = 2 * std::sqrt(2.f) - .125f;
  const OnePair pair = {at(0, 0, 0, about({1, 0, 0}, pi / 4)), at(.25f, up, .5f, about({0, 0, 1}, pi / 4)), {3, 1, 1}, {1, 1, 3}};
  const Manifold<float> m = pair.collide(0);
  ASSERT_EQ(m.count, 1);
  EXPECT_NEAR(m.normal.y, 1, 1e-6);
  EXPECT_NEAR(m.point[0].separation, -.125, 1e-6);
  EXPECT_NEAR(m.point[0].position.x, .25, 2e-6);
  EXPECT_NEAR(m.point[0].position.y, std::sqrt(2.) - .0625, 2e-6);
  EXPECT_NEAR(m.point[0].position.z, 0, 2e-6);
}

TEST(BoxBox, ACornerInAFaceIsOnePoint) {
  // A cube on its corner: the diagonal is upright.
  const Quaternion<double> upright = about({1, 0, -1}, std::acos(1 / std::sqrt(3.)));
  const OnePair pair = {at(0, 0, 0), at(.25f, 1 + .5f * std::sqrt(3.f) - .0625f, .125f, upright), {1, 1, 1}, {.5f, .5f, .5f}};
  const Manifold<float> m = pair.collide(0);
  EXPECT_NEAR(m.normal.y, 1, 1e-6);
  float least = 1;
  for (int k = 0; k < m.count; ++k)
    if (m.point[k].separation < least) {
      least = m.point[k].separation;
      EXPECT_NEAR(m.point[k].position.x, .25, 1e-5);
      EXPECT_NEAR(m.point[k].position.z, .125, 1e-5);
    }
  EXPECT_NEAR(least, -.0625, 1e-6);
}

// A resting box keeps its four points, wide apart, while its pose trembles; and where it rests on a larger one, their features.
TEST(BoxBox, AStackDoesNotFlicker) {
  Random random{std::mt19937(5)};
  std::int32_t features[4] = {-1, -1, -1, -1};
  for (int step = 0; step < 4000; ++step) {
    const bool larger = step % 2;
    const double trembling = step % 4 < 2 ? 1e-6 : 1e-3;
    const Quaternion<double> q = about(random.direction(), random.within(0, trembling)) * about({0, 1, 0}, .3);
    const Vector away = random.vector(trembling);
    const float side = larger ? 1 : .5f;
    const OnePair pair = {at(0, 0, 0), at(away.x, .98 + away.y, away.z, q), {side, .5f, side}, {.5f, .5f, .5f}};
    const Manifold<float> m = pair.collide(.02f);
    ASSERT_EQ(m.count, 4) << step;
    double low_x = 1, high_x = -1, low_z = 1, high_z = -1;
    for (int k = 0; k < 4; ++k) {
      const auto& p = m.point[k].position;
      low_x = std::min<double>(low_x, p.x), high_x = std::max<double>(high_x, p.x);
      low_z = std::min<double>(low_z, p.z), high_z = std::max<double>(high_z, p.z);
      if (larger && step > 1) {
        ASSERT_EQ(m.feature[k], features[k]) << step;
      }
      if (larger) features[k] = m.feature[k];
    }
    for (const double reach : {-low_x, high_x, -low_z, high_z}) ASSERT_GT(reach, .3) << step;
  }
}

// ---- against libccd and the oracle

Vector vector_of(const Vector3<float>& v) { return {v.x, v.y, v.z}; }

void support(const void* object, const ccd_vec3_t* direction, ccd_vec3_t* found) {
  const ExactShape& shape = *static_cast<const ExactShape*>(object);
  const Vector along = {direction->v[0], direction->v[1], direction->v[2]};
  const Vector* best = &shape.vertex[0];
  for (const Vector& v : shape.vertex)
    if (dot(v, along) > dot(*best, along)) best = &v;
  ccdVec3Set(found, best->x, best->y, best->z);
}

bool overlap_by_ccd(const ExactShape& a, const ExactShape& b) {
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = ccd.support2 = support;
  ccd.max_iterations = 500;
  return ccdGJKIntersect(&a, &b, &ccd);
}

// How far outside of a box a point is, m; negative inside: its depth below the nearest face.
double outside(const ExactShape& box, const Vector& point) {
  double most = -1e30;
  for (std::size_t f = 0; f < box.face.size(); ++f) most = std::max(most, dot(box.normal[f], point - box.vertex[box.face[f][0]]));
  return most;
}

constexpr int random_pairs = 200000;

TEST(BoxBox, AnswersAsLibccdDoes) {
  const Boxes<float> boxes = random_boxes(random_pairs, 1);
  const Array<Manifold<float>> manifolds = run<float>(serial::box_box, boxes, 0, boxes.pairs.size());
  int left_out = 0, overlapping = 0;
  for (std::size_t k = 0; k < boxes.pairs.size(); ++k) {
    const ExactShape a = boxes.exact(2 * k), b = boxes.exact(2 * k + 1);
    const double bound = std::max(answer_bound * boxes.size(k), 1e-7);  // the latter is libccd's
    if (std::abs(separating_axis(a, b).separation) <= bound) {
      ++left_out;
      continue;
    }
    const bool expected = overlap_by_ccd(a, b);
    overlapping += expected;
    ASSERT_EQ(manifolds[k].count > 0, expected) << k << ' ' << separating_axis(a, b).separation;
  }
  RecordProperty("left_out", left_out);
  RecordProperty("overlapping", overlapping);
  EXPECT_GT(overlapping, random_pairs / 4);
  EXPECT_LT(overlapping, random_pairs * 3 / 4);
  EXPECT_LT(left_out, random_pairs / 10);
}

// What must hold of every manifold.
void check_manifolds(const Boxes<float>& boxes, float margin) {
  const Array<Manifold<float>> manifolds = run<float>(serial::box_box, boxes, margin, boxes.pairs.size());
  double worst = 0;
  for (std::size_t k = 0; k < boxes.pairs.size(); ++k) {
    const Manifold<float>& m = manifolds[k];
    const ExactShape a = boxes.exact(2 * k), b = boxes.exact(2 * k + 1);
    const ExactSeparation exact = separating_axis(a, b);
    const double size = boxes.size(k), away = length(vector_of(boxes.pose[2 * k].position));
    const double least = exact.separation <= 0 ? exact.separation : separating_axis(a, b, least_sine).separation;
    if (least > margin + apart_bound * size) {
      ASSERT_EQ(m.count, 0) << k << ' ' << least;
    } else if (exact.separation < margin - answer_bound * size) {
      ASSERT_GT(m.count, 0) << k << ' ' << exact.separation;
    }
    if (m.count == 0) continue;

    ASSERT_LE(m.count, 4);
    ASSERT_EQ(m.a, boxes.pairs[k].a);
    ASSERT_EQ(m.b, boxes.pairs[k].b);
    const Vector normal = vector_of(m.normal);
    ASSERT_NEAR(length(normal), 1, 16 * u) << k;
    float deepest = m.point[0].separation;
    for (int p = 0; p < m.count; ++p) {
      const auto& [position, separation] = m.point[p];
      deepest = std::min(deepest, separation);
      ASSERT_TRUE(std::isfinite(position.x + position.y + position.z + separation)) << k;
      ASSERT_LE(separation, margin) << k;
      for (int q = 0; q < p; ++q) ASSERT_LT(m.feature[q], m.feature[p]) << k;
      if (exact.separation > 0) continue;
      // Half the separation either way along the normal is a point of either surface: within it to face_widening in x and in y, which a
      // step off along a face of the other box, no steeper than sqrt(2), turns into height; and the world's rounding.
      const double bound = (depth_bound + 2.5 * face_widening) * size + 4 * u * (away + 3 * size);
      const Vector middle = vector_of(position), half = .5 * separation * normal;
      ASSERT_NEAR(outside(a, middle - half), 0, bound) << k << ' ' << exact.separation << ' ' << m.count << ' ' << p;
      ASSERT_NEAR(outside(b, middle + half), 0, bound) << k << ' ' << exact.separation << ' ' << m.count << ' ' << p;
    }
    if (exact.separation <= 0) {
      worst = std::max(worst, std::abs(deepest - exact.separation) / size);
      ASSERT_NEAR(deepest, exact.separation, depth_bound * size) << k;
      ASSERT_NEAR(separation_along(a, b, normal), exact.separation, depth_bound * size) << k;
    } else {  // points that stand over one another may be farther apart than the axis says, never nearer
      ASSERT_GE(deepest, least - apart_bound * size) << k;
      ASSERT_GE(separation_along(a, b, normal), least - apart_bound * size) << k;
    }
  }
  testing::Test::RecordProperty("worst_depth_error", std::to_string(worst));
}

TEST(BoxBox, DepthAndPointsAreExact) { check_manifolds(random_boxes(random_pairs / 2, 2), 0); }
TEST(BoxBox, BoxesWithinTheMarginHavePoints) { check_manifolds(random_boxes(random_pairs / 4, 3), .05f); }

// In double, of the same pairs: only preferences are left of the bound.
TEST(BoxBox, DoubleIsExactButForPreferences) {
  const Boxes<float> single = random_boxes(random_pairs / 10, 7);
  Boxes<double> boxes;
  for (int i = 0; i < single.colliders.count; ++i) {
    Pose<double> pose = {vector_of(single.pose[i].position), about({1, 2, 3}, .1 * (i % 7)), 0};
    boxes.add(pose, vector_of(single.half(i)));
  }
  const Array<Manifold<double>> manifolds = run<double>(serial::box_box, boxes, 0, boxes.pairs.size());
  for (std::size_t k = 0; k < boxes.pairs.size(); ++k) {
    const ExactSeparation exact = separating_axis(boxes.exact(2 * k), boxes.exact(2 * k + 1));
    const double bound = 3 * axis_preference * boxes.size(k);
    if (std::abs(exact.separation) > bound) {
      ASSERT_EQ(manifolds[k].count > 0, exact.separation < 0) << k;
    }
    double deepest = 0;
    for (int p = 0; p < manifolds[k].count; ++p) deepest = std::min(deepest, manifolds[k].point[p].separation);
    ASSERT_NEAR(deepest, std::min(exact.separation, 0.), bound) << k;
  }
}

// ---- the other version, and the other order

void expect_same(const Array<Manifold<float>>& expected, const Array<Manifold<float>>& found) {
  ASSERT_EQ(expected.size(), found.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    ASSERT_EQ(expected[k].count, found[k].count) << k;
    if (expected[k].count > 0) {
      ASSERT_EQ(std::memcmp(&expected[k], &found[k], sizeof(expected[k])), 0) << k;
    }
  }
}

TEST(BoxBox, BothVersionsGiveTheSameBits) {
  const Boxes<float> boxes = random_boxes(random_pairs, 4);
  for (const float margin : {0.f, .05f}) {
    const Array<Manifold<float>> serial = run<float>(serial::box_box, boxes, margin, boxes.pairs.size());
    for (const int threads : {1, 2, 3, 8}) {
      omp_set_num_threads(threads);
      expect_same(serial, run<float>(openmp::box_box, boxes, margin, boxes.pairs.size()));
      for (const std::size_t count : {0, 1, 2, 15, 16, 17, 33, 300})
        expect_same(run<float>(serial::box_box, boxes, margin, count), run<float>(openmp::box_box, boxes, margin, count));
    }
  }
  omp_set_num_threads(omp_get_num_procs());
}

// Boxes in the other order: the same depth, the other way; and the same points, where rounding does not decide between two.
TEST(BoxBox, SwappingMirrors) {
  const Boxes<float> boxes = random_boxes(random_pairs / 4, 6);
  Boxes<float> other;
  for (const Pair& pair : boxes.pairs)
    for (const int i : {pair.b, pair.a}) other.add(boxes.pose[i], boxes.half(i));
  const Array<Manifold<float>> there = run<float>(serial::box_box, boxes, .05f, boxes.pairs.size());
  const Array<Manifold<float>> back = run<float>(serial::box_box, other, .05f, boxes.pairs.size());
  int same_axis = 0, same_points = 0;
  for (std::size_t k = 0; k < there.size(); ++k) {
    const Manifold<float>&m = there[k], &n = back[k];
    const double size = boxes.size(k), bound = depth_bound * size;
    if (m.count == 0 || n.count == 0) {  // both, or both are as far apart as the margin
      for (int p = 0; p < std::max(m.count, n.count); ++p) {
        ASSERT_NEAR((m.count > 0 ? m : n).point[p].separation, .05f, bound) << k;
      }
      continue;
    }
    const Vector sum = vector_of(m.normal) + vector_of(n.normal);
    float deepest_m = 1e30f, deepest_n = 1e30f;
    for (int p = 0; p < m.count; ++p) deepest_m = std::min(deepest_m, m.point[p].separation);
    for (int p = 0; p < n.count; ++p) deepest_n = std::min(deepest_n, n.point[p].separation);
    if (deepest_m <= 0) {
      ASSERT_NEAR(deepest_m, deepest_n, 2 * bound) << k;
    }
    if (length(sum) > 1e-5) continue;  // two axes as good as one another
    ++same_axis;
    const double near = 1e-4 * size;
    const auto has = [&](const Manifold<float>& manifold, const ContactPoint<float>& point) {
      for (int p = 0; p < manifold.count; ++p)
        if (length(vector_of(manifold.point[p].position) - vector_of(point.position)) < near &&
            std::abs(manifold.point[p].separation - point.separation) < near)
          return true;
      return false;
    };
    bool same = m.count == n.count;
    for (int p = 0; p < m.count; ++p) same = same && has(n, m.point[p]);
    same_points += same;
  }
  EXPECT_GT(same_axis, random_pairs / 4 / 3);
  EXPECT_GT(same_points, same_axis * .95);  // equally deep, or equally far, points are left: which, the order of slots decides
}
}  // namespace
}  // namespace lockstep::rigid
