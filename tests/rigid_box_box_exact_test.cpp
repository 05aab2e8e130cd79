// Box against box: an independent test for overlap (libccd) and the exact oracle (exact_convex.h), over random pairs of
// many kinds.
#include <ccd/ccd.h>
#include <ccd/quat.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/rigid_box_pairs.h"

namespace lockstep::rigid::box_pairs {
namespace {

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

// The distance of a point outside of a box, m; inside it is negative, the depth below the nearest face.
double outside(const ExactShape& box, const Vector& point) {
  double most = -1e30;
  for (std::size_t f = 0; f < box.face.size(); ++f)
    most = std::max(most, dot(box.normal[f], point - box.vertex[box.face[f][0]]));
  return most;
}

TEST(BoxBox, AnswersAsLibccdDoes) {
  const Boxes<float> boxes = random_boxes(random_pairs, 1);
  const Array<Manifold<float>> manifolds = run<float>(serial::box_box, boxes, 0, boxes.pairs.size());
  int left_out = 0, overlapping = 0;
  for (std::size_t k = 0; k < boxes.pairs.size(); ++k) {
    const ExactShape a = boxes.exact(2 * k), b = boxes.exact(2 * k + 1);
    const double bound = std::max(answer_bound * boxes.size(k), 1e-7);  // libccd is good to 1e-7
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

// Properties of every manifold.
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
      // Half the separation either way along the normal leads to a point of either surface. This is exact to within
      // face_widening in x and in y, which a step along a face of the other box, no steeper than sqrt(2), turns into
      // height, and to within the world's rounding.
      const double bound = (depth_bound + 2.5 * face_widening) * size + 4 * u * (away + 3 * size);
      const Vector middle = vector_of(position), half = .5 * separation * normal;
      ASSERT_NEAR(outside(a, middle - half), 0, bound) << k << ' ' << exact.separation << ' ' << m.count << ' ' << p;
      ASSERT_NEAR(outside(b, middle + half), 0, bound) << k << ' ' << exact.separation << ' ' << m.count << ' ' << p;
    }
    if (exact.separation <= 0) {
      worst = std::max(worst, std::abs(deepest - exact.separation) / size);
      ASSERT_NEAR(deepest, exact.separation, depth_bound * size) << k;
      ASSERT_NEAR(separation_along(a, b, normal), exact.separation, depth_bound * size) << k;
    } else {  // opposite points may be farther apart than the axis says, never nearer
      ASSERT_GE(deepest, least - apart_bound * size) << k;
      ASSERT_GE(separation_along(a, b, normal), least - apart_bound * size) << k;
    }
  }
  testing::Test::RecordProperty("worst_depth_error", std::to_string(worst));
}

TEST(BoxBox, DepthAndPointsAreExact) { check_manifolds(random_boxes(random_pairs / 2, 2), 0); }
TEST(BoxBox, BoxesWithinTheMarginHavePoints) { check_manifolds(random_boxes(random_pairs / 4, 3), .05f); }

// In double, only preferences are left of the bound.
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

}  // namespace
}  // namespace lockstep::rigid::box_pairs
