// MacCormack's correction of advection against facts: corrections by hand, what it may not change, and its order.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/production_fluid_advection.h"

namespace lockstep::production_fluid {
namespace {

// What n x m x m values become when they move by c points along the first axis, word by word as the method says. It is
// exact where values and c are small multiples of a power of two. Counts what is corrected, and what the range keeps
// from it.
struct ByHand {
  int n, m;
  double c;
  int corrected = 0, kept = 0;

  template <class Q>
  double operator()(const Q& q, int i, int j, int k) {
    const auto at = [&](const auto& values, double x) {
      const double inside = std::clamp(x, 0., n - 1.), t = inside - std::floor(inside);
      const int first = int(inside);
      return (1 - t) * values(first) + t * values(std::min(first + 1, n - 1));
    };
    const auto arrived = [&](int p) { return at([&](int s) { return q(s, j, k); }, p - c); };
    const double value = arrived(i), better = value + (q(i, j, k) - at(arrived, i + c)) / 2;
    if (std::min(i - c, i + c) < 0 || std::max(i - c, i + c) > n - 1) return value;
    const int first = int(i - c);
    double least = q(first, j, k), most = least;
    for (int corner = 1; corner < 8; ++corner) {
      const double v =
          q(std::min(first + corner % 2, n - 1), std::min(j + corner / 2 % 2, m - 1), std::min(k + corner / 4, m - 1));
      least = std::min(least, v), most = std::max(most, v);
    }
    const bool fits = least <= better && better <= most;
    ++(fits ? corrected : kept);
    return fits ? better : value;
  }
};

// An axis takes its turn as the first. All values are far above the 0 of the padding, which bounds nothing.
TEST(ProductionFluidMacCormack, CorrectsALevelSetAsByHand) {
  constexpr int n = 37, m = 3;
  for (int axis = 0; axis < 3; ++axis)
    for (const double c : {.25, .5, 1.75, 3., -.5, -2.25}) {
      int size[3] = {m, m, m};
      size[axis] = n;
      Numbers number;
      const Field<float> phi = level_set<float>(
          size[0], size[1], size[2], 1, [&](double, double, double) { return 100 + std::round(32 * number()); });
      double velocity[3] = {0, 0, 0};
      velocity[axis] = c;
      const Faces<float> faces = constant<float>(size[0], size[1], size[2], 1, {velocity[0], velocity[1], velocity[2]});
      for (LevelSet* advect : corrected_level_sets) {
        const Field<float> after = advected(advect, phi, faces, 1);
        const auto turned = [&](const Field<float>& field, int i, int j, int k) {
          int p[3];
          p[axis] = i, p[(axis + 1) % 3] = j, p[(axis + 2) % 3] = k;
          return field(p[0], p[1], p[2]);
        };
        ByHand by_hand{n, m, c};
        for (int k = 0; k < m; ++k)
          for (int j = 0; j < m; ++j)
            for (int i = 0; i < n; ++i)
              EXPECT_EQ(turned(after, i, j, k),
                        by_hand([&](int a, int b, int d) { return turned(phi, a, b, d); }, i, j, k))
                  << axis << ' ' << c << ": " << i << ' ' << j << ' ' << k;
        EXPECT_GT(by_hand.corrected, n) << axis << ' ' << c;
        EXPECT_GT(by_hand.kept, c == 3 ? -1 : n / 4) << axis << ' ' << c;
      }
    }
}

// One component carries another that varies along its axis alone. What it carries moves along its own axis, too, where
// nothing varies, but by at most a face.
TEST(ProductionFluidMacCormack, CorrectsAVelocityAsByHand) {
  constexpr int n = 20;
  const auto same = [](double, double, double) { return 0.; };
  for (int carrier = 0; carrier < 3; ++carrier)
    for (int carried = 0; carried < 3; ++carried)
      for (const double c : {.5, -1.25}) {
        if (carrier == carried) continue;
        Faces<float> faces = faces_of<float>(n, n, n, 1, same, same, same);
        Field<float>* const component[3] = {&faces.u, &faces.v, &faces.w};
        std::fill(component[carrier]->value.begin(), component[carrier]->value.end(), float(c));
        Numbers number;
        double q[n];
        for (double& value : q) value = std::round(32 * number()) / 32;
        const Vector3<float> none = {0, 0, 0};
        fill(*component[carried], none, [&](double x, double y, double z) {
          return q[int(carrier == 0 ? x : carrier == 1 ? y : z)];
        });
        for (Velocity* advect : corrected_velocities) {
          const Faces<float> after = advected(advect, faces, 1);
          const Field<float>* const result[3] = {&after.u, &after.v, &after.w};
          ByHand by_hand{n, 1, c};
          for_each_point(*result[carried], [&](int x, int y, int z, float v) {
            const int p[3] = {x, y, z};
            if (p[carried] < 1 || p[carried] > n - 1) return;
            EXPECT_EQ(v, by_hand([&](int i, int, int) { return q[i]; }, p[carrier], 0, 0))
                << carrier << ' ' << carried << ' ' << c << ": " << x << ' ' << y << ' ' << z;
          });
          EXPECT_GT(by_hand.corrected, n * n);
          EXPECT_GT(by_hand.kept, n * n / 2);
          for_each_point(*result[carrier], [&](int, int, int, float v) { EXPECT_EQ(v, c); });
        }
      }
}

// u = a x: the foot of x is s x, that with -dt is t x, and both lie on a straight line. So x becomes
// a (s + (1 - s t) / 2) x, where this is not below the face before the foot and t x is in the box. All are exact.
TEST(ProductionFluidMacCormack, CorrectsAVelocityThatStretches) {
  constexpr int n = 24;
  constexpr double a = .5, s = 1 - a + a * a / 2, t = 1 + a + a * a / 2;
  const auto zero = [](double, double, double) { return 0.; };
  const auto rises = [](double x, double, double) { return a * x; };
  for (Velocity* advect : corrected_velocities)
    for_each_point(advected(advect, faces_of<float>(n, n, n, 1, rises, zero, zero), 1).u,
                   [&](int x, int, int, float v) {
                     const double better = (s + (1 - s * t) / 2) * x;
                     EXPECT_EQ(v, a * (t * x <= n && better >= std::floor(s * x) ? better : s * x)) << x;
                   });
}

TEST(ProductionFluidMacCormack, LeavesConstantFieldsToTheBit) {
  constexpr int nx = 19, ny = 6, nz = 7;
  const Field<float> phi = level_set<float>(nx, ny, nz, .1f, [](double, double, double) { return .3; });
  const Faces<float> faces = random_faces(nx, ny, nz, .1f, 1);
  const Faces<float> same = constant<float>(nx, ny, nz, .1f, {.7, -.3, 1.1});
  for (const float dt : {.05f, .3f, -10.f}) {
    for (LevelSet* advect : level_sets)
      for_each_point(advected(advect, phi, faces, dt), [](int, int, int, float v) { EXPECT_EQ(v, .3f); });
    for (Velocity* advect : velocities)
      for_each_component(same, advected(advect, same, dt), [](const Field<float>& before, const Field<float>& after) {
        for_each_point(after, [&](int x, int y, int z, float v) { EXPECT_EQ(v, before(x, y, z)); });
      });
  }
}

// --- Order, of the mean error: at a maximum, the range cuts off a little.

using Advect = void (*)(const Field<double>& phi, const Faces<double>& faces, double dt, Field<double>& advected);
void corrected(const Field<double>& phi, const Faces<double>& faces, double dt, Field<double>& advected) {
  Arrived<Field<double>> arrived{phi, phi, phi};
  serial::advect_level_set_maccormack(phi, faces, dt, advected, arrived);
}

// A bump in a box of side 1 turns by one radian about the middle in n / 2 steps, so that no step moves by more than a
// cell. What enters by the sides is not known and stays outside of the circle that counts.
double error_of_a_turn(Advect advect, int n) {
  const double h = 1. / n;
  const auto zero = [](double, double, double) { return 0.; };
  const Faces<double> faces = faces_of<double>(
      n, n, 1, h, [=](double, double y, double) { return .5 - y * h; },
      [=](double x, double, double) { return x * h - .5; }, zero);
  const auto bump = [=](double angle) {
    return [=](double x, double y, double) {
      return std::exp(
          -(std::pow(x * h - .5 + .25 * std::sin(angle), 2) + std::pow(y * h - .5 - .25 * std::cos(angle), 2)) / .01);
    };
  };
  Field<double> phi = level_set<double>(n, n, 1, h, bump(0)), next = phi;
  for (int step = 0; step < n / 2; ++step) advect(phi, faces, 2 * h, next), std::swap(phi, next);
  const Field<double> exact = level_set<double>(n, n, 1, h, bump(1));
  double sum = 0;
  for_each_point(phi, [&](int x, int y, int z, double v) {
    if (std::hypot((x + .5) * h - .5, (y + .5) * h - .5) < .4) sum += std::abs(v - exact(x, y, z));
  });
  return sum * h * h;
}

TEST(ProductionFluidMacCormack, TurnsALevelSetWithSecondOrder) {
  const auto order = [](Advect advect) {
    const double coarse = error_of_a_turn(advect, 64), fine = error_of_a_turn(advect, 128);
    return std::log2(coarse / fine);
  };
  EXPECT_GT(order(corrected), 1.9);
  EXPECT_LT(order(serial::advect_level_set_semi_lagrangian), 1.1);
}

// u = 1 carries v = 2^-20 sin(2 pi x) through .4 of the box in steps of .8 cells. What enters is not known, so it does
// not count, nor what that can have reached. Feet of the first and the last face along y lie outside, so these are not
// corrected. v is so small that the faces in the middle hear nothing of it.
template <class AdvectVelocities>
double error_of_a_shear(const AdvectVelocities& advect, int n) {
  const double h = 1. / n, dt = .8 * h;
  const int steps = int(.4 / dt);
  const auto wave = [=](double time) {
    return [=](double x, double, double) { return 0x1p-20 * std::sin(2 * std::numbers::pi * (x * h - time)); };
  };
  const auto zero = [](double, double, double) { return 0.; };
  const auto one = [](double, double, double) { return 1.; };
  Faces<double> faces = faces_of<double>(n, 4, 1, h, one, wave(0), zero), next = faces;
  for (int step = 0; step < steps; ++step) advect(faces, dt, next), std::swap(faces, next);
  const Faces<double> exact = faces_of<double>(n, 4, 1, h, one, wave(steps * dt), zero);
  double sum = 0;
  for (int x = n / 2; x < n; ++x) sum += std::abs(faces.v(x, 2, 0) - exact.v(x, 2, 0));
  return 0x1p20 * sum * h;
}

TEST(ProductionFluidMacCormack, CarriesAShearWithSecondOrder) {
  const auto order = [](const auto& advect) {
    const double coarse = error_of_a_shear(advect, 128), fine = error_of_a_shear(advect, 256);
    return std::log2(coarse / fine);
  };
  EXPECT_GT(order([](const Faces<double>& faces, double dt, Faces<double>& advected) {
              Arrived<Faces<double>> arrived{faces, faces, faces};
              serial::advect_velocity_maccormack(faces, dt, advected, arrived);
            }),
            1.9);
  EXPECT_LT(order([](const Faces<double>& faces, double dt, Faces<double>& advected) {
              serial::advect_velocity_semi_lagrangian(faces, dt, advected);
            }),
            1.1);
}

}  // namespace
}  // namespace lockstep::production_fluid
