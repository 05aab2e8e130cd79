// The production fluid against physics whose answer is known: an elliptical drop, standing waves, a dam break.
//
// Each test prints what it measured; notes/production_fluid.md, "Oracles", has the figures of finer grids.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "common/production_fluid/scene.h"
#include "common/production_fluid/step.h"
#include "tests/production_fluids.h"

namespace lockstep::production_fluid {
namespace {

struct Moving {
  Model model;
  Liquid<float> liquid;
  StepMemory<float> memory;

  Moving(const Fluid<float>& fluid, const Model& of) : model(of) {
    liquid.fluid = fluid;
    serial::start(model, liquid, memory);
  }
  void go() { openmp::step_mic(model, liquid, memory); }
};

// --- The elliptical drop (Monaghan, J. Comput. Phys. 110, 1994): the disk x^2 + y^2 < R^2 with the velocity
// (-A x, A y) stays an ellipse with half axes a and b, and its velocity linear.

struct Ellipse {
  double a, b, rate;  // m, m, 1/s
};

// Euler's equations, where the pressure is quadratic and 0 on the ellipse.
Ellipse change_of(const Ellipse& e) {
  const double a2 = e.a * e.a, b2 = e.b * e.b;
  return {-e.a * e.rate, e.b * e.rate, e.rate * e.rate * (a2 - b2) / (a2 + b2)};
}
double central_pressure(const Ellipse& e) {  // over the density
  return e.rate * e.rate * e.a * e.a * e.b * e.b / (e.a * e.a + e.b * e.b);
}

// By the classical method of Runge and Kutta.
Ellipse exact_ellipse(double radius, double t) {
  constexpr int steps = 1000;
  const double dt = t / steps;
  Ellipse e = {radius, radius, 1};
  const auto ahead = [&](const Ellipse& k, double by) {
    return Ellipse{e.a + by * k.a, e.b + by * k.b, e.rate + by * k.rate};
  };
  for (int i = 0; i < steps; ++i) {
    const Ellipse k1 = change_of(e), k2 = change_of(ahead(k1, dt / 2)), k3 = change_of(ahead(k2, dt / 2)),
                  k4 = change_of(ahead(k3, dt));
    e = ahead({k1.a + 2 * k2.a + 2 * k3.a + k4.a, k1.b + 2 * k2.b + 2 * k3.b + k4.b,
               k1.rate + 2 * k2.rate + 2 * k3.rate + k4.rate},
              dt / 6);
  }
  return e;
}

// Half axes by second moments of the liquid (the variance of x is a^2 / 4), the rate by least squares.
Ellipse measured_ellipse(const Fluid<float>& fluid) {
  const double h = fluid.spacing;
  double volume = 0, x1 = 0, y1 = 0, x2 = 0, y2 = 0, product = 0, square = 0;
  for_each_place(fluid.phi, [&](int x, int y, int z) {
    const double cell = liquid_share(fluid.phi(x, y, z), h), px = (x + .5) * h, py = (y + .5) * h;
    volume += cell, x1 += cell * px, y1 += cell * py, x2 += cell * px * px, y2 += cell * py * py;
  });
  x1 /= volume, y1 /= volume, x2 /= volume, y2 /= volume;
  for_each_face(fluid, fluid.velocity,
                [&](const Field<float>& component, int axis, int x, int y, int z, Kind a, Kind b) {
                  if (axis != 1 || a != Kind::liquid || b != Kind::liquid) return;
                  product += component(x, y, z) * (y * h - y1), square += (y * h - y1) * (y * h - y1);
                });
  return {2 * std::sqrt(x2 - x1 * x1), 2 * std::sqrt(y2 - y1 * y1), product / square};
}

struct Errors {
  double a, b, rate, pressure;  // relative
};

// A disk of radius .2 m in a slab of n x n x 2 cells, 1 m long, strained at 1/s for 1 s: it is then 5.2 times as long
// as wide.
Errors errors_of_drop(int n) {
  constexpr double radius = .2, frame = 1. / 48;
  const double h = 1. / n;
  Fluid<float> fluid =
      make_fluid<float>(n, n, 2, h, [&](double x, double y, double) { return std::hypot(x - .5, y - .5) - radius; });
  Field<float>&u = fluid.velocity.u, &v = fluid.velocity.v;
  for_each_place(u, [&](int x, int y, int z) { u(x, y, z) = static_cast<float>(.5 - x * h); });
  for_each_place(v, [&](int x, int y, int z) { v(x, y, z) = static_cast<float>(y * h - .5); });
  Moving moving(fluid, {.gravity = {0, 0, 0}, .frame = frame});
  Errors errors = {};
  for (int k = 1; k <= 48; ++k) {
    moving.go();
    if (k % 16 != 0) continue;
    // What pressure_solve leaves is p dt / (rho h), of a substep that is the whole frame.
    EXPECT_EQ(moving.memory.substeps, 1);
    const double p = moving.liquid.q[moving.memory.system.cells.index(n / 2, n / 2, 0)] * h / frame;
    const Ellipse is = measured_ellipse(moving.liquid.fluid), exact = exact_ellipse(radius, k * frame);
    errors = {is.a / exact.a - 1, is.b / exact.b - 1, is.rate / exact.rate - 1, p / central_pressure(exact) - 1};
    std::printf("drop, %d cells, %.2f s: a %+.2f %%, b %+.2f %%, rate %+.2f %%, pressure %+.2f %%\n", n, k * frame,
                100 * errors.a, 100 * errors.b, 100 * errors.rate, 100 * errors.pressure);
    // The velocity goes on into the air as a constant, so on the surface, on average half a cell away from the last
    // face that is known, it is wrong by rate h / 2. Of what is a wide that is the part h / (2 a) of the rate, and as
    // a' = -rate a, over time (1 / a - 1 / R) h / 2. A substep moves the surface by the rate at its beginning, half a
    // substep too early.
    const double bound = h / 2 * (1 / exact.a - 1 / radius) + frame / 2 * (1 - exact.rate);
    EXPECT_NEAR(errors.a, 0, bound);
    EXPECT_NEAR(errors.b, 0, bound);
    EXPECT_NEAR(errors.rate, 0, bound);
    // The pressure has the square of the rate, and a b in it.
    EXPECT_NEAR(errors.pressure, 0, 4 * bound);
  }
  return errors;
}

TEST(ProductionFluidOracles, ADropIsDrawnOutAsEulersEquationsSay) {
  const Errors coarse = errors_of_drop(48), fine = errors_of_drop(96);
  // First order would be 1/2; the substep is the same in both.
  EXPECT_LT(std::abs(fine.a), .7 * std::abs(coarse.a));
  EXPECT_LT(std::abs(fine.b), .7 * std::abs(coarse.b));
  EXPECT_LT(std::abs(fine.rate), .7 * std::abs(coarse.rate));
}

// --- A standing wave of small amplitude: omega^2 = g k tanh(k H)

// The height of the surface in a column of cells, m: the highest crossing.
double height_of(const Fluid<float>& fluid, int x, int z) {
  for (int y = fluid.ny - 2; y >= 0; --y) {
    const double below = fluid.phi(x, y, z), above = fluid.phi(x, y + 1, z);
    if (below < 0 && above >= 0) return (y + .5 + below / (below - above)) * fluid.spacing;
  }
  return 0;
}

// How much longer the period is than that of linear theory, in a slab of n cells, 1 m long and .5 m deep: from the
// first to the last zero, in 3 s, of the wave's own cosine.
double excess_of_period(int n, int half_waves) {
  constexpr double depth = .5, amplitude = .015, g = 9.81;
  const double h = 1. / n, k = half_waves * std::numbers::pi;
  const Fluid<float> fluid = make_fluid<float>(
      n, n * 3 / 4, 2, h, [&](double x, double y, double) { return y - depth - amplitude * std::cos(k * x); });
  Moving moving(fluid, {});
  std::vector<double> zeros;
  double before = 0, largest = 0;
  for (int frame = 0; frame <= 72; ++frame) {
    if (frame > 0) moving.go();
    double wave = 0;
    for (int x = 0; x < n; ++x) wave += 2 * h * height_of(moving.liquid.fluid, x, 0) * std::cos(k * (x + .5) * h);
    if (wave * before < 0) zeros.push_back((frame - wave / (wave - before)) * moving.model.frame);
    if (frame > 48) largest = std::max(largest, std::abs(wave));
    before = wave;
  }
  const double period = 2 * (zeros.back() - zeros.front()) / double(zeros.size() - 1);
  const double exact = 2 * std::numbers::pi / std::sqrt(g * k * std::tanh(k * depth));
  std::printf("wave, %d cells, m = %d: period %.4f s, %+.2f %%; amplitude in the last second %.4f m of %.4f\n", n,
              half_waves, period, 100 * (period / exact - 1), largest, amplitude);
  return period / exact - 1;
}

TEST(ProductionFluidOracles, StandingWavesHaveThePeriodOfLinearTheory) {
  for (const int half_waves : {1, 2}) {
    const double coarse = excess_of_period(48, half_waves), fine = excess_of_period(96, half_waves);
    EXPECT_NEAR(fine, 0, .02) << half_waves;
    EXPECT_LT(std::abs(fine), std::abs(coarse)) << half_waves;
  }
}

// Nothing feeds a wave, so it dies down. Its substeps are short where it is fast and long where it turns round, twice
// in each period; where gravity acts for the length of a substep, before or after the surface has moved, that feeds it
// (notes/production_fluid.md, "Gravity").
TEST(ProductionFluidOracles, AWaveDiesDownWhereSubstepsVary) {
  constexpr int n = 32;
  constexpr double h = 1. / n, k = 2 * std::numbers::pi, amplitude = .03;
  Moving moving(
      make_fluid<float>(n, 24, 2, h, [&](double x, double y, double) { return y - .5 - amplitude * std::cos(k * x); }),
      {});
  double last = 0;
  int least = 1000, most = 0;
  for (int frame = 1; frame <= 144; ++frame) {
    moving.go();
    least = std::min(least, moving.memory.substeps), most = std::max(most, moving.memory.substeps);
    double wave = 0;
    for (int x = 0; x < n; ++x) wave += 2 * h * height_of(moving.liquid.fluid, x, 0) * std::cos(k * (x + .5) * h);
    if (frame > 120) last = std::max(last, std::abs(wave));  // the sixth second: more than a period
  }
  std::printf("wave, %d to %d substeps a frame: %.4f m high in the sixth second, %.4f at first\n", least, most, last,
              amplitude);
  EXPECT_LT(least, most);
  EXPECT_LT(last, amplitude);
}

// --- The dam break of Martin and Moyce (Phil. Trans. R. Soc. A 244, 1952), n^2 = 2

struct Point {
  double t, value;  // without dimension
};

double at(const std::vector<Point>& curve, double t) {
  const auto after = std::ranges::find_if(curve, [&](const Point& point) { return point.t >= t; });
  if (after == curve.begin() || after == curve.end()) return std::nan("");
  const Point &a = after[-1], &b = *after;
  return a.value + (t - a.t) / (b.t - a.t) * (b.value - a.value);
}

// Where the liquid on the floor ends, m.
double front_of(const Fluid<float>& fluid) {
  for (int x = fluid.nx - 2; x >= 0; --x) {
    const double before = fluid.phi(x, 0, fluid.nz / 2), behind = fluid.phi(x + 1, 0, fluid.nz / 2);
    if (before < 0 && behind >= 0) return (x + .5 + before / (before - behind)) * fluid.spacing;
  }
  return 0;
}

// Table 2: the front over a, at t sqrt(2 g / a). The diaphragm in the experiment was not gone at once, so times are
// shifted to agree at the third point.
TEST(ProductionFluidOracles, ADamBreaksAsMartinAndMoyceMeasured) {
  constexpr Point front[] = {{1.19, 1.44}, {1.43, 1.67}, {1.63, 1.89}, {1.83, 2.11}, {1.98, 2.33},
                             {2.20, 2.56}, {2.32, 2.78}, {2.51, 3.00}, {2.65, 3.22}, {2.83, 3.44},
                             {2.98, 3.67}, {3.11, 3.89}, {3.33, 4.11}};
  // Table 6: the height at the wall over 2 a, at t sqrt(g / a).
  constexpr Point wall[] = {{.56, .94},  {.77, .89},  {.93, .83},  {1.08, .78}, {1.28, .72}, {1.46, .67},
                            {1.66, .61}, {1.84, .56}, {2.00, .50}, {2.21, .44}, {2.45, .39}, {2.70, .33}};
  constexpr double a = .05715, g = 9.81;
  const Scene scene = load_scene("scenes/production_fluid/dam_break_mm.toml");
  Moving moving(scene.fluid, scene.model);
  std::vector<Point> fronts = {{0, 1}}, walls = {{0, 1}}, times = {{1, 0}};
  for (int frame = 1; frame <= 45; ++frame) {
    moving.go();
    const double t = frame * scene.model.frame, z = front_of(moving.liquid.fluid) / a;
    fronts.push_back({t * std::sqrt(2 * g / a), z});
    walls.push_back({t * std::sqrt(g / a), height_of(moving.liquid.fluid, 0, scene.fluid.nz / 2) / (2 * a)});
    times.push_back({z, fronts.back().t});
  }
  const double shift = front[0].t - at(times, front[0].value);
  std::printf("dam break, later by %.2f, front:", shift);
  for (const Point& point : front) {
    const double z = at(fronts, point.t - shift);
    std::printf(" %.2f (%+.1f %%)", z, 100 * (z / point.value - 1));
    EXPECT_NEAR(z, point.value, .1 * point.value) << point.t;
  }
  // Front and wall belong together: the height is held to a tenth of the column, too.
  std::printf("\ndam break, height at the wall:");
  for (const Point& point : wall) {
    const double height = at(walls, point.t);
    std::printf(" %.2f (%+.2f)", height, height - point.value);
    EXPECT_NEAR(height, point.value, .1) << point.t;
  }
  std::printf("\n");
}

}  // namespace
}  // namespace lockstep::production_fluid
