// The production fluid's level set made a distance again, and the length of its time step.
#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <limits>

#include "common/production_fluid/redistance.h"
#include "common/production_fluid/time_step.h"

namespace lockstep::production_fluid {
namespace {

// phi(p), p in m, at the centres of n cells a side.
template <class Phi>
Field<float> level_set(int nx, int ny, int nz, float h, const Phi& phi) {
  Field<float> field = levelset::make_field<float>(nx, ny, nz, h, 5);
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) field(x, y, z) = static_cast<float>(phi((x + .5) * h, (y + .5) * h, (z + .5) * h));
  return field;
}

Field<float> with(Redistance<float>* redistance, Field<float> phi) {
  Distances<float> distances;
  redistance(phi, band_of_level_set * phi.spacing, distances);
  return phi;
}

Redistance<float>* const all[] = {serial::redistance_sweeping, serial::redistance_marching, openmp::redistance_sweeping,
                                  openmp::redistance_marching};

double sphere(double x, double y, double z) {
  return std::sqrt((x - .48) * (x - .48) + (y - .5) * (y - .5) + (z - .53) * (z - .53)) - .3;
}

TEST(ProductionFluidRedistance, APlaneAlongAnAxisIsExactAndSaturates) {
  const float h = 1 / 16.f;
  for (Redistance<float>* redistance : all) {
    // Five times too steep below, and too flat above.
    const auto phi = with(redistance, level_set(7, 32, 5, h, [](double, double y, double) {
                            const double d = y - .8125;  // at the middle of cells 12 and 13
                            return 5 * d;
                          }));
    for (int y = 0; y < 32; ++y) {
      const double d = (y + .5) * h - .8125, band = 4 * h;
      EXPECT_NEAR(phi(3, y, 2), std::min(std::max(d, -band), band), 1e-6) << y;
    }
    EXPECT_EQ(phi.value[phi.index(0, 0, 0) - 1], 5);  // padding
  }
}

// First order: distances of crossings are too large by less than h at the interface, and the upwind scheme's error is
// of the order of h; measured mean errors of spheres are below .1 h (notes/levelset.md).
TEST(ProductionFluidRedistance, ADistortedSphereBecomesADistance) {
  for (const int n : {32, 64}) {
    const float h = 1.f / n;
    for (Redistance<float>* redistance : all) {
      const auto phi = with(redistance, level_set(n, n, n, h, [](double x, double y, double z) {
                              return sphere(x, y, z) * (1.2 + std::sin(9 * x) * std::cos(7 * y));
                            }));
      double sum = 0, near = 0;
      for (int z = 0; z < n; ++z)
        for (int y = 0; y < n; ++y)
          for (int x = 0; x < n; ++x) {
            const double exact = sphere((x + .5) * h, (y + .5) * h, (z + .5) * h);
            ASSERT_EQ(phi(x, y, z) < 0, exact < 0);
            ASSERT_LE(std::abs(phi(x, y, z)), 4 * h);
            if (std::abs(exact) > 3 * h) continue;
            ASSERT_NEAR(phi(x, y, z), exact, h);
            sum += std::abs(phi(x, y, z) - exact), near += 1;
          }
      EXPECT_LT(sum / near, .1 * h);
    }
  }
}

TEST(ProductionFluidRedistance, ZeroIsAirAndNoSurfaceIsTheBand) {
  for (Redistance<float>* redistance : all) {
    const auto on_cells = with(redistance, level_set(1, 9, 1, 1, [](double, double y, double) { return y - 4.5; }));
    for (int y = 0; y < 9; ++y) EXPECT_EQ(on_cells(0, y, 0), y - 4) << y;
    EXPECT_FALSE(std::signbit(on_cells(0, 4, 0)));
    const auto full = with(redistance, level_set(3, 2, 4, 1, [](double, double, double) { return -.01; }));
    EXPECT_EQ(full(1, 1, 1), -4);
    const auto empty = with(redistance, level_set(3, 2, 4, 1, [](double, double, double) { return .01; }));
    EXPECT_EQ(empty(1, 1, 1), 4);
  }
}

TEST(ProductionFluidRedistance, HasTheSerialBits) {
  const int before = omp_get_max_threads();
  for (const int n : {1, 15, 16, 17, 40}) {
    const auto phi = level_set(n, 24, 21, 1 / 24.f, [](double x, double y, double z) {
      return sphere(x, y, z) * (1.2 + std::sin(30 * x * y));
    });
    const auto sweeping = with(serial::redistance_sweeping, phi), marching = with(serial::redistance_marching, phi);
    for (const int threads : {1, 2, 3, 8}) {
      omp_set_num_threads(threads);
      EXPECT_EQ(with(openmp::redistance_sweeping, phi).value, sweeping.value) << n << ", " << threads;
      EXPECT_EQ(with(openmp::redistance_marching, phi).value, marching.value) << n << ", " << threads;
    }
  }
  omp_set_num_threads(before);
}

// --- The time step

TimeStep<float>* const both[] = {serial::time_step, openmp::time_step};

// Faces at rest; padding is faster than anything.
Faces<float> at_rest(int nx, int ny, int nz, float h) {
  Faces<float> faces = make_faces<float>(nx, ny, nz, h);
  for (Field<float>* field : {&faces.u, &faces.v, &faces.w}) {
    std::fill(field->value.begin(), field->value.end(), 1e9f);
    for (int z = 0; z < field->nz; ++z)
      for (int y = 0; y < field->ny; ++y) std::fill_n(&(*field)(0, y, z), field->nx, 0.f);
  }
  return faces;
}

TEST(ProductionFluidTimeStep, AtRestIsAFallOfHalfACell) {
  for (TimeStep<float>* time_step : both) {
    // sqrt(.25 * 16) = 2 m/s
    EXPECT_EQ(time_step(at_rest(5, 4, 3, .25f), 16, .5f), .5f * .25f / 2);
    EXPECT_EQ(time_step(at_rest(5, 4, 3, .25f), 0, .5f), std::numeric_limits<float>::infinity());
  }
}

TEST(ProductionFluidTimeStep, EveryFaceCounts) {
  for (const int nx : {1, 15, 16, 17, 33}) {
    const auto expect_found = [&](Field<float> Faces<float>::*component) {
      Faces<float> faces = at_rest(nx, 3, 2, 1);
      Field<float>& field = faces.*component;
      for (int z = 0; z < field.nz; ++z)
        for (int y = 0; y < field.ny; ++y)
          for (int x = 0; x < field.nx; ++x) {
            field(x, y, z) = -4;
            for (TimeStep<float>* time_step : both)
              ASSERT_EQ(time_step(faces, 0, 1), .25f) << x << ' ' << y << ' ' << z;
            field(x, y, z) = 0;
          }
    };
    expect_found(&Faces<float>::u), expect_found(&Faces<float>::v), expect_found(&Faces<float>::w);
  }
}

TEST(ProductionFluidTimeStep, AddsTheAxesOfACell) {
  Faces<float> faces = at_rest(20, 3, 3, 1);
  faces.u(18, 1, 1) = 1, faces.u(19, 1, 1) = -3, faces.v(18, 1, 1) = 2, faces.w(18, 1, 2) = -5;  // of cell 18: 10
  faces.w(2, 2, 2) = 9;
  for (TimeStep<float>* time_step : both) EXPECT_EQ(time_step(faces, 0, 1), .1f);
}

}  // namespace
}  // namespace lockstep::production_fluid
