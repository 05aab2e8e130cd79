// The system of the pressure: its rows against the formulas by hand, pockets, runs, and both versions.
#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>

#include "common/production_fluid/make_system.h"
#include "tests/production_fluids.h"
#include "verify/arrays.h"

namespace lockstep::production_fluid {
namespace {

System<float> system_of(const Fluid<float>& fluid) {
  System<float> system;
  serial::make_system(fluid, system);
  return system;
}

double sum_of_right(const System<float>& system) {
  double sum = 0;
  for (const float b : system.right) sum += b;
  return sum;
}

// A helper that returns its clamp in place of clamping makes velocities explode where phi is nearly 0.
TEST(ProductionFluidSystem, ClampsTheSurfaceToLeastTheta) {
  const auto expect = [](float phi, float phi_of_air, double theta) {
    EXPECT_FLOAT_EQ(theta_between(phi, phi_of_air), static_cast<float>(theta)) << phi << ' ' << phi_of_air;
  };
  expect(-1, 0, 1);
  expect(-1, 1, .5);
  expect(-1e-3f, 1, .001 / 1.001 < least_theta ? least_theta : .001 / 1.001);
  expect(-2e-3f, 1, .002 / 1.002);
  expect(-1e-9f, 1, least_theta);
  expect(-1e-38f, 1, least_theta);
  expect(-1e-38f, 0, 1);
  EXPECT_LE(least_theta, 1e-3);
}

TEST(ProductionFluidSystem, OfOneCellCountsItsAir) {
  Fluid<float> fluid = make_air(3, 3, 3);
  fluid.phi(1, 1, 1) = -1;
  fluid.phi(0, 1, 1) = 1;     // theta 1/2
  fluid.phi(2, 1, 1) = 3;     // 1/4
  fluid.phi(1, 0, 1) = 0;     // 1
  fluid.phi(1, 2, 1) = 1e9f;  // clamped
  fluid.solid(1, 1, 0) = -1;  // closed
  fluid.phi(1, 1, 2) = 1;     // 1/2
  fluid.velocity.u(1, 1, 1) = 1, fluid.velocity.u(2, 1, 1) = 2, fluid.velocity.v(1, 1, 1) = 4;
  fluid.velocity.v(1, 2, 1) = 8, fluid.velocity.w(1, 1, 1) = 16, fluid.velocity.w(1, 1, 2) = 32;
  const System<float> system = system_of(fluid);
  const std::size_t at = system.cells.index(1, 1, 1);
  EXPECT_FLOAT_EQ(system.diagonal[at], 2 + 4 + 1 + 1000 + 2);
  EXPECT_EQ(system.right[at], 1 - 2 + 4 - 8 - 32);  // the closed face carries nothing
  ASSERT_EQ(system.runs.size(), 1u);
  EXPECT_EQ(system.runs[0].begin, 1);
  EXPECT_EQ(system.runs[0].end, 2);
  Array<float> only(system.diagonal.size());
  only[at] = system.diagonal[at];
  EXPECT_EQ(system.diagonal, only);
}

TEST(ProductionFluidSystem, CountsLiquidNeighboursAndNoWalls) {
  Fluid<float> fluid = make_air(3, 2, 2);
  for_each_cell(fluid.phi, [](float& phi) { phi = -1; });
  for (const bool open : {false, true}) {
    fluid.open_top = open;
    const System<float> system = system_of(fluid);
    EXPECT_EQ(system.diagonal[system.cells.index(0, 0, 0)], 3);
    EXPECT_EQ(system.diagonal[system.cells.index(1, 0, 0)], 4);
    EXPECT_EQ(system.diagonal[system.cells.index(1, 1, 0)], open ? 5 : 4);
  }
}

TEST(ProductionFluidSystem, OfACellWithNoOpenFaceHasNoRow) {
  Fluid<float> fluid = make_box(3, 3, 3);
  fluid.phi(1, 1, 1) = -1, fluid.solid(1, 1, 1) = 1;
  EXPECT_TRUE(system_of(fluid).runs.empty());
}

// A pool beside a closed tank: the tank's right-hand sides sum up to zero, the pool's stay as they are.
TEST(ProductionFluidSystem, BalancesPocketsAlone) {
  Fluid<float> fluid = make_random(19, 9, 7, 1);
  fluid.open_top = false;
  for (int z = 0; z < 7; ++z)
    for (int y = 0; y < 9; ++y)
      for (int x = 0; x < 19; ++x) {
        fluid.solid(x, y, z) = x == 9 ? -1 : 1;
        fluid.phi(x, y, z) = x > 9 && y > 4 ? 1 : -1;
      }
  System<float> system = system_of(fluid);
  double tank = 0, pool = 0, expected = 0;
  for (int z = 0; z < 7; ++z)
    for (int y = 0; y < 9; ++y)
      for (int x = 0; x < 19; ++x) {
        const double right = system.right[system.cells.index(x, y, z)];
        if (x < 9) tank += right;
        if (x <= 9 || y > 4) continue;
        pool += right;
        const auto& [u, v, w] = fluid.velocity;
        expected += (x > 10 ? u(x, y, z) : 0) - (x < 18 ? u(x + 1, y, z) : 0) + (y > 0 ? v(x, y, z) : 0) -
                    v(x, y + 1, z) + (z > 0 ? w(x, y, z) : 0) - (z < 6 ? w(x, y, z + 1) : 0);
      }
  EXPECT_NEAR(tank, 0, 9 * 9 * 7 * 1e-7);
  EXPECT_NEAR(pool, expected, 1e-4);
  EXPECT_GT(std::abs(pool), .1);
}

TEST(ProductionFluidSystem, FindsPocketsAroundCorners) {
  // A tunnel that turns: liquid cells connected along z and y alone, closed in; and the same with one air cell beside.
  for (const bool air : {false, true}) {
    Fluid<float> fluid = make_box(4, 5, 5);
    const auto liquid = [&](int x, int y, int z) { fluid.phi(x, y, z) = -1, fluid.solid(x, y, z) = 1; };
    for (int z = 0; z < 5; ++z) liquid(1, 0, z);
    for (int y = 0; y < 5; ++y) liquid(1, y, 4);
    for (int z = 2; z < 5; ++z) liquid(1, 4, z);
    if (air) fluid.solid(1, 4, 1) = 1;
    fluid.velocity.w(1, 0, 2) = 1, fluid.velocity.v(1, 2, 4) = 3, fluid.velocity.w(1, 4, 3) = 1;
    if (air) fluid.velocity.w(1, 4, 2) = 7;
    EXPECT_NEAR(sum_of_right(system_of(fluid)), air ? 7 : 0, 1e-6);
  }
}

TEST(ProductionFluidSystem, IsSymmetricAndSumsUpToTheAir) {
  const System<float> system = system_of(make_random(21, 13, 11, 3));
  const auto [rows, place] = matrix_of(system);
  ASSERT_GT(rows.rows, 500);
  for (int i = 0; i < rows.rows; ++i) {
    double sum = 0;
    for (int k = rows.begin[i]; k < rows.begin[i + 1]; ++k) sum += rows.value[k];
    EXPECT_GE(sum, -1e-4);  // the coefficients of its air
  }
}

TEST(ProductionFluidSystem, SaysWhereAirIs) {
  for (int seed = 0; seed < 4; ++seed) {
    const Fluid<float> fluid = make_random(5, 4, 3, seed);
    const System<float> system = system_of(fluid);
    EXPECT_EQ(system.open_top, fluid.open_top);
    Array<std::uint8_t> expected(system.cells.size());
    for_each_place(fluid.phi, [&](int x, int y, int z) {
      expected[system.cells.index(x, y, z)] = cell_at(fluid, x, y, z) == Kind::air;
    });
    EXPECT_EQ(system.air, expected);
  }
}

TEST(ProductionFluidSystem, OpenmpHasTheSerialBits) {
  const int before = omp_get_max_threads();
  int seed = 0;
  for (const int nx : {1, 2, 15, 16, 17, 31, 32, 33, 50})
    for (const auto& [ny, nz] : {std::pair(1, 1), {1, 5}, {4, 1}, {7, 6}}) {
      const Fluid<float> fluid = make_random(nx, ny, nz, ++seed);
      const System<float> serial = system_of(fluid);
      for (const int threads : {1, 2, 3, 8}) {
        omp_set_num_threads(threads);
        System<float> openmp = system_of(make_random(5, 4, 3, 9));  // of another size, which must leave no trace
        openmp::make_system(fluid, openmp);
        EXPECT_EQ(verify::hash_of(openmp), verify::hash_of(serial)) << nx << 'x' << ny << 'x' << nz;
        EXPECT_EQ(openmp.open_top, serial.open_top);
      }
    }
  omp_set_num_threads(before);
}

}  // namespace
}  // namespace lockstep::production_fluid
