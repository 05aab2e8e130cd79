// Projected Gauss-Seidel, run to convergence, against solutions of the same complementarity problem by pivoting
// (tests/contact_exact.h).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "tests/contact_exact.h"

namespace lockstep::rigid::contacts {
namespace {

enum class Friction {
  sticks,  // sticks, or there is no friction: velocities are unique
  slides,  // slides a little: velocities are unique if contraction < 1
  any      // velocities need not be unique: the test asks only for a solution
};

constexpr int long_run = 4000;

// One substep of soft sweeps without friction, which shows their impulses, or with rigid sweeps after them.
SolverSettings one_substep(int pushing, int resting) {
  return {.time_step = .01, .gravity = {0, -g, 0}, .substeps = 1, .biased_sweeps = pushing, .relax_sweeps = resting};
}

template <class Solve>
void expect_solution(const Problem<double>& problem, Friction kind, Solve solve) {
  System s = assemble(one_substep(0, 0), problem);
  const VectorXd friction = s.friction;
  Problem<double> pushed = problem, rested = problem;
  solve(one_substep(long_run, 0), pushed);
  solve(one_substep(long_run, long_run), rested);
  const VectorXd v_pushed = velocities(pushed.bodies.motion, problem.bodies.count);
  for (const bool resting : {false, true}) {
    s.friction = resting ? friction : VectorXd::Zero(s.points());
    const bool slides = resting && kind == Friction::slides;
    const Problem<double>& solved = resting ? rested : pushed;
    const Wanted wanted = resting ? rigid(one_substep(0, 0), s, v_pushed) : soft(one_substep(0, 0), s);
    const VectorXd p = impulses_of(solved), v = velocities(solved.bodies.motion, problem.bodies.count);
    const double drift = drift_bound(s, p, 2 * long_run, u), row = row_bound(s, drift);
    EXPECT_LE((v - s.after(p)).cwiseAbs().maxCoeff(), drift);
    EXPECT_LE(residual(s, wanted, p), row);

    const VectorXd q = pivoted(s, wanted);
    ASSERT_EQ(q.size(), p.size());
    // As in noise_of, in the speed of a row.
    const double noise = 1e-10 * (1 + q.cwiseAbs().maxCoeff()) / s.row_mass.minCoeff();
    EXPECT_LE(residual(s, wanted, q), noise);
    if (resting && kind == Friction::any) continue;
    const double contraction = slides ? contraction_of(s, s.friction.maxCoeff()) : 0;
    ASSERT_LT(contraction, 1);
    const auto tangent_terms = slides ? sliding_terms : sticking_terms;
    const double terms = normal_terms(s, wanted, p, q) + tangent_terms(s, wanted, p, q);
    // Each term is an impulse times a speed that the residuals leave, each at most twice. If a term is larger, the
    // contact does not stick.
    EXPECT_LE(terms, 4 * (p.cwiseAbs().sum() + q.cwiseAbs().sum()) * (row + noise));
    EXPECT_LE(energy(s, s.after(p) - s.after(q)), terms / (1 - contraction));
  }
  // Bodies move with the velocity at the end of the soft sweeps.
  for (const Problem<double>* i : {&pushed, &rested}) {
    VectorXd moving = velocities(i->moving, problem.bodies.count);
    for (int body = 0; body < problem.bodies.count; ++body)
      if (problem.bodies.inverse_mass[body].w == 0) moving.segment<6>(6 * body) = v_pushed.segment<6>(6 * body);
    EXPECT_LE((moving - v_pushed).cwiseAbs().maxCoeff(), 4 * u * v_pushed.cwiseAbs().maxCoeff());
  }
}

void expect_solution(const Problem<double>& problem, Friction kind) {
  expect_solution(problem, kind, solve_original<double>);
  expect_solution(problem, kind, solve_batches<double>);
}

TEST(Tangents, MakeARightHandedFrame) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 1000; ++i) {
    Eigen::Vector3d n(normal(random), normal(random), normal(random));
    if (i % 4 == 1) n[i / 4 % 3] = 0;
    if (i % 4 == 2) n = (i / 4 % 2 ? 1 : -1) * Eigen::Vector3d::Unit(i / 4 % 3);
    n.normalize();
    Vector t, b;
    make_tangents({n.x(), n.y(), n.z()}, t, b);
    Eigen::Matrix3d frame;
    frame << eigen(t), eigen(b), n;
    // Entries are sums of three products of four factors at most.
    EXPECT_LE((frame.transpose() * frame - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff(), 16 * u);
    EXPECT_NEAR(frame.determinant(), 1, 32 * u);
  }
}

TEST(ContactSolver, BoxOnTheGroundIsTheExactSolution) {
  for (const Vector& velocity : {Vector{0, -1, 0}, Vector{.2, -2, .1}}) {
    Problem<double> p;
    const int ground = add_ground(p);
    const int box =
        add_box(p, box_half, {.position = {0, box_half.y, 0}, .mass = 2, .velocity = velocity, .friction = .64});
    touch(p, ground, box, {0, 1, 0}, rectangle({0, 0, 0}, {box_half.x, 0, 0}, {0, 0, box_half.z}, -.002));
    expect_solution(p, Friction::sticks);
  }
}

TEST(ContactSolver, BoxOnASlopeIsTheExactSolution) {
  expect_solution(box_on_slope(slope, {0, -1, 0}, .8), Friction::sticks);
  for (const double friction : {0., .05, .2})
    expect_solution(box_on_slope(slope, {.1, -1, .2}, friction), Friction::any);
  expect_solution(box_on_slope(slope, {.1, -1, .2}, 0), Friction::sticks);
}

TEST(ContactSolver, StackOfThreeIsTheExactSolution) {
  for (const double friction : {0., .6}) {
    Problem<double> p;
    int below = add_ground(p);
    for (int i = 0; i < 3; ++i) {
      const double y = 2 * i * box_half.y;
      const int box = add_box(p, box_half,
                              {.position = {.1 * i, y + box_half.y, 0},
                               .mass = 1. + i,
                               .velocity = {.05 * i, -.1, 0},
                               .friction = i == 0 ? friction * friction : friction});
      touch(p, below, box, {0, 1, 0}, rectangle({.1 * i - .05, y, 0}, {.45, 0, 0}, {0, 0, .4}, -.001 * i));
      below = box;
    }
    expect_solution(p, Friction::sticks);
  }
}

TEST(ContactSolver, ThePapersFourBodiesAreTheExactSolution) {
  expect_solution(papers_bodies(.5, {0, -.1, 0}), Friction::sticks);
  expect_solution(papers_bodies(0, {.3, -.1, .2}), Friction::sticks);
  expect_solution(papers_bodies(.3, {.8, -.1, .2}), Friction::any);
}

TEST(ContactSolver, ClustersAreExactSolutions) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const bool with_static = seed % 2 == 0;
    expect_solution(cluster(10, 20, with_static, 0, seed), Friction::sticks);
    expect_solution(cluster(10, 20, with_static, .3, seed), Friction::any);
  }
}

// Spheres touch like the branches of a tree, in one point each: impulses are then unique, too, if friction is small.
TEST(ContactSolver, SlidingSpheresAreTheExactSolution) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto vector = [&] { return Vector{uniform(random), uniform(random), uniform(random)}; };
    Problem<double> p;
    constexpr double radius = .5;
    for (int i = 0; i < 12; ++i) {
      const int to = i == 0 ? 0 : random() % i;
      const Vector away = unit(vector()),
                   at = i == 0 ? Vector{0, 0, 0} : p.bodies.pose[to].position + 2 * radius * away;
      const double mass = 1 + .5 * uniform(random);
      add(p, {.position = at,
              .mass = mass,
              .inertia = .4 * mass * radius * radius * Vector{1, 1, 1},
              .velocity = 3. * vector(),
              .angular = 3. * vector()});
      if (i > 0) touch(p, to, i, away, {{at - radius * away, 0}});
    }
    const double friction = .5 / contraction_of(assemble(one_substep(0, 0), p), 1);
    std::fill(p.bodies.friction.begin(), p.bodies.friction.end(), friction);
    expect_solution(p, Friction::slides);
  }
}

// A converged run in float is a near-solution of the same problem in double. Its velocities match its impulses but for
// drift, its rows are as exact as drift allows, and its velocities are therefore as near to the exact ones as such rows
// allow.
TEST(ContactSolver, FloatIsAsGoodAsItsRounding) {
  double worst = 0, worst_bound = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const double friction = seed % 2 == 1 ? .2 : 0;
    const SolverSettings settings = one_substep(0, 200);
    Problem<float> p = convert<float>(cluster(8, 12, seed % 4 < 2, friction, seed));
    Problem<double> exact = convert<double>(p);
    const System s = assemble(settings, exact);
    const Wanted wanted = rigid(settings, s, s.before);
    solve_original(settings, p);
    const VectorXd f = impulses_of(p), v = velocities(p.bodies.motion, p.bodies.count);
    const double drift = drift_bound(s, f, settings.relax_sweeps, u_float), row = row_bound(s, drift);
    EXPECT_LE((v - s.after(f)).cwiseAbs().maxCoeff(), drift);
    EXPECT_LE(residual(s, wanted, f), row);
    if (friction > 0) continue;
    solve_original(one_substep(0, long_run), exact);
    const VectorXd d = impulses_of(exact);
    const double bound = normal_terms(s, wanted, f, d), apart = energy(s, s.after(f) - s.after(d));
    EXPECT_LE(bound, 4 * (f.cwiseAbs().sum() + d.cwiseAbs().sum()) * row);
    EXPECT_LE(apart, bound);
    worst = std::max(worst, std::sqrt(apart)), worst_bound = std::max(worst_bound, std::sqrt(bound));
  }
  RecordProperty("energy_norm", std::to_string(worst));
  RecordProperty("bound", std::to_string(worst_bound));
}

}  // namespace
}  // namespace lockstep::rigid::contacts
