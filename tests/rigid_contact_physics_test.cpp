// The contact solver against physics in closed form: a box on a slope, bounces, momentum, penetration, a conveyor.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "tests/contact_exact.h"

namespace lockstep::rigid::contacts {
namespace {

SolverSettings thorough(const Vector& gravity) {
  return {.time_step = .01, .gravity = gravity, .substeps = 2, .biased_sweeps = 50, .relax_sweeps = 500};
}

// The most by which rounding may change velocities in this many steps.
double steps_bound(const SolverSettings& settings, const Problem<double>& p, int steps) {
  const int sweeps = settings.substeps * (settings.biased_sweeps + settings.relax_sweeps + 2);
  const System s = assemble(settings, p);
  return steps * row_bound(s, drift_bound(s, impulses_of(p), sweeps, u));
}

// The box slides down the slope along a tangent or between the two. Each tangent bounds its own share of friction by mu
// p_n, so between the two the friction box is sqrt(2) as wide. The test tilts gravity, not the slope.
void expect_slide(const Vector& normal, double share_t, double share_b, double box_width) {
  constexpr double angle = .5, at_first = .5;
  Vector t, b;
  make_tangents(normal, t, b);
  const Vector down = share_t * t + share_b * b;
  const SolverSettings settings = thorough(g * (std::sin(angle) * down - std::cos(angle) * normal));
  for (const double friction : {.1, .25, .8}) {
    const double acceleration = g * (std::sin(angle) - box_width * friction * std::cos(angle));
    Problem<double> p = box_on_slope(normal, at_first * down, friction);
    for (int step = 1; step <= 30; ++step) {
      solve_original(settings, p);
      // A substep that would reverse the motion stops it.
      const Vector expected = std::max(at_first + step * settings.time_step * acceleration, 0.) * down;
      const Vector off = p.bodies.motion[1].velocity - expected, spin = p.bodies.motion[1].angular_velocity;
      const double bound = steps_bound(settings, p, step);
      EXPECT_LE(std::sqrt(dot(off, off)), bound) << friction << ' ' << step;
      EXPECT_LE(std::sqrt(dot(spin, spin)), bound) << friction << ' ' << step;
    }
    EXPECT_EQ(acceleration < 0, dot(p.bodies.motion[1].velocity, p.bodies.motion[1].velocity) < 1e-9);
  }
}

TEST(ContactPhysics, BoxOnASlopeSlidesOrStaysAsFrictionSays) {
  for (const Vector& normal : {Vector{0, 1, 0}, slope, unit({-.3, .2, -.8})}) {
    expect_slide(normal, 1, 0, 1);
    expect_slide(normal, 0, -1, 1);
    expect_slide(normal, std::numbers::sqrt2 / 2, std::numbers::sqrt2 / 2, std::numbers::sqrt2);
  }
}

// v1' = v1 + (1 + e) m2 / (m1 + m2) (v2 - v1). For equal masses and e = 1 the velocities swap.
TEST(ContactPhysics, SpheresCollideHeadOn) {
  for (const int substeps : {1, 2, 5})
    for (const double e : {0., .5, 1.})
      for (const double m2 : {1., 3.})
        for (const double apart : {0., .01}) {
          constexpr double m1 = 1, v1 = 2, v2 = -1;
          const SolverSettings settings{.time_step = .01, .gravity = {0, 0, 0}, .substeps = substeps};
          Problem<double> p;
          add(p, {.position = {-.5, 0, 0},
                  .mass = m1,
                  .inertia = {.1, .1, .1},
                  .velocity = {v1, 0, 0},
                  .friction = .5,
                  .restitution = e});
          add(p, {.position = {.5 + apart, 0, 0},
                  .mass = m2,
                  .inertia = {.1, .1, .1},
                  .velocity = {v2, 0, 0},
                  .friction = .5});
          touch(p, 0, 1, {1, 0, 0}, {{{.5 * apart, 0, 0}, apart}});
          solve_original(settings, p);
          const double bound = drift_bound(assemble(settings, p), impulses_of(p), 2 * substeps + 2, u);
          EXPECT_NEAR(p.bodies.motion[0].velocity.x, v1 + (1 + e) * m2 / (m1 + m2) * (v2 - v1), bound)
              << substeps << ' ' << e << ' ' << apart;
          EXPECT_NEAR(p.bodies.motion[1].velocity.x, v2 + (1 + e) * m1 / (m1 + m2) * (v1 - v2), bound)
              << substeps << ' ' << e << ' ' << apart;
          for (const int i : {0, 1}) EXPECT_EQ(p.bodies.motion[i].velocity.y, 0) << i;
        }
}

TEST(ContactPhysics, WithoutStaticBodiesMomentumIsKept) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    Problem<double> p = cluster(12, 30, false, .4, seed);
    std::fill(p.bodies.restitution.begin(), p.bodies.restitution.end(), .1 * seed);
    const SolverSettings settings{.time_step = .01, .gravity = {0, 0, 0}, .bounce_from = .2};
    const System s = assemble(settings, p);
    const int count = p.bodies.count;
    const auto momentum = [&] {
      const VectorXd v = velocities(p.bodies.motion, count);
      Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
      for (int i = 0; i < count; ++i) {
        const Eigen::Vector3d linear = v.segment<3>(6 * i) / s.inverse_mass(6 * i, 6 * i),
                              at = eigen(p.bodies.pose[i].position);
        const Eigen::Matrix3d inertia = s.inverse_mass.block<3, 3>(6 * i + 3, 6 * i + 3).inverse();
        sum.head<3>() += linear;
        sum.tail<3>() += at.cross(linear) + inertia * v.segment<3>(6 * i + 3);
      }
      return sum;
    };
    const Eigen::Matrix<double, 6, 1> before = momentum();
    solve_original(settings, p);
    // Each velocity is off by the drift. Bodies lie within 4 m of the origin and weigh 2.5 kg at most.
    const double drift =
        drift_bound(s, impulses_of(p), settings.substeps * (settings.biased_sweeps + settings.relax_sweeps) + 2, u);
    EXPECT_LE((momentum() - before).cwiseAbs().maxCoeff(), count * 2.5 * (1 + 2 * 4) * drift) << seed;
    EXPECT_GT((velocities(p.bodies.motion, count) - s.before).norm(), .5);
  }
}

// A ball above or in the ground, with one contact point.
Problem<double> ball(double separation, double speed_down) {
  Problem<double> p;
  const int ground = add_ground(p);
  const int b = add(
      p, {.position = {0, .5 + separation, 0}, .mass = 2, .inertia = {.2, .2, .2}, .velocity = {0, -speed_down, 0}});
  touch(p, ground, b, {0, 1, 0}, {{{0, .5 * separation, 0}, separation}});
  return p;
}

TEST(ContactPhysics, APointThatIsApartMayJustMeet) {
  for (const int substeps : {1, 3, 5}) {
    const SolverSettings settings{.time_step = .01, .gravity = {0, 0, 0}, .substeps = substeps};
    for (const double apart : {.001, .02}) {
      for (const double speed : {2.5, 40.}) {
        Problem<double> p = ball(apart, speed);
        solve_original(settings, p);
        const double reaches = std::min(apart, speed * settings.time_step);
        EXPECT_NEAR(p.moving[1].velocity.y * settings.time_step, -reaches,
                    16 * (substeps + 1) * u * speed * settings.time_step);
      }
      Problem<double> slow = ball(apart, .05);
      solve_original(settings, slow);
      EXPECT_EQ(slow.bodies.motion[1].velocity.y, -.05);
      EXPECT_EQ(slow.impulses[0].normal[0], 0);
    }
  }
}

// A ball rests in the ground. Each substep pushes it out as a damped spring would from rest, by the implicit Euler
// rule, and then stops it.
TEST(ContactPhysics, APenetrationIsPushedOutAndLeavesNoSpeed) {
  for (const int substeps : {1, 3, 5})
    for (const double depth : {.0002, .01, 1.}) {
      const SolverSettings settings{.time_step = .01, .gravity = {0, 0, 0}, .substeps = substeps};
      const double h = settings.time_step / substeps, w = 2 * std::numbers::pi * std::min(settings.hertz, .25 / h),
                   z = std::max(settings.damping, 13.4 * h * w);
      double deep = depth;
      for (int i = 0; i < substeps; ++i) {
        const double soft = h * w * (2 * z + h * w);
        deep -= h * std::min(deep * w / (2 * z + h * w), settings.max_bias_velocity) * soft / (1 + soft);
      }
      Problem<double> p = ball(-depth, 0);
      solve_original(settings, p);
      const double bound = 16 * (substeps + 1) * u * settings.max_bias_velocity;
      EXPECT_NEAR(p.moving[1].velocity.y, (depth - deep) / settings.time_step,
                  bound + 16 * u * depth / settings.time_step);
      EXPECT_NEAR(p.bodies.motion[1].velocity.y, 0, bound);
    }
}

// However long a substep is, a soft contact asks back no more than 1 / 27.8 of its depth in it; in short ones it asks
// back h w / (2 z + h w), as its damping ratio z says.
TEST(ContactPhysics, ASubstepAsksBackABoundedShareOfADepth) {
  for (const double hertz : {10., 60., 1000.})
    for (const double damping : {0., 1., 10., 100.})
      for (int substeps = 1; substeps <= 64; ++substeps) {
        const SolverSettings settings{
            .time_step = 1 / 60., .gravity = {0, -g, 0}, .substeps = substeps, .hertz = hertz, .damping = damping};
        const Substep<double> substep = substep_of<double>(settings);
        const double share = substep.h * substep.biased.soft.rate,
                     turn = 2 * std::numbers::pi * std::min(hertz * substep.h, .25),
                     asked = turn / (2 * damping + turn);
        EXPECT_NEAR(share, std::min(asked, 1 / 27.8), 16 * u) << hertz << ' ' << damping << ' ' << substeps;
        EXPECT_EQ(substep.relax.soft.rate, 0);
      }
}

// A ball lies on the ground as deep as a spring of the contact's frequency bears it, g / w^2, however long a substep is
// and whatever the damping.
TEST(ContactPhysics, DepthAtRestIsThatOfTheSpringAlone) {
  for (const double damping : {1., 10., 40.})
    for (const int substeps : {3, 4, 6, 10}) {
      const SolverSettings settings{.time_step = .01, .gravity = {0, -g, 0}, .substeps = substeps, .damping = damping};
      const double w = 2 * std::numbers::pi * settings.hertz;
      Problem<double> p = ball(0, 0);
      // A substep leaves 1 - f of an error, f = h w / (2 z + h w) >= 4.7 h / s. Six seconds leave e^-28 of it.
      for (int step = 0; step < 600; ++step) {
        solve_original(settings, p);
        p.manifolds[0].point[0].separation += settings.time_step * p.moving[1].velocity.y;
      }
      EXPECT_NEAR(-p.manifolds[0].point[0].separation, g / (w * w), 1e-9 * g / (w * w)) << damping << ' ' << substeps;
    }
}

// A static body with a velocity carries what stands on it.
TEST(ContactPhysics, AConveyorCarriesABox) {
  constexpr double friction = .4, speed = 1;
  Problem<double> p = box_on_slope({0, 1, 0}, {0, 0, 0}, friction);
  p.bodies.motion[0].velocity = {speed, 0, 0};
  const Motion<double> conveyor = p.bodies.motion[0];
  const SolverSettings settings = thorough({0, -g, 0});
  for (int step = 1; step <= 40; ++step) {
    solve_original(settings, p);
    EXPECT_NEAR(p.bodies.motion[1].velocity.x, std::min(step * settings.time_step * friction * g, speed),
                steps_bound(settings, p, step));
  }
  EXPECT_EQ(std::memcmp(&conveyor, &p.bodies.motion[0], sizeof conveyor), 0);
}

}  // namespace
}  // namespace lockstep::rigid::contacts
