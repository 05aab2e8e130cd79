// Free bodies against free fall and the symmetric top, and both versions of integrate against each other, bit by bit.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "common/rigid/integrate.h"
#include "tests/contact_exact.h"

namespace lockstep::rigid::contacts {
namespace {

void advance(Problem<double>& p, double dt) { serial::integrate(p.bodies.motion, dt, p.bodies); }

TEST(Advance, FreeFall) {
  constexpr int steps = 200;
  const SolverSettings settings{.time_step = .01, .gravity = {0, -g, 0}};
  Problem<double> p;
  add(p, {.mass = 3, .inertia = {1, 2, 2.5}, .velocity = {1, 2, 0}});
  add(p, {.velocity = {1, 2, 0}});
  for (int step = 0; step < steps; ++step) {
    solve_original(settings, p);
    serial::integrate(p.moving, settings.time_step, p.bodies);
  }
  // After N substeps of h, v = v0 - N g h and x = v0 N h - g h^2 N (N + 1) / 2. Each of the N sums rounds once, and
  // each of their terms three times.
  const double h = settings.time_step / settings.substeps, n = steps * settings.substeps, speed = g * n * h,
               way = g * h * h * n * (n + 1) / 2;
  EXPECT_NEAR(p.bodies.motion[0].velocity.y, 2 - speed, 4 * n * u * speed);
  EXPECT_NEAR(p.bodies.pose[0].position.y, 2 * n * h - way, 4 * n * u * way);
  EXPECT_NEAR(p.bodies.pose[0].position.x, n * h, 4 * n * u * n * h);
  EXPECT_EQ(p.bodies.pose[1].position.y, 0);  // static
  EXPECT_EQ(p.bodies.motion[1].velocity.y, 2);
}

template <class Real>
struct Free {
  Eigen::Vector3d momentum;
  double energy;
  Free(const Problem<Real>& p) {
    const Pose<Real>& pose = p.bodies.pose[0];
    const Quad<Real>& inverse = p.bodies.inverse_mass[0];
    const Eigen::Matrix3d r =
        Eigen::Quaterniond(pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z)
            .normalized()
            .toRotationMatrix();
    const Eigen::Vector3d w = eigen(lockstep::convert<double>(p.bodies.motion[0].angular_velocity));
    const Eigen::Vector3d local = (r.transpose() * w).cwiseQuotient(Eigen::Vector3d(inverse.x, inverse.y, inverse.z));
    momentum = r * local;
    energy = w.dot(momentum) / 2;
  }
};

const Quaternion<double> askew = {.1, -.5, .3, std::sqrt(1 - .35)};

// In a body with inertias A, A, C about its axes, the axis of C precesses about the angular momentum L at |L| / A. The
// body also turns about this axis, at L_C (1 / C - 1 / A).
TEST(Advance, SymmetricTopPrecesses) {
  constexpr double a = 2, c = 3.5, time = 2;
  const auto error = [&](int steps) {
    Problem<double> p;
    add(p, {.mass = 1, .inertia = {a, a, c}, .angular = {1.5, .7, -2}, .orientation = askew});
    const Eigen::Vector3d momentum = Free<double>(p).momentum;
    const Eigen::Quaterniond start = eigen(askew);
    const double along = momentum.dot(start * Eigen::Vector3d::UnitZ());
    for (int step = 0; step < steps; ++step) advance(p, time / steps);
    const Eigen::Quaterniond expected = Eigen::AngleAxisd(momentum.norm() / a * time, momentum.normalized()) * start *
                                        Eigen::AngleAxisd(along * (1 / c - 1 / a) * time, Eigen::Vector3d::UnitZ());
    return expected.angularDistance(eigen(p.bodies.pose[0].orientation));
  };
  const double coarse = error(200), fine = error(400), finest = error(800);
  // The method is of second order: half the step leaves a quarter of the error, but for terms of third order, of
  // relative size about the step times the speed.
  const double third_order = 2.6 * time / 200;
  EXPECT_NEAR(coarse / fine, 4, 4 * 2 * third_order);
  EXPECT_NEAR(fine / finest, 4, 4 * third_order);
  RecordProperty("error_rad", std::to_string(coarse));
  // In each step the midpoint rule and its normalisation lose less than a quarter of the square of the step's angle.
  EXPECT_LE(coarse, time / 4 * std::pow(2.6, 3) * std::pow(time / 200, 2));
}

// A body with three different inertias turns about each axis. About the middle one it tumbles.
template <class Real>
void expect_momentum_kept(double unit_roundoff) {
  constexpr int steps = 10000;
  constexpr double least = 1, most = 3;
  double worst_momentum = 0, worst_energy = 0;
  for (const Vector& local : {Vector{2, .01, .02}, Vector{.01, 2, .01}, Vector{.01, .02, 2}, Vector{1, 1, 1}}) {
    Problem<double> start;
    const Eigen::Vector3d w = eigen(askew) * eigen(local);
    add(start, {.mass = 1, .inertia = {least, 2, most}, .angular = {w.x(), w.y(), w.z()}, .orientation = askew});
    Problem<Real> p = convert<Real>(start);
    const Free<Real> before(p);
    double lowest = 2, highest = -2;  // of the middle axis along the angular momentum
    for (int step = 0; step < steps; ++step) {
      serial::integrate(p.bodies.motion, Real(.01), p.bodies);
      const Free<Real> now(p);
      const Pose<double> pose = convert<double>(p).bodies.pose[0];
      const double middle = (eigen(pose.orientation) * Eigen::Vector3d::UnitY()).dot(before.momentum.normalized());
      lowest = std::min(lowest, middle), highest = std::max(highest, middle);
      worst_momentum = std::max(worst_momentum, (now.momentum - before.momentum).norm() / before.momentum.norm());
      worst_energy = std::max(worst_energy, std::abs(now.energy / before.energy - 1));
      const double squared = before.momentum.squaredNorm();
      ASSERT_GE(now.energy, squared / (2 * most) * (1 - 2 * worst_momentum - 64 * unit_roundoff));
      ASSERT_LE(now.energy, squared / (2 * least) * (1 + 2 * worst_momentum + 64 * unit_roundoff));
    }
    EXPECT_TRUE(local.y != 2 || (lowest < -.9 && highest > .9)) << lowest << ' ' << highest;
    EXPECT_TRUE(local.y == 2 || local.y == 1 || highest - lowest < .1);
  }
  // A step turns L into w and back, in 4 products of 3 terms with R or its transpose. The entries of R are off by 4
  // roundings and by |q|^2 - 1, 6 more: 4 (3 + 10) = 52 roundings of w times the largest inertia, which is as much as
  // `most / least` |L|. If roundings have random signs, their sum grows as the square root of their number. The bound
  // fails if each step rounds in the same direction.
  EXPECT_LE(worst_momentum, std::sqrt(steps) * 52 * unit_roundoff * most / least);
  ::testing::Test::RecordProperty("momentum", std::to_string(worst_momentum / unit_roundoff) + " roundings");
  ::testing::Test::RecordProperty("energy", std::to_string(worst_energy));
}
TEST(Advance, KeepsMomentumInDouble) { expect_momentum_kept<double>(u); }
TEST(Advance, KeepsMomentumInFloat) { expect_momentum_kept<float>(u_float); }

TEST(Advance, TwinsAreBitwiseTheSame) {
  for (const int count : {0, 1, 15, 16, 17, 1000}) {
    const Problem<float> start = crowd(count, 0, .3, 41 + count);
    Problem<float> serial = start;
    Array<Motion<float>> moving = start.bodies.motion;
    for (int i = 0; i < count; ++i) moving[i].velocity.y += .1f, moving[i].angular_velocity.z -= .2f;
    for (int step = 0; step < 3; ++step) serial::integrate(moving, .01f, serial.bodies);
    for (const int threads : thread_counts) {
      omp_set_num_threads(threads);
      Problem<float> openmp = start;
      for (int step = 0; step < 3; ++step) openmp::integrate(moving, .01f, openmp.bodies);
      EXPECT_TRUE(same_bits(serial.bodies.pose, openmp.bodies.pose)) << count << ' ' << threads;
      EXPECT_TRUE(same_bits(serial.bodies.motion, openmp.bodies.motion)) << count << ' ' << threads;
    }
  }
}

}  // namespace
}  // namespace lockstep::rigid::contacts
