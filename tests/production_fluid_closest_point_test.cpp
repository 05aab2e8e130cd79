// The closest points from which smooth surfaces get their distances, and the rule that leaves kinks to sweeping.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "common/production_fluid/closest_point.h"
#include "common/production_fluid/redistance.h"

namespace lockstep::production_fluid {
namespace {

constexpr double u = std::numeric_limits<float>::epsilon() / 2;

// phi(p), p in cells from the first centre, times h.
template <class Phi>
Field<float> level_set(int nx, int ny, int nz, float h, const Phi& phi) {
  Field<float> field = levelset::make_field<float>(nx, ny, nz, h, std::numeric_limits<float>::quiet_NaN());
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) field(x, y, z) = static_cast<float>(h * phi(double(x), double(y), double(z)));
  return field;
}

template <class F>
void for_each_cell(const Field<float>& phi, const F& f) {
  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y)
      for (int x = 0; x < phi.nx; ++x) f(x, y, z);
}

ClosestPoint<float> closest(const Field<float>& phi, int x, int y, int z) {
  return closest_point<std::int32_t>(phi, x, y, z, [&](std::int32_t index) { return (&phi(0, 0, 0))[index]; });
}

Redistance<float>* const all[] = {serial::redistance_sweeping, serial::redistance_marching, openmp::redistance_sweeping,
                                  openmp::redistance_marching};

Field<float> with(Redistance<float>* redistance, Field<float> phi) {
  Distances<float> distances;
  redistance(phi, band_of_level_set * phi.spacing, distances);
  return phi;
}

double volume(const Field<float>& phi) {
  double cells = 0;
  for_each_cell(phi, [&](int x, int y, int z) { cells += liquid_share(phi(x, y, z), phi.spacing); });
  return cells;
}

// A cubic through a plane's values is the plane. Its values are at most 3 + 2 sqrt(3) cells and round by u, and so do
// the three levels of three sums of an interpolation, twice: below 100 u of a cell. The slope takes nothing from it,
// since it counts by its square.
TEST(ProductionFluidClosestPoint, APlaneIsExact) {
  const float h = .125f;
  for (const Vector3<double>& n : {Vector3<double>{1 / 3., 2 / 3., 2 / 3.}, {0, .6, -.8}, {1, 0, 0}, {-.6, .8, 0}}) {
    const auto plane = [&](double x, double y, double z) { return dot(n, {x - 11.3, y - 11.8, z - 12.1}); };
    const Field<float> phi = level_set(24, 24, 24, h, plane);
    int cells = 0;
    for (int z = 6; z < 18; ++z)
      for (int y = 6; y < 18; ++y)
        for (int x = 6; x < 18; ++x) {
          const double exact = plane(x, y, z);
          if (std::abs(exact) >= 3) continue;
          ++cells;
          const auto [distance, is_smooth] = closest(phi, x, y, z);
          EXPECT_TRUE(is_smooth);
          EXPECT_NEAR(distance, h * std::abs(exact), 100 * u * h);
        }
    EXPECT_GT(cells, 500);
  }
}

// By sweeping, distances beside a ball are of first order. The contract says second; a cubic is off by fourth.
TEST(ProductionFluidClosestPoint, DistancesFromABallAreOfSecondOrderOrBetter) {
  for (Redistance<float>* redistance : all) {
    double before = 0;
    for (const int n : {24, 48, 96}) {
      const double radius = .3 * n, middle = .49 * n;
      const auto ball = [&](double x, double y, double z) {
        return std::hypot(x - middle, y - middle - .2, z - middle + .3) - radius;
      };
      const auto phi = with(redistance, level_set(n, n, n, 1.f / n, [&](double x, double y, double z) {
                              const double s = 6. / n;
                              return ball(x, y, z) * (1 + .1 * std::sin(s * x) * std::cos(s * y + 2 * s * z));
                            }));
      double worst = 0;
      for_each_cell(phi, [&](int x, int y, int z) {
        const double exact = ball(x, y, z) / n;
        if (std::abs(exact) < 2. / n) worst = std::max(worst, std::abs(phi(x, y, z) - exact));
      });
      if (before > 0) {
        EXPECT_GT(std::log2(before / worst), 2) << n;
      }
      before = worst;
    }
  }
}

// Where a sheet's middle is .7 of a cell from the surface, phi bends there by .6 or more, wherever centres are: at a
// centre d from a kink the second difference is 2 (1 - d). Six cells from the middle nothing bends.
TEST(ProductionFluidClosestPoint, AKinkIsNotSmooth) {
  for (const int axis : {0, 1, 2})
    for (const double thickness : {.6, 1., 1.4, 12.})
      for (double shift = 0; shift < 1; shift += .125) {
        const auto exact = [&](double at) { return std::abs(at - 15 - shift) - thickness / 2; };
        int size[3] = {8, 8, 8}, cell[3] = {4, 4, 4};
        size[axis] = 32;
        const Field<float> phi = level_set(size[0], size[1], size[2], .25f, [&](double x, double y, double z) {
          return exact(axis == 0 ? x : axis == 1 ? y : z);
        });
        for (int& at = cell[axis] = 6; at < 26; ++at) {
          if (std::abs(exact(at)) >= 3) continue;
          const auto [distance, is_smooth] = closest(phi, cell[0], cell[1], cell[2]);
          EXPECT_EQ(is_smooth, thickness > 2) << axis << ' ' << thickness << ' ' << shift << ' ' << at;
          if (is_smooth) {
            EXPECT_NEAR(distance, .25 * std::abs(exact(at)), 100 * u * .25);
          }
        }
      }
}

// At most half a cell from the distance that the cell had, which the band limits; all values are exact in float.
TEST(ProductionFluidClosestPoint, MovesADistanceByHalfACellAtMost) {
  const float band = 2, spacing = .5f;
  const auto moved = [&](float closest, bool is_smooth, float distance) {
    return closest_distance(ClosestPoint<float>{closest, is_smooth}, distance, band, spacing);
  };
  EXPECT_EQ(moved(.875f, true, .75f), .875f);
  EXPECT_EQ(moved(1.5f, true, .75f), 1);
  EXPECT_EQ(moved(.25f, true, .75f), .5f);
  EXPECT_EQ(moved(.875f, false, .75f), .75f);
  EXPECT_EQ(moved(1, true, 3), 1.75f);
  EXPECT_EQ(moved(1, false, 3), 2);
}

// Twenty redistancings of an oblique sheet of 1.2 cells, at rest. Without the rule it grows.
TEST(ProductionFluidClosestPoint, AThinSheetDoesNotGrow) {
  const auto sheet = [](double x, double y, double z) {
    return std::clamp(std::abs((x - 16.2) / 3 + (y - 15.6) * 2 / 3 + (z - 15.9) * 2 / 3) - .6, -4., 4.);
  };
  for (Redistance<float>* redistance : all) {
    Field<float> phi = level_set(32, 32, 32, 1, sheet);
    const double start = volume(phi);
    for (int k = 0; k < 20; ++k) phi = with(redistance, phi);
    EXPECT_NEAR(volume(phi), start, .05 * start);
  }
}

// A cubic is off by at most 3 / 128 of the fourth derivative along an axis, which for the distance from a ball is at
// most 3 / R^3, across the slope; and at most two axes lie so. That is how far the surface may move in each
// redistancing.
TEST(ProductionFluidClosestPoint, ABallAtRestKeepsItsVolume) {
  for (const double radius : {6., 10.})
    for (Redistance<float>* redistance : all) {
      Field<float> phi = level_set(32, 32, 32, 1, [&](double x, double y, double z) {
        return std::clamp(std::hypot(x - 15.2, y - 15.6, z - 16.1) - radius, -4., 4.);
      });
      const double start = volume(phi);
      for (int k = 0; k < 42; ++k) phi = with(redistance, phi);
      const double way = 42 * 2 * 3 / 128. * 3 / std::pow(radius, 3);
      EXPECT_NEAR(volume(phi), start, 3 / radius * way * start);
    }
}

// One cell, two, a line: the box's sides are the nearest values, and padding is NaN here.
TEST(ProductionFluidClosestPoint, SmallBoxesReadNoPadding) {
  for (const Vector3<int>& n : {Vector3<int>{1, 1, 1}, {2, 1, 1}, {1, 2, 3}, {3, 17, 2}, {17, 2, 2}})
    for (Redistance<float>* redistance : all) {
      const Field<float> phi = with(
          redistance, level_set(n.x, n.y, n.z, .5f, [](double x, double y, double z) { return x + .5 * y - z - .25; }));
      for_each_cell(phi, [&](int x, int y, int z) { EXPECT_LE(std::abs(phi(x, y, z)), 2); });
    }
}

}  // namespace
}  // namespace lockstep::production_fluid
