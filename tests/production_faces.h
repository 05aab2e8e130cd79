// What tests of whole frames of the face share: bodies, their bones, serial frames in float or double, and the truth
// about a pose, in double.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

#include "common/production_face/make.h"
#include "common/production_face/step.h"
#include "common/production_face/update_state.h"
#include "tests/production_face_matrices.h"

namespace lockstep::production_face {

// A body, where it is, where it is to go, and the room of its frames.
template <class Real>
struct Posed {
  Face<Real> face;
  Pose<Real> pose;
  Target<Real> target;
  StepMemory<Real, linear::BlockRows<Real>> memory;
};

// Holds the nodes of which `is_held` of their places at rest is true.
template <class F>
Body<float> held_where(Body<float> body, const F& is_held) {
  for (int n = 0; n < body.nodes; ++n)
    if (is_held(convert<double>(load(body.rest, n)))) body.held.push_back(n);
  return body;
}

// Places at rest on the sides of a box from the origin.
inline auto on_box(const Vector& size) {
  return [=](const Vector& x) {
    const auto is_end = [](double at, double end) { return at == 0 || at > (1 - 1e-6) * end; };
    return is_end(x.x, size.x) || is_end(x.y, size.y) || is_end(x.z, size.z);
  };
}

// At rest, to stay there.
template <class Real>
Posed<Real> posed(const Body<float>& body, const Flesh& flesh = {}) {
  Posed<Real> p;
  if constexpr (std::is_same_v<Real, float>)
    p.face = make_face(body, flesh);
  else
    p.face = make_face(in_double(body), flesh);
  p.memory = serial::make_memory(p.face);
  p.pose.displacement.resize(body.nodes), p.pose.activation.assign(body.muscles, 0);
  p.target.held.resize(body.held.size()), p.target.activation.assign(body.muscles, 0);
  return p;
}

template <class Real>
Vector rest_of(const Posed<Real>& p, int node) {
  return convert<double>(load(p.face.body.rest, node));
}
template <class Real>
Vector place_of(const Posed<Real>& p, int node) {
  return rest_of(p, node) + convert<double>(load(p.pose.displacement, node));
}

// Bones bring the nodes they hold to `to` of their places at rest.
template <class Real, class F>
void bring_bones(const F& to, Posed<Real>& p) {
  for (std::size_t k = 0; k < p.face.body.held.size(); ++k) {
    const Vector rest = rest_of(p, p.face.body.held[k]);
    store(p.target.held, k, convert<Real>(to(rest) - rest));
  }
}

template <class Real>
const Frame& step(Posed<Real>& p, double tolerance) {
  serial::step_newton(p.face, p.target, tolerance, p.pose, p.memory);
  return p.memory.frame;
}

template <class Real>
std::vector<bool> held_nodes(const Body<Real>& body) {
  std::vector<bool> is_held(body.nodes, false);
  for (const int n : body.held) is_held[n] = true;
  return is_held;
}

// F of a tetrahedron, in double.
template <class Real>
Matrix strain_of(const Posed<Real>& p, int t) {
  const Body<Real>& body = p.face.body;
  Vector x[4], rest[4];
  for (int a = 0; a < 4; ++a) x[a] = place_of(p, body.corner.at(t, a)), rest[a] = rest_of(p, body.corner.at(t, a));
  const Vector a = rest[1] - rest[0], b = rest[2] - rest[0], c = rest[3] - rest[0];
  const double six = dot(a, cross(b, c));
  return outer(x[1] - x[0], (1 / six) * cross(b, c)) + outer(x[2] - x[0], (1 / six) * cross(c, a)) +
         outer(x[3] - x[0], (1 / six) * cross(a, b));
}

template <class Real>
Matrix stress_of(const Posed<Real>& p, int t) {
  const auto at = [&](int k) { return static_cast<double>(p.memory.strained.stress.at(t, k)); };
  return {{at(0), at(1), at(2)}, {at(3), at(4), at(5)}, {at(6), at(7), at(8)}};
}

// The least volume of a tetrahedron over that at rest.
template <class Real>
double least_volume(const Posed<Real>& p) {
  double least = std::numeric_limits<double>::infinity();
  for (int t = 0; t < p.face.body.tetrahedra; ++t) least = std::min(least, determinant(strain_of(p, t)));
  return least;
}

// What stands in `strained`, summed at all nodes, held ones included.
template <class Real>
std::vector<Vector> forces_on_nodes(const Posed<Real>& p) {
  Array<Real> force(3 * std::size_t(p.face.body.nodes));
  serial::forces(p.face.body, p.memory.strained, force);
  std::vector<Vector> all;
  for (int n = 0; n < p.face.body.nodes; ++n) all.push_back(convert<double>(at_node<Real>(force, n)));
  return all;
}

// The forces of bones on flesh: of the held nodes that `is_meant` of their places at rest is true of.
template <class Real, class F>
Vector reaction(const Posed<Real>& p, const F& is_meant) {
  const std::vector<Vector> force = forces_on_nodes(p);
  Vector sum = {0, 0, 0};
  for (const int n : p.face.body.held)
    if (is_meant(rest_of(p, n))) sum = sum - force[n];
  return sum;
}

// The step of Newton's method from a pose, by stiffness and forces in double, and |f| there.
struct Correction {
  Array<double> change;  // 3 a node, m
  double force;          // N
};

template <class Real>
Correction correction_of(const Posed<Real>& p) {
  const Body<double> body = [&] {
    if constexpr (std::is_same_v<Real, float>)
      return in_double(p.face.body);
    else
      return p.face.body;
  }();
  const Pose<double> pose = {convert<double>(p.pose.displacement), convert<double>(p.pose.activation)};
  Strained<double> strained = make_strained(body);
  serial::update_state(body, p.face.flesh, pose, false, strained);
  Array<double> force(3 * std::size_t(body.nodes)), change(force.size());
  serial::forces(body, strained, force);
  for (const int n : body.held) force[3 * n] = force[3 * n + 1] = force[3 * n + 2] = 0;
  auto k = make_block_rows<double>(p.face.pattern);
  serial::assemble(body, strained, p.face.pattern, k);
  const linear::Stop stop = {.tolerance = 1e-9, .iterations = 20000};
  EXPECT_LE(serial::solve_block_jacobi(k, force, stop, change).recursive_residual, stop.tolerance);
  double square = 0;
  for (const double f : force) square += f * f;
  return {change, std::sqrt(square)};
}

// How far free nodes are from where forces vanish, m, the farthest of them. To first order that is the correction; the
// next order is its square over the size of a tetrahedron.
template <class Real>
double error_of(const Posed<Real>& p) {
  const Correction correction = correction_of(p);
  double most = 0;
  for (int n = 0; n < p.face.body.nodes; ++n) {
    const Vector at = at_node<double>(correction.change, n);
    most = std::max(most, std::sqrt(dot(at, at)));
  }
  return most;
}

// The farthest that a node is from `to` of its place at rest.
template <class Real, class F>
double distance_from(const F& to, const Posed<Real>& p) {
  double most = 0;
  for (int n = 0; n < p.face.body.nodes; ++n) {
    const Vector off = place_of(p, n) - to(rest_of(p, n));
    most = std::max(most, std::sqrt(dot(off, off)));
  }
  return most;
}

// P of flesh along the axes of diag(along, across, across).
inline Vector axial_stress(double along, double across) {
  const Vector s = {along, across, across};
  return principal_stress(flesh_slopes(Flesh{}, s), s);
}

// The stretch at which a function that grows is 0.
template <class F>
double zero_of(const F& f, double low, double high) {
  for (int i = 0; i < 100; ++i) {
    const double middle = .5 * (low + high);
    (f(middle) < 0 ? low : high) = middle;
  }
  return low;
}

// How wide a bar with free sides is.
inline double across_of(double along) {
  return zero_of([&](double across) { return axial_stress(along, across).y; }, .3, 2);
}

}  // namespace lockstep::production_face
