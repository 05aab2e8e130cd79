// Systems of implicit steps in double, and Newton's method with CHOLMOD: oracles.
#pragma once
#ifndef EIGEN_DONT_VECTORIZE
#define EIGEN_DONT_VECTORIZE  // lanes of other widths than the rest of the program's
#endif

#include <algorithm>
#include <cmath>
#include <eigen3/Eigen/Dense>

#include "common/production_cloth/forces.h"
#include "common/production_cloth/implicit_solve.h"
#include "tests/linear_cholmod.h"
#include "tests/production_cloths.h"

namespace lockstep::production_cloth {

inline Eigen::VectorXd flat_vector(const Vectors<double>& v, int vertices) {
  Eigen::VectorXd result(3 * vertices);
  for (int i = 0; i < vertices; ++i) result.segment<3>(3 * i) << v.x[i], v.y[i], v.z[i];
  return result;
}

// A cloth in double, of which the vertices that `is_held` names by their places at rest are held.
struct ImplicitCloth {
  using Memory = ImplicitMemory<double, linear::BlockRows<double>>;

  int vertices;
  Elements<double> elements;
  Array<double> mass, inverse_mass;
  State<double> state;
  Memory memory;

  template <class IsHeld>
  ImplicitCloth(const SmallCloth& cloth, const IsHeld& is_held)
      : vertices(cloth.topology.vertices),
        elements(make_elements<double>(cloth.topology, cloth.rest, cloth.material)),
        mass(lumped_masses(cloth.topology, cloth.rest, cloth.material.density)),
        inverse_mass(mass.size()),
        state(serial::make_state(elements)) {
    for (int i = 0; i < vertices; ++i) inverse_mass[i] = is_held(load(cloth.rest, i)) ? 0 : 1 / mass[i];
    memory = serial::make_implicit_memory(elements, inverse_mass);
  }
  explicit ImplicitCloth(const SmallCloth& cloth) : ImplicitCloth(cloth, [](const auto&) { return false; }) {}

  Vectors<double> forces(const Vectors<double>& x) {
    Vectors<double> force;
    force.resize(vertices);
    serial::forces(elements, x, state, force);
    return force;
  }

  // M + h D + h^2 K; `masses` in place of the cloth's.
  const linear::BlockRows<double>& assemble(const Vectors<double>& x, double h, const Array<double>& masses) {
    serial::assemble(elements, x, masses, h, memory);
    return memory.matrix;
  }
  // h D + h^2 K, dense.
  Eigen::MatrixXd stiffness(const Vectors<double>& x, double h) {
    const linear::BlockRows<double>& a = assemble(x, h, Array<double>(mass.size(), 0.));
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3 * vertices, 3 * vertices);
    for (int i = 0; i < a.rows; ++i)
      for (std::size_t k = a.begin[i]; k < std::size_t(a.begin[i + 1]); ++k)
        for (int e = 0; e < 9; ++e) dense(3 * i + e / 3, 3 * a.column[k] + e % 3) = a.value[9 * k + e];
    return dense;
  }
};

// The rows and columns of free vertices alone: those whose rows are not empty.
template <class Real>
linear::BlockRows<double> of_free_vertices(const linear::BlockRows<Real>& a) {
  Array<std::int32_t> number;
  int free = 0;
  for (int i = 0; i < a.rows; ++i) number.push_back(a.begin[i] < a.begin[i + 1] ? free++ : -1);
  linear::BlockRows<double> result;
  result.rows = result.columns = free;
  for (int i = 0; i < a.rows; ++i) {
    if (number[i] < 0) continue;
    for (std::size_t k = a.begin[i]; k < std::size_t(a.begin[i + 1]); ++k) {
      if (number[a.column[k]] < 0) continue;
      result.column.push_back(number[a.column[k]]);
      result.value.insert(result.value.end(), &a.value[9 * k], &a.value[9 * k] + 9);
    }
    result.begin.push_back(static_cast<std::int32_t>(result.column.size()));
  }
  return result;
}

// x of A x = b by CHOLMOD, 0 at held vertices.
template <class Real, class B>
Eigen::VectorXd solve_directly(const linear::BlockRows<Real>& a, const B& b) {
  Array<double> of_free;
  for (int i = 0; i < a.rows; ++i)
    for (int c = 0; c < 3; ++c)
      if (a.begin[i] < a.begin[i + 1]) of_free.push_back(b[3 * i + c]);
  const Array<double> x = linear::DirectSolver(linear::scalar_rows(of_free_vertices(a)))(of_free);
  Eigen::VectorXd result = Eigen::VectorXd::Zero(3 * a.rows);
  auto next = x.begin();
  for (int i = 0; i < a.rows; ++i)
    for (int c = 0; c < 3; ++c)
      if (a.begin[i] < a.begin[i + 1]) result[3 * i + c] = *next++;
  return result;
}

struct NewtonSolution {
  int iterations;
  double gradient;  // in the 2-norm
};

// Minimises E(x) - load . x + |x - target|_M^2 / (2 h^2) over the free vertices; without the last term where h is 0.
// `shift` times M is added to the Hessian, which changes the way, not the minimum. A step is halved until the slope
// along it is less than nine tenths of what it was. Stops where the gradient is at most `tolerance`.
inline NewtonSolution minimise(ImplicitCloth& cloth, const Eigen::VectorXd& load, const Vectors<double>& target,
                               double h, double shift, double tolerance, int most, Vectors<double>& x) {
  const int n = cloth.vertices;
  const double inertia = h > 0 ? 1 / (h * h) : 0;
  const auto gradient_at = [&](const Vectors<double>& at) {
    Eigen::VectorXd g = -load - flat_vector(cloth.forces(at), n);
    for (int i = 0; i < 3 * n; ++i) {
      if (inertia > 0)
        g[i] += inertia * cloth.mass[i / 3] *
                ((i % 3 == 0   ? at.x
                  : i % 3 == 1 ? at.y
                               : at.z)[i / 3] -
                 (i % 3 == 0   ? target.x
                  : i % 3 == 1 ? target.y
                               : target.z)[i / 3]);
      if (cloth.inverse_mass[i / 3] == 0) g[i] = 0;
    }
    return g;
  };
  Eigen::VectorXd g = gradient_at(x);
  NewtonSolution solution = {0, g.norm()};
  while (!(solution.gradient <= tolerance) && solution.iterations < most) {
    Array<double> weights(cloth.mass);
    for (double& w : weights) w *= inertia + shift;
    const Eigen::VectorXd step = -solve_directly(cloth.assemble(x, 1, weights), g);
    const double slope = g.dot(step);
    Vectors<double> moved = x;
    for (double share = 1; share > 1e-6; share /= 2) {
      for (int i = 0; i < n; ++i)
        store(moved, i, lockstep::load(x, i) + share * Vector3<double>{step[3 * i], step[3 * i + 1], step[3 * i + 2]});
      g = gradient_at(moved);
      if (std::abs(g.dot(step)) <= .9 * std::abs(slope)) break;
    }
    x = moved;
    ++solution.iterations, solution.gradient = g.norm();
  }
  return solution;
}

}  // namespace lockstep::production_cloth
