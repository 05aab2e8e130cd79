// The game cloth against closed forms: one constraint, free fall, terminal velocity, friction, and a rope that hangs at
// rest.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <random>

#include "common/cloth/collide.h"
#include "common/cloth/make.h"
#include "common/cloth/project.h"
#include "common/cloth/residual.h"
#include "common/cloth/step.h"
#include "common/cloth/verlet.h"
#include "common/simd.h"
#include "verify/cloth/run.h"

namespace lockstep::cloth {
namespace {

constexpr double g = 9.81;

Model<double> model(double time_step, int iterations) {
  return {.time_step = time_step,
          .substeps = 1,
          .iterations = iterations,
          .gravity = {0, -g, 0},
          .wind = {0, 0, 0},
          .drag = 0,
          .velocity_factor = 1};
}

SheetPlan plan(int rows, int columns, double spacing, bool bending = false) {
  return {.rows = rows,
          .columns = columns,
          .origin = {0, 0, 0},
          .across = {spacing, 0, 0},
          .down = {0, -spacing, 0},
          .mass = .1,
          .bending = bending,
          .pinned = {}};
}

// --- One constraint

template <class Real>
Real distance(const Point<Real>& a, const Point<Real>& b) {
  return std::hypot(b.x - a.x, b.y - a.y, b.z - a.z);
}

TEST(ClothProject, KeepsItsClosedForm) {
  // d becomes d (1 - (d^2 - L^2) / (d^2 + L^2)) = 2 d L^2 / (d^2 + L^2).
  for (const double d : {.01, .5, .99, 1., 1.01, 2., 10.}) {
    Point<double> a = {1, 2, 3, 4}, b = {1 + d * .6, 2, 3 + d * .8, 1};
    project(a, b, 1.);
    EXPECT_NEAR(distance(a, b), 2 * d / (d * d + 1), 1e-14) << d;
  }
}

TEST(ClothProject, IsExactToFirstOrder) {
  for (const double strain : {1e-2, 1e-3, 1e-4}) {
    Point<double> a = {0, 0, 0, 1}, b = {0, 1 + strain, 0, 1};
    project(a, b, 1.);
    EXPECT_LT(std::abs(distance(a, b) - 1), strain * strain);
  }
}

TEST(ClothProject, KeepsTheCentreOfMass) {
  Point<double> a = {1, 0, 0, .5}, b = {0, 3, 1, 2};  // masses 2 and .5
  const Point<double> a0 = a, b0 = b;
  project(a, b, 1.);
  EXPECT_NEAR(2 * (a.x - a0.x) + .5 * (b.x - b0.x), 0, 1e-15);
  EXPECT_NEAR(2 * (a.y - a0.y) + .5 * (b.y - b0.y), 0, 1e-15);
  EXPECT_NEAR(2 * (a.z - a0.z) + .5 * (b.z - b0.z), 0, 1e-15);
}

TEST(ClothProject, LeavesPinnedAndCoincidentParticlesWhereTheyAre) {
  Point<float> a = {1, 2, 3, 0}, b = {4, 5, 6, 1};
  project(a, b, 1.f);
  EXPECT_TRUE(a.x == 1 && a.y == 2 && a.z == 3);
  EXPECT_NE(b.x, 4);
  Point<float> c = {1, 2, 3, 0}, d = {4, 5, 6, 0};
  project(c, d, 1.f);
  EXPECT_TRUE(c.x == 1 && d.x == 4 && d.y == 5 && d.z == 6);
  Point<float> e = {1, 2, 3, 1}, f = {1, 2, 3, 1};
  project(e, f, 1.f);
  EXPECT_TRUE(e.x == 1 && e.y == 2 && e.z == 3 && f.x == 1 && f.y == 2 && f.z == 3);
}

TEST(ClothProject, SixteenLanesGiveTheBitsOfSixteenNumbers) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> number(-2, 2);
  float in[8][lanes], out[6][lanes];
  for (auto& row : in)
    for (float& x : row) x = number(random);
  for (int l = 0; l < lanes; ++l)
    in[3][l] = l % 3 == 0 ? 0 : std::abs(in[3][l]), in[7][l] = l % 2 == 0 ? 0 : std::abs(in[7][l]);
  Point<floatv> a = {load(in[0]), load(in[1]), load(in[2]), load(in[3])},
                b = {load(in[4]), load(in[5]), load(in[6]), load(in[7])};
  project(a, b, floatv(.7f));
  store(out[0], a.x), store(out[1], a.y), store(out[2], a.z), store(out[3], b.x), store(out[4], b.y),
      store(out[5], b.z);
  for (int l = 0; l < lanes; ++l) {
    Point<float> p = {in[0][l], in[1][l], in[2][l], in[3][l]}, q = {in[4][l], in[5][l], in[6][l], in[7][l]};
    project(p, q, .7f);
    const float expected[] = {p.x, p.y, p.z, q.x, q.y, q.z};
    for (int k = 0; k < 6; ++k) EXPECT_EQ(std::memcmp(&out[k][l], &expected[k], 4), 0) << l << ' ' << k;
  }
}

// --- Making a cloth

TEST(ClothMake, TiesWhatTheFactsCount) {
  // As the peers were measured: 128 x 128 with bending, one edge pinned.
  SheetPlan sheet = plan(128, 128, .01, true);
  for (int c = 0; c < 128; ++c) sheet.pinned.push_back(c);
  EXPECT_EQ(make_sheet(model(.01, 1), {}, sheet).constraints.count, 96773);
}

TEST(ClothMake, TiesEveryEdgeOfAMeshOnceAndBendsAcrossIt) {
  // Two triangles with a common edge, and a third on the same edge: not a manifold.
  const MeshPlan mesh = {.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {.5, .5, 1}},
                         .triangles = {{0, 1, 2}, {3, 2, 1}, {1, 2, 4}},
                         .mass = 1,
                         .bending = true,
                         .pinned = {4, 4}};
  const Cloth<double> cloth = make_mesh(model(.01, 1), {}, mesh);
  EXPECT_EQ(cloth.constraints.count, 3 + 2 + 2 + 2);  // the edges, and bending 0 - 3 and 3 - 4
  EXPECT_EQ(cloth.inverse_mass[4], 0);
  EXPECT_EQ(cloth.inverse_mass[0], 5);
}

// --- Verlet

TEST(ClothVerlet, FreeFallIsExact) {
  // Verlet sums a constant acceleration exactly: y_n = -g dt^2 n (n + 1) / 2.
  const double dt = 1. / 64;
  Cloth<double> cloth = make_sheet(model(dt, 5), {}, plan(4, 5, .1));
  for (int n = 1; n <= 1000; ++n) serial::step_original(cloth);
  EXPECT_NEAR(cloth.position.y[cloth.sheet.index(0, 2)], -g * dt * dt * 1000 * 1001 / 2, 1e-8);
  EXPECT_NEAR(residual(cloth), 0, 1e-12);
}

TEST(ClothVerlet, AFlatTriangleFallsWithTerminalVelocity) {
  // Where drag balances weight: drag / 2 v^2 A = m g.
  const MeshPlan mesh = {.points = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}},
                         .triangles = {{0, 1, 2}},
                         .mass = .2,
                         .bending = false,
                         .pinned = {}};
  Model<double> m = model(1. / 200, 1);
  m.drag = 1.3;
  Cloth<double> cloth = make_mesh(m, {}, mesh);
  for (int step = 0; step < 4000; ++step) serial::step_original(cloth);
  const double v = (cloth.position.y[0] - cloth.previous.y[0]) / m.time_step;
  EXPECT_NEAR(v, -std::sqrt(2 * .2 * g / (1.3 * .5)), 1e-6);
}

TEST(ClothVerlet, WindAlongAClothDoesNothingAndAcrossItItPushes) {
  Model<double> m = model(1. / 100, 1);
  m.gravity = {0, 0, 0};
  m.drag = 1;
  m.wind = {3, -2, 0};  // in the plane of the sheet
  Cloth<double> along = make_sheet(m, {}, plan(5, 6, .1));
  serial::step_original(along);
  EXPECT_LT(residual(along), 1e-15);
  EXPECT_EQ(along.position.x[along.sheet.index(2, 2)], along.previous.x[along.sheet.index(2, 2)]);

  m.wind = {0, 0, -4};
  Cloth<double> across = make_sheet(m, {}, plan(5, 6, .1));
  serial::verlet(across);
  double force = 0;  // m a, of all particles
  for (int r = 0; r < 5; ++r)
    for (int c = 0; c < 6; ++c)
      force += across.position.z[across.sheet.index(r, c)] / (m.time_step * m.time_step) * .1 / 30;
  EXPECT_NEAR(force, -.5 * 16 * (.4 * .5), 1e-12);  // drag / 2 v^2 A
}

// --- Collisions

TEST(ClothCollide, NothingIsLeftInsideAnyBody) {
  const double c = std::cos(.4), s = std::sin(.4);
  Bodies<double> bodies;
  bodies.planes.push_back({{0, 1, 0}, -.8});
  bodies.capsules.push_back({{-.2, 0, .1}, {.5, .3, 0}, .25});
  bodies.capsules.push_back({{-.6, 0, .6}, {-.6, 0, .6}, .3});
  bodies.boxes.push_back({{.3, -.5, -.4}, {.3, .2, .25}, {{{c, s, 0}, {-s, c, 0}, {0, 0, 1}}}});
  bodies.friction = .3;
  Cloth<double> made = make_sheet(model(.01, 1), bodies, plan(60, 60, .01));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int i = 0; i < made.count; ++i)
    for (Array<double>* x :
         {&made.position.x, &made.position.y, &made.position.z, &made.previous.x, &made.previous.y, &made.previous.z})
      (*x)[i] = made.inverse_mass[i] > 0 ? number(random) : 0;
  const Cloth<float> start = convert<float>(made);
  ASSERT_GT(verify::deepest_inside(bodies, start).depth, .2);
  Cloth<float> serial = start;
  serial::collide(serial);
  // Pushed to the surface, a coordinate of about 1 is rounded, a few times over.
  EXPECT_LT(verify::deepest_inside(bodies, serial).depth, 8 * 0x1p-24);
  for (const int threads : {1, 2, 3}) {
    omp_set_num_threads(threads);
    Cloth<float> openmp = start;
    openmp::collide(openmp);
    EXPECT_EQ(openmp.position.x, serial.position.x);
    EXPECT_EQ(openmp.position.y, serial.position.y);
    EXPECT_EQ(openmp.position.z, serial.position.z);
  }
}

TEST(ClothCollide, APointOnTheAxisFindsAWayOut) {
  Bodies<double> bodies;
  bodies.capsules.push_back({{0, 0, 0}, {0, 0, 0}, .5});
  Cloth<double> cloth = make_sheet(model(.01, 1), bodies, plan(1, 2, 3));
  serial::collide(cloth);
  EXPECT_EQ(cloth.position.y[0], .5);
}

TEST(ClothCollide, FrictionIsCoulombs) {
  // Gravity pushes each particle g dt^2 into the floor in a step, so friction takes mu g dt of its velocity: it stops
  // after v^2 / (2 mu g), but for what a step more or less makes, v dt.
  const double dt = 1e-3, v = 2, mu = .4;
  Bodies<double> bodies;
  bodies.planes.push_back({{0, 1, 0}, 0});
  bodies.friction = mu;
  Cloth<double> cloth = make_sheet(model(dt, 1), bodies, plan(1, 2, .1));
  for (int i = 0; i < 2; ++i) cloth.previous.x[i] -= v * dt;
  for (int step = 0; step < 2000; ++step) serial::step_original(cloth);
  EXPECT_NEAR(cloth.position.x[0], v * v / (2 * mu * g), v * dt);
  EXPECT_EQ(cloth.position.x[0], cloth.previous.x[0]);
}

// --- At rest

// A rope of n links, hung from both ends, at rest: how far its particles are from the catenary of its length, at the
// most.
double distance_from_catenary(int links) {
  constexpr double length = 1, span = .7;
  // a solves 2 a sinh(span / 2a) = length.
  double a = .3;
  for (int k = 0; k < 50; ++k) {
    const double f = 2 * a * std::sinh(span / (2 * a)) - length;
    a -= f / (2 * std::sinh(span / (2 * a)) - span / a * std::cosh(span / (2 * a)));
  }
  const auto x_at = [&](double s) { return a * std::asinh((s - length / 2) / a); };  // by arc length, 0 in the middle
  const auto y_at = [&](double x) { return a * (std::cosh(x / a) - std::cosh(span / (2 * a))); };

  Model<double> m = model(1. / 480, 40 * links);
  m.velocity_factor = .9;
  SheetPlan rope = plan(1, links + 1, length / links);
  rope.pinned = {0, links};
  Cloth<double> cloth = make_sheet(m, {}, rope);
  for (int i = 0; i <= links; ++i) {
    cloth.position.x[i] = x_at(length * i / links);
    cloth.position.y[i] = y_at(cloth.position.x[i]);
  }
  cloth.previous = cloth.position;
  for (int step = 0; step < 400; ++step) serial::step_original(cloth);
  double farthest = 0;
  for (int i = 0; i <= links; ++i)
    farthest = std::max(farthest, std::abs(cloth.position.y[i] - y_at(cloth.position.x[i])));
  return farthest;
}

TEST(ClothRope, HangsInACatenaryToSecondOrder) {
  // A chain of straight links is as far from the curve as a chord from its arc: proportional to the square of a link's
  // length.
  const double coarse = distance_from_catenary(8), middle = distance_from_catenary(16),
               fine = distance_from_catenary(32);
  EXPECT_NEAR(std::log2(coarse / middle), 2, .2);
  EXPECT_NEAR(std::log2(middle / fine), 2, .2);
  EXPECT_LT(fine, 1e-3);
}

TEST(ClothRope, HungFromOneEndItIsAsLongAsTheIterationsLeaveIt) {
  // At rest a step is a fixed point: gravity lengthens the first link by g dt^2, and n sweeps bring that back. To first
  // order in the strain a sweep is linear: a link's excess goes to its neighbours in halves, the first link's to the
  // second whole.
  constexpr int links = 12, sweeps = 10;
  const double dt = 1. / 1000, spacing = .05;
  std::vector<double> excess(links, 0);
  for (int step = 0; step < 20000; ++step) {
    excess[0] += g * dt * dt;
    for (int sweep = 0; sweep < sweeps; ++sweep)
      for (int k = 0; k < links; ++k) {
        const double e = excess[k];
        excess[k] = 0;
        if (k > 0) excess[k - 1] += e / 2;
        if (k + 1 < links) excess[k + 1] += k > 0 ? e / 2 : e;
      }
  }

  Model<double> m = model(dt, sweeps);
  m.velocity_factor = .98;
  SheetPlan rope = plan(links + 1, 1, spacing);
  rope.pinned = {0};
  Cloth<double> cloth = make_sheet(m, {}, rope);
  for (int step = 0; step < 20000; ++step) serial::step_original(cloth);
  const auto y = [&](int r) { return cloth.position.y[cloth.sheet.index(r, 0)]; };
  const double most = *std::max_element(excess.begin(), excess.end());
  double sum_2 = 0;
  for (int k = 0; k < links; ++k) {
    EXPECT_NEAR(y(k) - y(k + 1) - spacing, excess[k], 3 * most * most / spacing)
        << k;  // the strain's square is neglected
    sum_2 += std::pow((y(k) - y(k + 1)) / spacing - 1, 2);
  }
  EXPECT_GT(most, 1e-6);
  EXPECT_NEAR(residual(cloth), std::sqrt(sum_2 / links), 1e-12);
}

}  // namespace
}  // namespace lockstep::cloth
