// Advection against facts: what a flow that is known does to a field that is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/production_fluid_advection.h"

namespace lockstep::production_fluid {
namespace {

// Also where there is a single cell along an axis, and at the last points of lines and planes.
TEST(ProductionFluidAdvect, LeavesAllBitsAtRest) {
  for (const auto& [nx, ny, nz] : {Vector3<int>{17, 5, 4}, {1, 1, 1}, {3, 1, 2}, {1, 4, 1}}) {
    const Field<float> phi = level_set<float>(nx, ny, nz, .1f, Numbers{});
    const Faces<float> rest = constant<float>(nx, ny, nz, .1f, {0, 0, 0});
    for (LevelSet* advect : level_sets) {
      const Field<float> after = advected(advect, phi, rest, .5f);
      for_each_point(phi,
                     [&](int x, int y, int z, float v) { EXPECT_EQ(after(x, y, z), v) << x << ' ' << y << ' ' << z; });
    }
    const Faces<float> moving = random_faces(nx, ny, nz, .1f, 1);
    for (Velocity* advect : velocities) {
      const Faces<float> after = advected(advect, moving, 0);
      for_each_component(moving, after, [](const Field<float>& before, const Field<float>& now) {
        for_each_point(before, [&](int x, int y, int z, float v) { EXPECT_EQ(now(x, y, z), v); });
      });
    }
  }
}

// Velocities and dt / h are powers of two, so a foot is a centre. Feet beyond a side take the value at the side.
TEST(ProductionFluidAdvect, ShiftsByWholeCells) {
  constexpr int nx = 21, ny = 7, nz = 6;
  const Field<float> phi = level_set<float>(nx, ny, nz, .5f, Numbers{});
  const Faces<float> faces = constant<float>(nx, ny, nz, .5f, {2, -1, .5});
  for (LevelSet* advect : level_sets) {
    const Field<float> after = advected(advect, phi, faces, 1);
    for_each_point(after, [&](int x, int y, int z, float v) {
      EXPECT_EQ(v, phi(std::max(x - 4, 0), std::min(y + 2, ny - 1), std::max(z - 1, 0))) << x << ' ' << y << ' ' << z;
    });
  }
}

// A constant velocity carries a linear field without error. Two positions of up to n cells round by u n each, and the
// interpolation by 4 u of the largest value a level. A correction adds half of the error of what is carried back, which
// is twice as much, and its sum rounds: less than three times in all.
TEST(ProductionFluidAdvect, CarriesALinearField) {
  constexpr int n = 20;
  constexpr float h = .25f, dt = .3f;
  const auto linear = [](double x, double y, double z) { return 1 + 2 * x - 3 * y + .5 * z; };
  const Field<float> phi = level_set<float>(n, n, n, h, linear);
  const Vector3<double> velocity = {1.1, -.7, .9};
  const Faces<float> faces = constant<float>(n, n, n, h, velocity);
  const double cells = double(dt) / h, bound = 3 * (3 * 4 + 4) * u * (1 + 5.5 * n);
  for (LevelSet* advect : level_sets) {
    const Field<float> after = advected(advect, phi, faces, dt);
    for (int z = 2; z < n - 2; ++z)
      for (int y = 2; y < n - 2; ++y)
        for (int x = 2; x < n - 2; ++x)
          EXPECT_NEAR(after(x, y, z),
                      linear(x + .5 - cells * velocity.x, y + .5 - cells * velocity.y, z + .5 - cells * velocity.z),
                      bound);
  }
}

// u = a x along x alone: u(foot) is a x_foot, and x_foot = x - a dt (x - a dt x / 2). The other components stay zero.
// The same along y and z. Semi-Lagrangian: production_fluid_maccormack_test.cpp has what a correction makes of it.
TEST(ProductionFluidAdvect, CarriesAVelocityThatStretches) {
  constexpr int n = 18;
  constexpr double a = .5, dt = .1;  // per s, s
  const auto zero = [](double, double, double) { return 0.; };
  const double share = 1 - a * dt * (1 - a * dt / 2), bound = 3 * 8 * u * a * n;
  const auto along_x = [](double x, double, double) { return a * x; };
  const auto along_y = [](double, double y, double) { return a * y; };
  const auto along_z = [](double, double, double z) { return a * z; };
  for (Velocity* advect : {serial::advect_velocity_semi_lagrangian, openmp::advect_velocity_semi_lagrangian}) {
    const Faces<float> x = advected(advect, faces_of<float>(n, n, n, 1, along_x, zero, zero), float(dt));
    for_each_point(x.u, [&](int i, int, int, float v) { EXPECT_NEAR(v, a * share * i, bound); });
    for_each_point(x.v, [&](int, int, int, float v) { EXPECT_EQ(v, 0); });
    const Faces<float> y = advected(advect, faces_of<float>(n, n, n, 1, zero, along_y, zero), float(dt));
    for_each_point(y.v, [&](int, int j, int, float v) { EXPECT_NEAR(v, a * share * j, bound); });
    for_each_point(y.w, [&](int, int, int, float v) { EXPECT_EQ(v, 0); });
    const Faces<float> z = advected(advect, faces_of<float>(n, n, n, 1, zero, zero, along_z), float(dt));
    for_each_point(z.w, [&](int, int, int k, float v) { EXPECT_NEAR(v, a * share * k, bound); });
    for_each_point(z.u, [&](int, int, int, float v) { EXPECT_EQ(v, 0); });
  }
}

// A shear moves one component across another: v = s x moves with u = c, so v' = s (x - c dt). It needs the mean of u
// at the faces of v, and so on around the axes.
TEST(ProductionFluidAdvect, CarriesAShear) {
  constexpr int n = 17;
  constexpr double s = .25, c = 3, dt = .4;
  const auto is_c = [](double, double, double) { return c; };
  const auto zero = [](double, double, double) { return 0.; };
  const double bound = 3 * 3 * 8 * u * s * n;  // a correction: CarriesALinearField
  for (Velocity* advect : velocities) {
    const Faces<float> v_of_x = faces_of<float>(
        n, n, n, 1, is_c, [](double x, double, double) { return s * x; }, zero);
    for_each_point(advected(advect, v_of_x, float(dt)).v,
                   [&](int x, int, int, float v) { EXPECT_NEAR(v, s * std::max(x + .5 - c * dt, .5), bound) << x; });
    const Faces<float> w_of_y = faces_of<float>(n, n, n, 1, zero, is_c, [](double, double y, double) { return s * y; });
    for_each_point(advected(advect, w_of_y, float(dt)).w,
                   [&](int, int y, int, float v) { EXPECT_NEAR(v, s * std::max(y + .5 - c * dt, .5), bound) << y; });
    const Faces<float> u_of_z = faces_of<float>(
        n, n, n, 1, [](double, double, double z) { return s * z; }, zero, is_c);
    for_each_point(advected(advect, u_of_z, float(dt)).u,
                   [&](int, int, int z, float v) { EXPECT_NEAR(v, s * std::max(z + .5 - c * dt, .5), bound) << z; });
  }
}

// A rigid rotation is linear, so interpolation has no error, and phi = x and phi = y show where the foot is.
double worst_foot_of_rotation(double angle) {
  constexpr int n = 24;
  const auto zero = [](double, double, double) { return 0.; };
  const Faces<double> faces = faces_of<double>(
      n, n, 3, 1, [](double, double y, double) { return n / 2. - y; },
      [](double x, double, double) { return x - n / 2.; }, zero);
  double worst = 0;
  for (const bool of_y : {false, true}) {
    const Field<double> phi = level_set<double>(n, n, 3, 1, [&](double x, double y, double) { return of_y ? y : x; });
    Field<double> after = phi;
    serial::advect_level_set_semi_lagrangian(phi, faces, angle, after);
    for_each_point(after, [&](int i, int j, int, double foot) {
      const double x = i + .5 - n / 2., y = j + .5 - n / 2.;  // the foot is turned back by the angle
      if (std::hypot(x, y) > n / 2. - 2) return;
      const double exact = of_y ? y * std::cos(angle) - x * std::sin(angle) : x * std::cos(angle) + y * std::sin(angle);
      worst = std::max(worst, std::abs(foot - n / 2. - exact));
    });
  }
  return worst;
}

TEST(ProductionFluidAdvect, FootOfARotationHasThirdOrder) {
  // x - exact = r (angle^3 / 6 + ...): the midpoint rule keeps the terms up to angle^2.
  const double once = worst_foot_of_rotation(.1);
  const double half = worst_foot_of_rotation(.05), quarter = worst_foot_of_rotation(.025);
  EXPECT_NEAR(once / half, 8, .2);
  EXPECT_NEAR(half / quarter, 8, .1);
  EXPECT_NEAR(quarter, 10 * std::pow(.025, 3) / 6, .1 * 10 * std::pow(.025, 3) / 6);
}

// However long the step. Each of three levels rounds by 2 u of the difference of two values and u of the result.
TEST(ProductionFluidAdvect, StaysWithinTheRange) {
  constexpr int nx = 19, ny = 6, nz = 7;
  const Field<float> phi = level_set<float>(nx, ny, nz, .1f, Numbers{});
  const Faces<float> faces = random_faces(nx, ny, nz, .1f, 1);
  for (const float dt : {.05f, .3f, 10.f}) {
    for (LevelSet* advect : level_sets) {
      const auto [least, most] = range_of(phi);
      const auto [least_after, most_after] = range_of(advected(advect, phi, faces, dt));
      EXPECT_GE(least_after, least - 3 * 5 * u);
      EXPECT_LE(most_after, most + 3 * 5 * u);
    }
    for (Velocity* advect : velocities)
      for_each_component(faces, advected(advect, faces, dt), [](const Field<float>& before, const Field<float>& after) {
        EXPECT_GE(range_of(after).first, range_of(before).first - 3 * 5 * u);
        EXPECT_LE(range_of(after).second, range_of(before).second + 3 * 5 * u);
      });
  }
}

// Every number of cells along x up to more than a vector, and more than two; short and long steps; padding stays as it
// was.
TEST(ProductionFluidAdvect, TwinsAgreeInEverySize) {
  for (const int nx : {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 33})
    for (const float dt : {.09f, -.09f, 1.f}) {
      const Field<float> phi = level_set<float>(nx, 3, 4, .1f, Numbers{});
      const Faces<float> faces = random_faces(nx, 3, 4, .1f, 1);
      for (int form = 0; form < 4; form += 2) {
        const Field<float> one = advected(level_sets[form], phi, faces, dt),
                           other = advected(level_sets[form + 1], phi, faces, dt);
        EXPECT_EQ(one.value, other.value) << nx << ' ' << dt;
        expect_padding_is_poison(one);
        const Faces<float> moved = advected(velocities[form], faces, dt);
        for_each_component(
            moved, advected(velocities[form + 1], faces, dt),
            [&](const Field<float>& a, const Field<float>& b) { EXPECT_EQ(a.value, b.value) << nx << ' ' << dt; });
        expect_padding_is_poison(moved);
      }
    }
}

TEST(ProductionFluidAdvect, DoesNothingWithoutCells) {
  const Field<float> phi = level_set<float>(0, 0, 0, 1, Numbers{});
  const Faces<float> faces = make_faces<float>(0, 3, 2, 1.f);
  for (LevelSet* advect : level_sets)
    for (const float v : advected(advect, phi, faces, 1).value) EXPECT_EQ(v, poison);
}

}  // namespace
}  // namespace lockstep::production_fluid
