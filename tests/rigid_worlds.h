// What tests of hulls, bodies, generators and scenes share.
#pragma once

#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/rigid/make.h"
#include "tests/exact_convex.h"

namespace lockstep::rigid::worlds {

using Vector = Vector3<double>;
inline constexpr double u = std::numeric_limits<double>::epsilon() / 2;  // a rounding

inline void expect_near(const Vector& a, const Vector& b, double tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

inline std::string invalid(auto action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

inline Vector vertex_of(const Hulls<double>& hulls, int hull, int corner) {
  const Quad<double>& v = hulls.vertex[hulls.first_vertex[hull] + corner];
  return {v.x, v.y, v.z};
}

inline std::vector<std::vector<int>> faces_of(const Hulls<double>& hulls, int hull) {
  std::vector<std::vector<int>> faces;
  for (int f = hulls.first_face[hull]; f < hulls.first_face[hull + 1]; ++f)
    faces.emplace_back(hulls.corner.begin() + hulls.first_corner[f], hulls.corner.begin() + hulls.first_corner[f + 1]);
  return faces;
}

}  // namespace lockstep::rigid::worlds
