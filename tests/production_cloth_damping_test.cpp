// The implicit damping of a cloth: what D is, against a dense solve, held vertices, rigid motions; and the serial bits.
#define EIGEN_DONT_VECTORIZE  // lanes of other widths than the rest of the program's

#include "common/production_cloth/damping_solve.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cstring>
#include <eigen3/Eigen/Dense>

#include "tests/production_cloths.h"

namespace lockstep::production_cloth {
namespace {

using Vector = Vector3<double>;

// A deformed cloth in double, with its masses, of which the first `held` vertices are held.
struct DampedCloth {
  Elements<double> elements;
  State<double> state;
  Vectors<double> position, force;
  Array<double> mass, inverse_mass;
  Changes<double> changes;
  DampingMemory<double> memory;

  DampedCloth(const SmallCloth& cloth, double shake, int held)
      : elements(make_elements<double>(cloth.topology, cloth.rest, cloth.material)),
        state(serial::make_state(elements)),
        position(shaken(cloth.rest, cloth.topology.vertices, shake)),
        mass(lumped_masses(cloth.topology, cloth.rest, cloth.material.density)),
        inverse_mass(mass.size()),
        changes(make_changes<double>(cloth.topology.vertices)),
        memory(serial::make_damping_memory(elements)) {
    force.resize(elements.vertices);
    serial::forces(elements, position, state, force);
    for (int i = held; i < elements.vertices; ++i) inverse_mass[i] = 1 / mass[i];
  }

  linear::Solution solve(double half_step, const linear::Stop& stop, Vectors<double>& velocity) {
    return serial::damping_solve(elements, state, mass, inverse_mass, half_step, force, stop, velocity, changes,
                                 memory);
  }

  // D v, by the right-hand side s (f - D v) of no iteration.
  Eigen::VectorXd damp(const Eigen::VectorXd& v) {
    Vectors<double> velocity, none;
    velocity.resize(elements.vertices), none.resize(elements.vertices);
    for (int i = 0; i < elements.vertices; ++i) store(velocity, i, {v[3 * i], v[3 * i + 1], v[3 * i + 2]});
    const Array<double> free(mass.size(), 1);
    Changes<double> no_guess = make_changes<double>(elements.vertices);
    serial::damping_solve(elements, state, mass, free, 1., none, {.tolerance = 1, .iterations = 0}, velocity, no_guess,
                          memory);
    Eigen::VectorXd result(v.size());
    for (int i = 0; i < v.size(); ++i) result[i] = -memory.b[4 * (i / 3) + i % 3];
    return result;
  }
  Eigen::MatrixXd matrix() {
    const int n = 3 * elements.vertices;
    Eigen::MatrixXd d(n, n);
    for (int i = 0; i < n; ++i) d.col(i) = damp(Eigen::VectorXd::Unit(n, i));
    return d;
  }
};

Eigen::VectorXd flat(const Vectors<double>& v, int vertices) {
  Eigen::VectorXd result(3 * vertices);
  for (int i = 0; i < vertices; ++i) result.segment<3>(3 * i) << v.x[i], v.y[i], v.z[i];
  return result;
}

// m/s.
Vectors<double> some_velocities(int vertices, unsigned seed = 7) {
  Vectors<double> none;
  none.resize(vertices);
  return shaken(none, vertices, 1, seed);
}

// Of vertices that are not among the first `held`.
Changes<double> some_changes(int vertices, int held) {
  Changes<double> changes = make_changes<double>(vertices);
  const Vectors<double> last = some_velocities(vertices, 8), before = some_velocities(vertices, 9);
  for (int i = held; i < vertices; ++i) {
    const Vector a = load(last, i), b = load(before, i);
    changes.last[4 * i] = a.x, changes.last[4 * i + 1] = a.y, changes.last[4 * i + 2] = a.z;
    changes.before[4 * i] = b.x, changes.before[4 * i + 1] = b.y, changes.before[4 * i + 2] = b.z;
  }
  changes.weight = {.75, -.5};
  return changes;
}

std::vector<SmallCloth> damped_cloths(const Material& material) {
  return {sheet_of(3, 2, material), tube_of(7, 3, material), closed_of(material)};
}

// Entries are sums of up to 12 products and two sums of differences: 32 u of the largest.
TEST(ProductionClothDamping, IsSymmetricAndDissipates) {
  for (const Material& material : all_materials())
    for (const SmallCloth& cloth : damped_cloths(material)) {
      const Eigen::MatrixXd d = DampedCloth(cloth, .004, 0).matrix();
      const double size = d.cwiseAbs().maxCoeff(), u = 0x1p-53;
      EXPECT_LE((d - d.transpose()).cwiseAbs().maxCoeff(), 32 * u * size);
      const double least = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(d, Eigen::EigenvaluesOnly).eigenvalues()[0];
      EXPECT_GE(least, -32 * u * size * static_cast<double>(d.rows()));
      EXPECT_GT(size, 0);
    }
}

// Velocities a + w x r. Quadratic bending, which is flat at rest, damps turns of what is bent: those are left out.
TEST(ProductionClothDamping, IsNotThereInRigidMotions) {
  for (const Material& material : all_materials())
    for (const SmallCloth& cloth : damped_cloths(material)) {
      DampedCloth damped(cloth, .004, 0);
      const int n = damped.elements.vertices;
      const double size = damped.matrix().cwiseAbs().maxCoeff();
      for (const Vector& turn : {Vector{0, 0, 0}, Vector{3, -1, 2}}) {
        if (material.bend == Bend::quadratic && turn.x != 0) continue;
        Eigen::VectorXd v(3 * n);
        for (int i = 0; i < n; ++i) {
          const Vector at = Vector{1, 2, -3} + cross(turn, load(damped.position, i));
          v.segment<3>(3 * i) << at.x, at.y, at.z;
        }
        EXPECT_LE(damped.damp(v).cwiseAbs().maxCoeff(), 200 * 0x1p-53 * 4 * size) << int(material.stretch);
      }
    }
}

// At rest, membranes' and quadratic bending's D is beta times the stiffness: forces of a small displacement. The
// displacement is a hundred-thousandth of an edge, and so is what is not linear, times 3.
TEST(ProductionClothDamping, IsStiffnessAtRest) {
  for (const Material& material : all_materials()) {
    if (material.stretch == Stretch::springs || material.bend == Bend::hinges) continue;
    const SmallCloth cloth = sheet_of(4, 3, material);
    const int n = cloth.topology.vertices;
    DampedCloth damped(cloth, 0, 0);
    const Eigen::VectorXd v = flat(some_velocities(n), n), at_rest = flat(damped.force, n);
    constexpr double step = 2e-7;
    Vectors<double> moved = cloth.rest;
    for (int i = 0; i < n; ++i) store(moved, i, load(moved, i) + step * Vector{v[3 * i], v[3 * i + 1], v[3 * i + 2]});
    serial::forces(damped.elements, moved, damped.state, damped.force);
    const Eigen::VectorXd stiffness = (at_rest - flat(damped.force, n)) / step;
    const Eigen::VectorXd damping = DampedCloth(cloth, 0, 0).damp(v) / 1e-3;
    EXPECT_LE((damping - stiffness).norm(), 1e-4 * stiffness.norm()) << int(material.stretch);
  }
}

// Power of springs and hinges from the mesh alone: shares of critical damping times squares of rates, found by
// differences of positions. Rates are off by about the step over an edge, 1e-7 / .01.
TEST(ProductionClothDamping, TakesSharesOfCriticalDamping) {
  const Material material = {
      .stiffness = 3, .stretch_damping = .2, .bend = Bend::hinges, .bending = 1e-4, .bend_damping = .3};
  const SmallCloth cloth = tube_of(7, 3, material);
  const int n = cloth.topology.vertices;
  DampedCloth damped(cloth, .004, 0);
  const Vectors<double> v = some_velocities(n);
  constexpr double step = 1e-7;
  const auto at = [&](int i, double time) { return load(damped.position, i) + time * load(v, i); };
  const auto length = [](const Vector& d) { return std::sqrt(dot(d, d)); };
  double power = 0;
  for (const auto& [a, b] : cloth.topology.edges) {
    const double rate = (length(at(b, step) - at(a, step)) - length(at(b, -step) - at(a, -step))) / (2 * step);
    const double rest = length(load(cloth.rest, b) - load(cloth.rest, a)),
                 m = 1 / (1 / damped.mass[a] + 1 / damped.mass[b]);
    power += .2 * 2 * std::sqrt(3 * rest * m) / rest * rate * rate;
  }
  for (const auto& h : cloth.topology.hinges) {
    const auto theta = [&](double time) {
      return 2 * std::asin(fold_of(at(h[0], time), at(h[1], time), at(h[2], time), at(h[3], time)).sine);
    };
    const double rate = (theta(step) - theta(-step)) / (2 * step);
    const Fold<double> rest =
        fold_of(load(cloth.rest, h[0]), load(cloth.rest, h[1]), load(cloth.rest, h[2]), load(cloth.rest, h[3]));
    double inverse = 0;
    for (int c = 0; c < 4; ++c) inverse += dot(rest.slope[c], rest.slope[c]) / damped.mass[h[c]];
    power += .3 * 2 * std::sqrt(.5 * 1e-4 * rest.shape / inverse) * rate * rate;
  }
  const Eigen::VectorXd flat_v = flat(v, n);
  EXPECT_NEAR(flat_v.dot(damped.damp(flat_v)), power, 1e-5 * power);
}

// (M + s D) (v' - v) = s (f - D v) for free vertices, by Cholesky, from any guess. The residual, 1e-12 of the
// right-hand side, is at most that by the condition: A's least eigenvalue is the least mass.
TEST(ProductionClothDamping, SolvesWhatADenseSolveDoes) {
  for (const Material& material : all_materials())
    for (const SmallCloth& cloth : damped_cloths(material))
      for (const int held : {0, 1, 2, 3}) {
        DampedCloth damped(cloth, .004, held);
        const int n = damped.elements.vertices;
        const Eigen::MatrixXd d = damped.matrix();
        if (held % 2) damped.changes = some_changes(n, held);
        Vectors<double> velocity = some_velocities(n);
        const Eigen::VectorXd before = flat(velocity, n);
        constexpr double s = 1e-3;
        const linear::Solution solution = damped.solve(s, {.tolerance = 1e-12, .iterations = 1000}, velocity);
        EXPECT_LE(solution.recursive_residual, 1e-12);
        const int free = 3 * (n - held);
        Eigen::MatrixXd a = s * d.bottomRightCorner(free, free);
        for (int i = 0; i < free; ++i) a(i, i) += damped.mass[held + i / 3];
        const Eigen::VectorXd b = s * (flat(damped.force, n) - d * before).tail(free);
        const Eigen::VectorXd expected = before.tail(free) + a.llt().solve(b), found = flat(velocity, n);
        const double least = *std::min_element(damped.mass.begin(), damped.mass.begin() + n);
        EXPECT_LE((found.tail(free) - expected).norm(), 4e-12 * b.norm() / least) << int(material.stretch);
        EXPECT_EQ((found - before).head(3 * held).cwiseAbs().sum(), 0) << "held vertices keep their velocity";
      }
}

// Whatever its length and its sign, a guess along the solution leaves nothing to solve. Changes of which each is the
// same sum of the two before are guessed exactly.
TEST(ProductionClothDamping, TakesNoIterationFromTheSolution) {
  for (const Material& material : all_materials()) {
    DampedCloth damped(sheet_of(6, 5, material), .004, 2);
    const int n = damped.elements.vertices;
    const Vectors<double> v = some_velocities(n);
    const linear::Stop exact = {.tolerance = 1e-13, .iterations = 1000};
    Vectors<double> expected = v;
    EXPECT_GT(damped.solve(1e-3, exact, expected).iterations, 3);
    damped.changes.weight = {-3, 0};
    Vectors<double> found = v;
    EXPECT_EQ(damped.solve(1e-3, {.tolerance = 1e-9, .iterations = 1000}, found).iterations, 0);
    EXPECT_LE((flat(found, n) - flat(expected, n)).norm(), 1e-9 * flat(expected, n).norm());

    // Without forces, changes are linear in velocities: those of v, 2 v + w, 3 v + 2 w, 4 v + 3 w are each twice the
    // last less the one before.
    for (Array<double>* c : {&damped.force.x, &damped.force.y, &damped.force.z}) std::ranges::fill(*c, 0.);
    damped.changes = make_changes<double>(n);
    const Vectors<double> w = some_velocities(n, 5);
    for (int k = 0; k < 4; ++k) {
      Vectors<double> sum = v;
      for (int i = 0; i < n; ++i) store(sum, i, (k + 1.) * load(v, i) + double(k) * load(w, i));
      const int iterations = damped.solve(1e-3, k < 3 ? exact : linear::Stop{1e-8, 1000}, sum).iterations;
      if (k < 3) continue;
      EXPECT_EQ(iterations, 0) << int(material.stretch) << ' ' << int(material.bend);
    }
    EXPECT_NEAR(damped.changes.weight[0], 2, 1e-6);
    EXPECT_NEAR(damped.changes.weight[1], -1, 1e-6);
  }
}

TEST(ProductionClothDamping, TakesKineticEnergyAndNoMomentum) {
  for (const Material& material : all_materials()) {
    const SmallCloth cloth = sheet_of(6, 5, material);
    DampedCloth damped(cloth, .004, 0);
    const int n = damped.elements.vertices;
    for (Array<double>* c : {&damped.force.x, &damped.force.y, &damped.force.z}) std::ranges::fill(*c, 0.);
    Vectors<double> velocity = some_velocities(n);
    const auto sums = [&] {
      double energy = 0, size = 0;
      Vector momentum = {0, 0, 0};
      for (int i = 0; i < n; ++i) {
        const Vector v = load(velocity, i);
        energy += .5 * damped.mass[i] * dot(v, v), size += damped.mass[i] * std::sqrt(dot(v, v));
        momentum = momentum + damped.mass[i] * v;
      }
      return std::tuple(energy, momentum, size);
    };
    const auto [energy, momentum, size] = sums();
    damped.solve(1e-3, {.tolerance = 1e-13, .iterations = 1000}, velocity);
    const auto [energy_after, momentum_after, size_after] = sums();
    EXPECT_LE(energy_after, energy);
    const Vector change = momentum_after - momentum;
    EXPECT_LE(std::sqrt(dot(change, change)), 1e-11 * size) << int(material.stretch);
  }
}

// In one translation all differences are 0, so that no bit changes.
TEST(ProductionClothDamping, LeavesFreeFallAlone) {
  for (const Material& material : all_materials()) {
    DampedCloth damped(sheet_of(4, 3, material), .004, 0);
    const int n = damped.elements.vertices;
    for (Array<double>* c : {&damped.force.x, &damped.force.y, &damped.force.z}) std::ranges::fill(*c, 0.);
    Vectors<double> velocity;
    velocity.resize(n);
    for (int i = 0; i < n; ++i) store(velocity, i, {.1, -4.7, .3});
    damped.changes = some_changes(n, 0);
    EXPECT_EQ(damped.solve(1e-3, {.tolerance = 1e-2, .iterations = 10}, velocity).iterations, 0);
    for (int i = 0; i < n; ++i) EXPECT_TRUE(velocity.x[i] == .1 && velocity.y[i] == -4.7 && velocity.z[i] == .3);
  }
}

TEST(ProductionClothDamping, LanesHaveTheSerialBitsAtEverySizeAndThreadCount) {
  for (const Material& material : all_materials())
    for (const SmallCloth& cloth :
         {sheet_of(1, 1, material), sheet_of(4, 2, material), sheet_of(3, 3, material), tube_of(3, 4, material),
          tube_of(16, 2, material), closed_of(material), sheet_of(20, 33, material)}) {
      const int n = cloth.topology.vertices;
      const Elements<float> elements = make_elements<float>(cloth.topology, cloth.rest, material);
      const Vectors<float> x = convert<float>(shaken(cloth.rest, n, .004)), v = convert<float>(some_velocities(n));
      const Array<float> mass = convert<float>(lumped_masses(cloth.topology, cloth.rest, material.density));
      Array<float> inverse_mass(mass.size());
      for (int i = 0; i < n; ++i) inverse_mass[i] = i % 7 == 3 ? 0 : 1 / mass[i];
      Vectors<float> force;
      force.resize(n);
      const linear::Stop stop = {.tolerance = 1e-4, .iterations = 9};
      const auto solved = [&](auto& make_state, auto& forces, auto& make_memory, auto& solve) {
        State<float> state = make_state(elements);
        forces(elements, x, state, force);
        DampingMemory<float> memory = make_memory(elements);
        Changes<float> changes = make_changes<float>(n);
        Vectors<float> velocity = v;  // three solves: guesses from nothing, from one change, from two
        for (int k = 0; k < 3; ++k)
          solve(elements, state, mass, inverse_mass, .004f, force, stop, velocity, changes, memory);
        return velocity;
      };
      using MakeState = State<float>(const Elements<float>&);
      using MakeMemory = DampingMemory<float>(const Elements<float>&);
      MakeState& serial_state = serial::make_state;
      MakeMemory& serial_memory = serial::make_damping_memory;
      Forces<float>& serial_forces = serial::forces;
      DampingSolve<float>& serial_solve = serial::damping_solve;
      const Vectors<float> expected = solved(serial_state, serial_forces, serial_memory, serial_solve);
      for (const int threads : {1, 2, 3, 4, 8}) {
        omp_set_num_threads(threads);
        const Vectors<float> found =
            solved(openmp::make_state, openmp::forces, openmp::make_damping_memory, openmp::damping_solve);
        const auto same = [&](const Array<float>& a, const Array<float>& b) {
          return std::memcmp(a.data(), b.data(), 4 * n) == 0;
        };
        ASSERT_TRUE(same(found.x, expected.x) && same(found.y, expected.y) && same(found.z, expected.z))
            << n << ' ' << threads << ' ' << int(material.stretch) << ' ' << int(material.bend);
      }
    }
  omp_set_num_threads(1);
}

}  // namespace
}  // namespace lockstep::production_cloth
