// The implicit step of a cloth: its matrix against differences of forces and the damping's products, definite; its
// solution against CHOLMOD and against Newton's method; held vertices, free fall, momentum; and the serial bits.
#define EIGEN_DONT_VECTORIZE  // lanes of other widths than the rest of the program's

#include "common/production_cloth/implicit_solve.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <cstring>

#include "common/production_cloth/damping_solve.h"
#include "tests/production_cloth_newton.h"

namespace lockstep::production_cloth {
namespace {

Material without_damping(Material material) {
  material.stretch_damping = material.bend_damping = 0;
  return material;
}

// Made larger by a tenth, so that springs and membranes pull wherever `by` is small.
Vectors<double> stretched(const SmallCloth& cloth, double by) {
  Vectors<double> x = shaken(cloth.rest, cloth.topology.vertices, by);
  for (Array<double>* c : {&x.x, &x.y, &x.z})
    for (double& e : *c) e *= 1.1;
  return x;
}

// -df/dx, by differences over 2e-7 m.
Eigen::MatrixXd differences(ImplicitCloth& cloth, const Vectors<double>& x) {
  constexpr double step = 1e-7;
  Eigen::MatrixXd k(3 * cloth.vertices, 3 * cloth.vertices);
  for (int j = 0; j < 3 * cloth.vertices; ++j) {
    const auto force_at = [&](double by) {
      Vectors<double> moved = x;
      (j % 3 == 0 ? moved.x : j % 3 == 1 ? moved.y : moved.z)[j / 3] += by;
      return flat_vector(cloth.forces(moved), cloth.vertices);
    };
    k.col(j) = (force_at(-step) - force_at(step)) / (2 * step);
  }
  return k;
}

double least_eigenvalue(const Eigen::MatrixXd& a) {
  const Eigen::MatrixXd symmetric = .5 * (a + a.transpose());
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly).eigenvalues()[0];
}

// Differences over 2e-7 m of what is curved over an edge of 2 cm are off by (1e-7 / .02)^2 = 3e-11 of the stiffness,
// and forces, which are below an edge times the stiffness, round by 2^-53 of their terms: 2e-16 * .02 / 1e-7 = 4e-11,
// some dozen times. 1e-8 has room.
constexpr double of_differences = 1e-8;

// Where all springs and membranes pull, nothing is left out.
TEST(ProductionClothImplicit, StiffnessIsTheSlopeOfForcesWhereTheClothIsStretched) {
  for (const Material& material : all_materials()) {
    if (material.bend == Bend::hinges) continue;
    for (const SmallCloth& cloth : {sheet_of(3, 2, without_damping(material)), tube_of(7, 3, without_damping(material)),
                                    closed_of(without_damping(material))}) {
      ImplicitCloth c(cloth);
      const Vectors<double> x = stretched(cloth, 2e-4);
      const Eigen::MatrixXd k = c.stiffness(x, 1), slope = differences(c, x);
      EXPECT_LE((k - slope).cwiseAbs().maxCoeff(), of_differences * slope.cwiseAbs().maxCoeff())
          << int(material.stretch) << ' ' << int(material.bend);
    }
  }
}

// At rest the torque of hinges is 0, and so is what its part leaves out: on tubes and closed surfaces, which are
// folded.
TEST(ProductionClothImplicit, StiffnessOfHingesIsTheSlopeOfForcesAtRest) {
  for (const Material& material : all_materials()) {
    if (material.bend != Bend::hinges) continue;
    for (const SmallCloth& cloth : {tube_of(7, 3, without_damping(material)), closed_of(without_damping(material))}) {
      ImplicitCloth c(cloth);
      const Eigen::MatrixXd k = c.stiffness(cloth.rest, 1), slope = differences(c, cloth.rest);
      // Springs and membranes at rest are where the derivative of what pushes begins to be left out: 1e-7 m of an edge
      // of 2 cm, a share of 5e-6 of the stiffness, is on the other side.
      EXPECT_LE((k - slope).cwiseAbs().maxCoeff(), 5e-6 * slope.cwiseAbs().maxCoeff()) << int(material.stretch);
    }
  }
}

// Of crumpled cloths: K is definite, and what it leaves out of the slope of forces is negative. Hinges apart, whose
// slope is not symmetric.
TEST(ProductionClothImplicit, LeavesOutWhatIsNotDefinite) {
  for (const Material& material : all_materials())
    for (const SmallCloth& cloth : {sheet_of(3, 2, without_damping(material)), tube_of(7, 3, without_damping(material)),
                                    closed_of(without_damping(material))}) {
      ImplicitCloth c(cloth);
      const Vectors<double> x = shaken(cloth.rest, c.vertices, .007);
      const Eigen::MatrixXd k = c.stiffness(x, 1);
      const double size = k.cwiseAbs().maxCoeff(), rounding = 64 * 0x1p-53 * size * static_cast<double>(k.rows());
      EXPECT_EQ((k - k.transpose()).cwiseAbs().maxCoeff(), 0);
      EXPECT_GE(least_eigenvalue(k), -rounding) << int(material.stretch) << ' ' << int(material.bend);
      if (material.bend == Bend::hinges) continue;
      const Eigen::MatrixXd slope = differences(c, x);
      const double off = of_differences * slope.cwiseAbs().maxCoeff() * static_cast<double>(k.rows());
      EXPECT_GE(least_eigenvalue(k - slope), -off) << int(material.stretch) << ' ' << int(material.bend);
      EXPECT_GT((k - slope).norm(), 1e-3 * slope.norm()) << "this cloth pushes nowhere";
    }
}

// D is what damping_solve multiplies by: its right-hand side s (f - D v), of no force, in no iteration.
TEST(ProductionClothImplicit, DampingIsThatOfDampingSolve) {
  for (const Material& material : all_materials())
    for (const SmallCloth& cloth : {sheet_of(3, 2, material), tube_of(7, 3, material), closed_of(material)}) {
      ImplicitCloth c(cloth);
      const int n = c.vertices;
      const Vectors<double> x = shaken(cloth.rest, n, .004);
      const Eigen::MatrixXd k = ImplicitCloth({cloth.topology, cloth.rest, without_damping(material)}).stiffness(x, 1);
      constexpr double h = .01;
      const Eigen::MatrixXd d = (c.stiffness(x, h) - h * h * k) / h;
      c.forces(x);
      DampingMemory<double> memory = serial::make_damping_memory(c.elements);
      Vectors<double> none, velocity = shaken(cloth.rest, n, 1, 7);
      none.resize(n);
      const Eigen::VectorXd v = flat_vector(velocity, n);
      Changes<double> changes = make_changes<double>(n);
      serial::damping_solve(c.elements, c.state, c.mass, c.inverse_mass, 1., none, {.tolerance = 1, .iterations = 0},
                            velocity, changes, memory);
      Eigen::VectorXd expected(3 * n);
      for (int i = 0; i < 3 * n; ++i) expected[i] = -memory.b[4 * (i / 3) + i % 3];
      // Both are sums of some thirty terms of the size of D v and, before division by h, of h^2 K v.
      const double size = (d.cwiseAbs().maxCoeff() + h * k.cwiseAbs().maxCoeff()) * v.cwiseAbs().maxCoeff();
      EXPECT_LE((d * v - expected).cwiseAbs().maxCoeff(), 200 * 0x1p-53 * size)
          << int(material.stretch) << ' ' << int(material.bend);
      EXPECT_GT(expected.norm(), 0);
    }
}

struct Stepped {
  Vectors<double> velocity;
  linear::Solution solution;
};
Stepped step(ImplicitCloth& c, const Vectors<double>& x, const Vectors<double>& v, double h, double tolerance) {
  Stepped s = {v, {}};
  s.solution = serial::implicit_solve(c.elements, x, c.mass, h, c.forces(x),
                                      {.tolerance = tolerance, .iterations = 4000}, s.velocity, c.memory);
  return s;
}

// The least eigenvalue of A is at least the least mass: |x - x*| <= |b - A x| / m. CHOLMOD's own residual is some u of
// |A| |x|: 1e-13 of b is allowed for both.
TEST(ProductionClothImplicit, IsCholmodsSolution) {
  for (const Material& material : all_materials())
    for (const bool held : {false, true}) {
      const SmallCloth cloth = sheet_of(12, 9, material);
      ImplicitCloth c(cloth, [&](const Vector3<double>& at) { return held && at.x < .03; });
      const int n = c.vertices;
      const Vectors<double> x = shaken(cloth.rest, n, .004), v = shaken(cloth.rest, n, 1, 7);
      const Stepped s = step(c, x, v, 1. / 240, 1e-10);
      EXPECT_LE(s.solution.recursive_residual, 1e-10);
      const Eigen::VectorXd expected = solve_directly(c.memory.matrix, c.memory.b);
      const double least = *std::min_element(c.mass.begin(), c.mass.begin() + n);
      double b = 0, off = 0;
      for (int i = 0; i < 3 * n; ++i) {
        b += c.memory.b[i] * c.memory.b[i];
        off += (c.memory.x[i] - expected[i]) * (c.memory.x[i] - expected[i]);
        const double before = (i % 3 == 0   ? v.x
                               : i % 3 == 1 ? v.y
                                            : v.z)[i / 3],
                     after = (i % 3 == 0   ? s.velocity.x
                              : i % 3 == 1 ? s.velocity.y
                                           : s.velocity.z)[i / 3];
        if (c.inverse_mass[i / 3] == 0) {
          EXPECT_EQ(after, before);
        }
      }
      EXPECT_GT(b, 0);
      EXPECT_LE(std::sqrt(off), (1e-10 + 1e-13) * std::sqrt(b) / least) << int(material.stretch);
    }
}

// In float, by lanes: |x - x*| <= |b - A x| / lambda of the same floats, with the true residual, found in double.
TEST(ProductionClothImplicit, InFloatIsCholmodsSolutionByItsTrueResidual) {
  for (const Material& material : all_materials()) {
    const SmallCloth cloth = sheet_of(6, 5, material);
    const int n = cloth.topology.vertices;
    const Elements<float> elements = make_elements<float>(cloth.topology, cloth.rest, material);
    const Array<float> mass = convert<float>(lumped_masses(cloth.topology, cloth.rest, material.density));
    SerialImplicitMemory memory = serial::make_implicit_memory(elements, mass);
    State<float> state = serial::make_state(elements);
    const Vectors<float> x = convert<float>(shaken(cloth.rest, n, .004));
    Vectors<float> v = convert<float>(shaken(cloth.rest, n, 1, 7)), force;
    force.resize(n);
    serial::forces(elements, x, state, force);
    serial::implicit_solve(elements, x, mass, 1.f / 240, force, {.tolerance = 1e-4, .iterations = 1000}, v, memory);
    const double truth =
        linear::residual_norm(memory.matrix, std::span<const float>(memory.b), std::span<const float>(memory.x));
    const linear::BlockRows<double> a = linear::convert<double>(memory.matrix);
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3 * n, 3 * n);
    for (int i = 0; i < n; ++i)
      for (std::size_t k = a.begin[i]; k < std::size_t(a.begin[i + 1]); ++k)
        for (int e = 0; e < 9; ++e) dense(3 * i + e / 3, 3 * a.column[k] + e % 3) = a.value[9 * k + e];
    const double least = least_eigenvalue(dense);
    // Diagonals are sums of a dozen other blocks: off by 12 u |A|, beside the least mass.
    EXPECT_GE(least, *std::min_element(mass.begin(), mass.begin() + n) - 12 * 0x1p-24 * dense.cwiseAbs().maxCoeff());
    const Eigen::VectorXd expected = solve_directly(a, memory.b);
    double off = 0, b = 0;
    for (int i = 0; i < 3 * n; ++i) {
      off += (memory.x[i] - expected[i]) * (memory.x[i] - expected[i]);
      b += double(memory.b[i]) * memory.b[i];
    }
    EXPECT_LE(std::sqrt(off), (truth + 1e-13 * std::sqrt(b)) / least) << int(material.stretch);
    EXPECT_LE(truth, 2e-4 * std::sqrt(b));
  }
}

// The first step of Newton's method, from x, on |x' - x - h v|_M^2 / (2 h^2) + E(x').
TEST(ProductionClothImplicit, IsTheFirstStepOfNewtonsMethod) {
  for (const Material& material : all_materials()) {
    const SmallCloth cloth = sheet_of(7, 5, without_damping(material));
    ImplicitCloth c(cloth, [](const Vector3<double>& at) { return at.x < .01 && at.z < .01; });
    const int n = c.vertices;
    const Vectors<double> x = stretched(cloth, 2e-4);
    Vectors<double> v = shaken(cloth.rest, n, .1, 7);
    for (int i = 0; i < n; ++i)
      if (c.inverse_mass[i] == 0) store(v, i, {0, 0, 0});
    constexpr double h = 1. / 240;
    const Stepped s = step(c, x, v, h, 1e-12);
    Vectors<double> target = x, newton = x;
    for (int i = 0; i < n; ++i) store(target, i, load(x, i) + h * load(v, i));
    minimise(c, Eigen::VectorXd::Zero(3 * n), target, h, 0, 0, 1, newton);
    double size = 0, off = 0;
    for (int i = 0; i < n; ++i) {
      const Vector3<double> by_newton = load(newton, i) - load(x, i), by_step = h * load(s.velocity, i);
      const Vector3<double> d = by_newton - by_step;
      size = std::max(size, dot(by_newton, by_newton)), off = std::max(off, dot(d, d));
    }
    // Residuals of 1e-12 of b times the condition, below 1e4 here; a step that the line search shortened would be off
    // by half of it.
    EXPECT_LE(std::sqrt(off), 1e-8 * std::sqrt(size)) << int(material.stretch) << ' ' << int(material.bend);
  }
}

// The step is what is linear of backward Euler: half the time step leaves at most a quarter of the error in positions.
// Newton's method reaches the end of its road.
TEST(ProductionClothImplicit, NearsNewtonsSolutionAsStepsGetShorter) {
  for (const Material& material : all_materials()) {
    if (material.bend == Bend::hinges) continue;  // which have no potential
    const SmallCloth cloth = sheet_of(7, 5, without_damping(material));
    ImplicitCloth c(cloth);
    const int n = c.vertices;
    const Vectors<double> x = stretched(cloth, 2e-4), v = shaken(cloth.rest, n, .1, 7);
    double before = 0;
    for (const double h : {1. / 4000, 1. / 8000, 1. / 16000}) {
      const Stepped s = step(c, x, v, h, 1e-13);
      Vectors<double> target = x, newton = x;
      for (int i = 0; i < n; ++i) store(target, i, load(x, i) + h * load(v, i));
      // A gradient of m / h^2 times 1e-14 m, the rounding of positions, is 0.
      const double tolerance = c.mass[0] / (h * h) * 1e-14 * n;
      const NewtonSolution solution = minimise(c, Eigen::VectorXd::Zero(3 * n), target, h, 0, tolerance, 50, newton);
      EXPECT_LE(solution.gradient, tolerance);
      EXPECT_LE(solution.iterations, 10);
      double off = 0;
      for (int i = 0; i < n; ++i) {
        const Vector3<double> d = load(newton, i) - (load(x, i) + h * load(s.velocity, i));
        off = std::max(off, std::sqrt(dot(d, d)));
      }
      if (before > 0) {
        EXPECT_LE(off, before / 4) << int(material.stretch) << ' ' << h;
      }
      before = off;
    }
  }
}

// In one translation all differences of velocities are 0, so that no bit changes.
TEST(ProductionClothImplicit, LeavesFreeFallAlone) {
  for (const Material& material : all_materials()) {
    const SmallCloth cloth = tube_of(7, 4, material);
    ImplicitCloth c(cloth);
    const int n = c.vertices;
    Vectors<double> velocity, none;
    velocity.resize(n), none.resize(n);
    for (int i = 0; i < n; ++i) store(velocity, i, {.1, -4.7, .3});
    EXPECT_EQ(
        serial::implicit_solve(c.elements, shaken(cloth.rest, n, .004), c.mass, 1. / 60, none, {}, velocity, c.memory)
            .iterations,
        0);
    for (int i = 0; i < n; ++i) EXPECT_TRUE(velocity.x[i] == .1 && velocity.y[i] == -4.7 && velocity.z[i] == .3);
  }
}

// Rows of A - M sum to 0, and so do columns: the momentum's change is the sum of b, which is that of forces, and the
// residual, 1e-12 of b by the root of the vertices.
TEST(ProductionClothImplicit, KeepsMomentum) {
  for (const Material& material : all_materials()) {
    const SmallCloth cloth = sheet_of(6, 5, material);
    ImplicitCloth c(cloth);
    const int n = c.vertices;
    const Vectors<double> x = shaken(cloth.rest, n, .004), v = shaken(cloth.rest, n, 1, 7);
    const Stepped s = step(c, x, v, 1. / 60, 1e-12);
    Vector3<double> change = {0, 0, 0};
    double b = 0;
    for (int i = 0; i < n; ++i) change = change + c.mass[i] * (load(s.velocity, i) - load(v, i));
    for (const double e : c.memory.b) b += e * e;
    EXPECT_LE(std::sqrt(dot(change, change)), 2e-12 * std::sqrt(b) * std::sqrt(3. * n)) << int(material.stretch);
  }
}

// An inverse of a block, against Eigen's in double: its error is below 16 u times the condition squared, and it is
// definite where rounding leaves the block's own pivots below 0, too.
TEST(ProductionClothImplicit, InvertsDefiniteBlocks) {
  std::mt19937 random(3);
  const auto number = [&] { return 2 * static_cast<double>(random() >> 8) / (1 << 24) - 1; };
  for (const double mass : {1., 1e-2, 1e-6, 1e-9})
    for (int n = 0; n < 1000; ++n) {
      Eigen::Matrix3d g;
      for (int i = 0; i < 9; ++i) g(i / 3, i % 3) = number();
      if (n % 2 == 1) g.col(2) = g.col(1) = g.col(0);
      const Eigen::Matrix3d exact = g * g.transpose() + mass * Eigen::Matrix3d::Identity();
      Block<float> block;
      Eigen::Matrix3d a;
      for (int i = 0; i < 9; ++i) {
        block.e[i] = static_cast<float>(exact(i / 3, i % 3));
        a(i / 3, i % 3) = block.e[i];
      }
      const Block<float> found = inverse_of_definite(block);
      Eigen::Matrix3d inverse;
      for (int i = 0; i < 9; ++i) inverse(i / 3, i % 3) = found.e[i];
      EXPECT_EQ(inverse, inverse.transpose());
      EXPECT_GT(least_eigenvalue(inverse), 0) << mass;
      const double condition = exact.norm() * exact.inverse().norm();
      if (condition < 1e4) {
        EXPECT_LE((inverse - a.inverse()).norm(), 16 * 0x1p-24 * condition * a.inverse().norm()) << condition;
      }
    }
}

}  // namespace
}  // namespace lockstep::production_cloth
