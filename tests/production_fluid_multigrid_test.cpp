// Multigrid for the pressure: its grids and transfers by hand, the cycle as a matrix, iterations, and both versions.
#include <gtest/gtest.h>
#include <omp.h>

// As wherever Eigen is included: its functions are one for all files, and with vectors they allocate in another way.
#ifndef EIGEN_DONT_VECTORIZE
#define EIGEN_DONT_VECTORIZE
#endif
#include <cmath>
#include <eigen3/Eigen/Dense>
#include <random>

#include "common/convert.h"
#include "common/production_fluid/make_system.h"
#include "common/production_fluid/multigrid.h"
#include "common/production_fluid/scene.h"
#include "tests/production_fluids.h"

namespace lockstep::production_fluid {
namespace {

constexpr PressureSettings settings = {.modification = {}, .stop = {.tolerance = 1e-6, .iterations = 1000}};

System<float> system_of(const Fluid<float>& fluid) {
  System<float> system;
  serial::make_system(fluid, system);
  return system;
}

// A closed tank with water up to a share of its height.
Fluid<float> make_tank(int nx, int ny, int nz, double share = .75) {
  Fluid<float> fluid = make_fluid<float>(nx, ny, nz, 1, [&](double, double y, double) { return y - share * ny - .1; });
  std::mt19937 random(nx);
  for (Field<float>* faces : {&fluid.velocity.u, &fluid.velocity.v, &fluid.velocity.w})
    for_each_cell(*faces, [&](float& v) { v = static_cast<float>(static_cast<int>(random() % 2001) - 1000) / 1000; });
  return fluid;
}

// --- Grids and transfers

TEST(ProductionFluidMultigrid, AParentIsAirThenLiquidThenSolid) {
  for (int greatest = Kinds::solid; greatest <= Kinds::air; ++greatest)
    for (int child = 0; child < 8; ++child) {
      Kinds kinds = make_kinds({2, 2, 2}, false);
      for (int c = 0; c < 8; ++c)
        kinds.value[kinds.index(c % 2, c / 2 % 2, c / 4)] = static_cast<std::uint8_t>(c == child ? greatest
                                                                                      : c % 2    ? Kinds::solid
                                                                                                 : greatest);
      EXPECT_EQ(kind_of_parent(&kinds.value[kinds.index(0, 0, 0)], kinds.line(), kinds.plane()), greatest);
    }
  // The children beyond a wall do not count, those above an open top do.
  for (const bool open : {false, true}) {
    Kinds kinds = make_kinds({1, 1, 1}, open);
    kinds.value[kinds.index(0, 0, 0)] = Kinds::liquid;
    EXPECT_EQ(kind_of_parent(&kinds.value[kinds.index(0, 0, 0)], kinds.line(), kinds.plane()),
              open ? Kinds::air : Kinds::liquid);
  }
}

TEST(ProductionFluidMultigrid, ARowCountsLiquidAndAir) {
  Kinds kinds = make_kinds({3, 3, 3}, false);
  const std::size_t here = kinds.index(1, 1, 1);
  const std::ptrdiff_t beside[] = {-1, 1, -kinds.line(), kinds.line(), -kinds.plane(), kinds.plane()};
  for (int k = 0; k < 4096; ++k) {  // all kinds of the six neighbours
    int open = 0, boundaries = 0;
    for (int n = 0; n < 6; ++n) {
      const int kind = k >> 2 * n & 3;
      kinds.value[here + beside[n]] = static_cast<std::uint8_t>(kind);
      open += kind == Kinds::liquid || kind == Kinds::air;
      boundaries += kind == Kinds::solid || kind == Kinds::air;
    }
    for (const std::uint8_t kind : {Kinds::wall, Kinds::solid, Kinds::liquid, Kinds::air}) {
      kinds.value[here] = kind;
      EXPECT_EQ(row_of(&kinds.value[here], kinds.line(), kinds.plane()), kind == Kinds::liquid ? open : 0);
      EXPECT_EQ(is_beside_boundary(&kinds.value[here], kinds.line(), kinds.plane()),
                kind == Kinds::liquid && boundaries > 0);
    }
  }
}

// Along an axis, the weights of R are those of P, transposed; P carries a constant over, up to the walls.
TEST(ProductionFluidMultigrid, RestrictionIsTheTransposeOfInterpolation) {
  for (int n = 1; n <= 50; ++n) {
    const int coarse = (n + 1) / 2;
    Eigen::MatrixXf p(n, coarse), r(coarse, n);
    for (int x = 0; x < n; ++x)
      for (int c = 0; c < coarse; ++c) {
        p(x, c) = interpolated(x / 2 == c ? 1.f : 0.f, next_place(x, coarse) == c ? 1.f : 0.f);
        const auto at = [&](int k) { return fine_place(2 * c - 1 + k, n) == x ? 1.f : 0.f; };
        r(c, x) = restricted(at(0), at(1), at(2), at(3));
      }
    EXPECT_EQ(r, p.transpose()) << n;
    EXPECT_EQ(p.rowwise().sum(), Eigen::VectorXf::Constant(n, 4)) << n;
  }
}

// Lanes load the neighbours of whole vectors, in which the first cell or the last may be one of sixteen. What stood
// before the array, if it was a NaN, got into the pressure of narrow boxes.
TEST(ProductionFluidMultigrid, NeighboursOfWholeVectorsAreInTheArray) {
  for (int nx = 1; nx <= 40; ++nx)
    for (const auto& [ny, nz] : {std::pair(1, 1), {1, 7}, {7, 1}, {3, 5}}) {
      const Bordered cells = {nx, ny, nz};
      const auto vector_of = [&](int x, int y, int z) { return static_cast<int>(cells.index(x, y, z)) / 16 * 16; };
      EXPECT_GE(vector_of(0, 0, 0) - cells.plane(), 0) << nx << 'x' << ny << 'x' << nz;
      EXPECT_LE(vector_of(nx - 1, ny - 1, nz - 1) + cells.plane() + 16, cells.size()) << nx << 'x' << ny << 'x' << nz;
    }
}

// --- The cycle

TEST(ProductionFluidMultigrid, OfOneCellIsExact) {
  Fluid<float> fluid = make_air(1, 1, 1);
  fluid.open_top = true;
  fluid.phi(0, 0, 0) = -.25f, fluid.velocity.v(0, 1, 0) = 3;
  const System<float> system = system_of(fluid);
  Array<float> z(system.cells.size());
  for (const auto& cycle : {serial::multigrid_cycle, openmp::multigrid_cycle}) {
    cycle(system, system.right, z);
    const std::size_t i = system.cells.index(0, 0, 0);
    EXPECT_EQ(z[i], 1 / system.diagonal[i] * system.right[i]);
  }
}

// In exact arithmetic the cycle is a symmetric matrix M. Its outermost step alone, Jacobi's before and after, makes
//
//   M >= w (2 D^-1 - w D^-1 A D^-1) >= 2 w (1 - w) D^-1,   w = damping, since A <= 2 D (rows are diagonally dominant).
//
// A cycle of three grids has fewer than 100 sweeps one after another. None enlarges an entry, and each rounds an entry
// by at most 10 u of the largest.
TEST(ProductionFluidMultigrid, IsSymmetricAndPositiveDefinite) {
  int seed = 0;
  for (const auto& [nx, ny, nz] : {std::tuple(1, 1, 1), {4, 4, 4}, {5, 7, 6}, {11, 1, 9}, {9, 9, 5}, {1, 16, 1}})
    for (const bool is_random : {false, true}) {
      const System<float> given = system_of(is_random ? make_random(nx, ny, nz, ++seed) : make_tank(nx, ny, nz));
      const System<double> system = {given.cells,
                                     convert<double>(given.diagonal),
                                     convert<double>(given.right),
                                     given.first_run,
                                     given.runs,
                                     given.air,
                                     given.open_top};
      const std::vector<std::size_t> place = matrix_of(given).place;
      const int n = static_cast<int>(place.size());
      if (n == 0) continue;
      Eigen::MatrixXd m(n, n);
      Array<double> r(system.cells.size()), z(system.cells.size());
      double most = 0;
      for (int j = 0; j < n; ++j) {
        r[place[j]] = 1;
        serial::multigrid_cycle(system, r, z);
        for (int i = 0; i < n; ++i) m(i, j) = z[place[i]];
        r[place[j]] = 0;
        most = std::max(most, system.diagonal[place[j]]);
      }
      const double largest = m.cwiseAbs().maxCoeff(), rounding = 100 * 10 * 0x1p-53 * largest;
      EXPECT_LE((m - m.transpose()).cwiseAbs().maxCoeff(), 2 * rounding) << nx << 'x' << ny << 'x' << nz;
      const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver((m + m.transpose()) / 2);
      const double w = jacobi_damping;
      EXPECT_GE(solver.eigenvalues()[0], 2 * w * (1 - w) / most - n * rounding) << nx << 'x' << ny << 'x' << nz;
    }
}

// --- Iterations

// No more than prototypes in double whose band had the cells beside walls, too: 12 and 16.
TEST(ProductionFluidMultigrid, TakesFewIterations) {
  for (const auto& [scene, iterations] : {std::pair("drop_64", 12), {"drop_128", 16}}) {
    System<float> system;
    openmp::make_system(load_scene("scenes/production_fluid/" + std::string(scene) + ".toml").fluid, system);
    Array<double> q;
    const linear::Solution s = openmp::pressure_solve_multigrid(system, settings, scratch_for(system), q);
    std::printf("  %s: %d iterations, |r|/|b| %.2e, true %.2e\n", scene, s.iterations, s.recursive_residual,
                s.true_residual);
    EXPECT_LE(s.iterations, iterations) << scene;
    EXPECT_LE(s.true_residual, 1e-6) << scene;
  }
}

// Boxes whose grids have half cells at their walls, and lines; with a surface, and full.
TEST(ProductionFluidMultigrid, SolvesBoxesOfAllSizes) {
  int most = 0;
  for (int n = 1; n <= 50; ++n)
    for (const auto& [nx, ny, nz] : {std::tuple(n, 20, 9), {7, n, n}, {1, n, 1}, {n, 2, 1}})
      for (const double share : {.75, 1.}) {
        const System<float> system = system_of(make_tank(nx, ny, nz, share));
        Array<double> q;
        const linear::Solution s = openmp::pressure_solve_multigrid(system, settings, scratch_for(system), q);
        EXPECT_LE(s.true_residual, 1e-6) << nx << 'x' << ny << 'x' << nz << ", " << share;
        if (s.iterations > most) std::printf("  %dx%dx%d, %g: %d iterations\n", nx, ny, nz, share, s.iterations);
        most = std::max(most, s.iterations);
      }
  EXPECT_LE(most, 16);  // as many as drop_128 may take
}

// Sheets of one cell that coarse grids do not see: parting the water but for a hole, and a comb of them.
TEST(ProductionFluidMultigrid, SolvesThinSolids) {
  for (const int sheets : {1, 5}) {
    Fluid<float> fluid = make_tank(41, 32, 24);
    for (int k = 0; k < sheets; ++k)
      for (int z = 0; z < 24; ++z)
        for (int y = 0; y < 32; ++y)
          if (sheets == 5 ? y > 3 : y != 8 || z != 9) fluid.solid(7 + 6 * k, y, z) = -1;
    const System<float> system = system_of(fluid);
    Array<double> q;
    const linear::Solution s = openmp::pressure_solve_multigrid(system, settings, scratch_for(system), q);
    const int of_mic =
        serial::pressure_solve_mic(system, {.modification = {.tau = .97, .sigma = .25}, .stop = settings.stop},
                                   scratch_for(system), q)
            .iterations;
    std::printf("  %d sheets: %d iterations, mic %d\n", sheets, s.iterations, of_mic);
    EXPECT_LE(s.true_residual, 1e-6);
    EXPECT_LE(s.iterations, of_mic);
  }
}

// --- Both versions

TEST(ProductionFluidMultigrid, OpenmpHasTheSerialBits) {
  const int before = omp_get_max_threads();
  int seed = 0, most = 0;
  for (const int nx : {1, 2, 3, 15, 16, 17, 31, 32, 33, 50})
    for (const auto& [ny, nz] : {std::pair(1, 1), {1, 5}, {16, 3}, {17, 2}, {40, 27}}) {
      const System<float> system = system_of(make_random(nx, ny, nz, ++seed));
      Array<double> q, found;
      Array<float> z(system.cells.size()), z_found = z;
      const linear::Solution s = serial::pressure_solve_multigrid(system, settings, scratch_for(system), q);
      serial::multigrid_cycle(system, system.right, z);
      EXPECT_LE(s.true_residual, 1e-6);
      most = std::max(most, s.iterations);
      for (const int threads : {1, 2, 3, 8}) {
        omp_set_num_threads(threads);
        const linear::Solution t = openmp::pressure_solve_multigrid(system, settings, scratch_for(system), found);
        openmp::multigrid_cycle(system, system.right, z_found);
        EXPECT_EQ(s.iterations, t.iterations);
        EXPECT_EQ(s.true_residual, t.true_residual);
        EXPECT_EQ(q, found) << nx << 'x' << ny << 'x' << nz << ", " << threads << " threads";
        EXPECT_EQ(z, z_found) << nx << 'x' << ny << 'x' << nz << ", " << threads << " threads";
      }
    }
  std::printf("  at most %d iterations\n", most);
  omp_set_num_threads(before);
}

}  // namespace
}  // namespace lockstep::production_fluid
