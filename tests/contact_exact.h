// The contacts of one substep as a dense linear complementarity problem, its solution by pivoting (tests/lcp.h), and bounds on what the
// iterative solver's result may differ by. Only the contracts and the tangents, along which friction is bounded, are the solver's own.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "common/convert.h"
#include "common/rigid/contact_row.h"
#include "tests/contact_problems.h"
#include "tests/lcp.h"

namespace lockstep::rigid::contacts {

using Eigen::MatrixXd, Eigen::VectorXd;

inline Eigen::Vector3d eigen(const Vector& v) { return {v.x, v.y, v.z}; }
inline Eigen::Quaterniond eigen(const Quaternion<double>& q) { return {q.w, q.x, q.y, q.z}; }

// Velocities are six numbers a body, impulses three a point: along normal, tangent, bitangent. v = before + inverse_mass J^T p.
struct System {
  MatrixXd inverse_mass, jacobian;
  VectorXd before;      // [6 body]: with gravity
  VectorXd separation;  // [point], m
  VectorXd friction;    // [point]
  VectorXd row_mass;    // [row]: 1 / (J M^-1 J^T), kg

  int points() const { return static_cast<int>(separation.size()); }
  VectorXd after(const VectorXd& impulses) const { return before + inverse_mass * (jacobian.transpose() * impulses); }
};

// What normals ask for: 0 <= p perpendicular to n . v + target + compliance p >= 0.
struct Wanted {
  VectorXd target, compliance;  // [point]: m/s, 1/kg
};

template <class Real>
VectorXd velocities(const Array<Motion<Real>>& motion, int count) {
  VectorXd v(6 * count);
  for (int i = 0; i < count; ++i) {
    v.segment<3>(6 * i) = eigen(lockstep::convert<double>(motion[i].velocity));
    v.segment<3>(6 * i + 3) = eigen(lockstep::convert<double>(motion[i].angular_velocity));
  }
  return v;
}

template <class Real>
VectorXd impulses_of(const Problem<Real>& p) {
  std::vector<double> all;
  for (std::size_t k = 0; k < p.manifolds.size(); ++k)
    for (int i = 0; i < p.manifolds[k].count; ++i)
      for (const auto* row : {p.impulses[k].normal, p.impulses[k].tangent, p.impulses[k].bitangent}) all.push_back(row[i]);
  return Eigen::Map<VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

// Of the first substep.
inline System assemble(const SolverSettings& settings, const Problem<double>& p) {
  const Bodies<double>& b = p.bodies;
  int points = 0;
  for (const Manifold<double>& m : p.manifolds) points += m.count;
  System s;
  s.before = velocities(b.motion, b.count);
  s.inverse_mass = MatrixXd::Zero(6 * b.count, 6 * b.count);
  for (int i = 0; i < b.count; ++i) {
    const Quaternion<double>& q = b.pose[i].orientation;
    const Eigen::Matrix3d r = Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
    const Quad<double>& inverse = b.inverse_mass[i];
    s.inverse_mass.block<3, 3>(6 * i, 6 * i) = inverse.w * Eigen::Matrix3d::Identity();
    s.inverse_mass.block<3, 3>(6 * i + 3, 6 * i + 3) = r * Eigen::Vector3d(inverse.x, inverse.y, inverse.z).asDiagonal() * r.transpose();
    if (inverse.w > 0) s.before.segment<3>(6 * i) += settings.time_step / settings.substeps * eigen(settings.gravity);
  }
  s.jacobian = MatrixXd::Zero(3 * points, 6 * b.count);
  s.separation.resize(points), s.friction.resize(points);
  int k = 0;
  for (const Manifold<double>& m : p.manifolds) {
    const int ba = p.body[m.a], bb = p.body[m.b];
    Vector direction[3] = {m.normal, {}, {}};
    make_tangents(m.normal, direction[1], direction[2]);
    for (int i = 0; i < m.count; ++i, ++k) {
      for (int d = 0; d < 3; ++d) {
        const Eigen::Vector3d along = eigen(direction[d]);
        const auto arm = [&](int body) { return Eigen::Vector3d(eigen(m.point[i].position) - eigen(b.pose[body].position)); };
        s.jacobian.block<1, 3>(3 * k + d, 6 * ba) -= along.transpose();
        s.jacobian.block<1, 3>(3 * k + d, 6 * ba + 3) -= arm(ba).cross(along).transpose();
        s.jacobian.block<1, 3>(3 * k + d, 6 * bb) += along.transpose();
        s.jacobian.block<1, 3>(3 * k + d, 6 * bb + 3) += arm(bb).cross(along).transpose();
      }
      s.separation(k) = m.point[i].separation;
      s.friction(k) = std::sqrt(b.friction[ba] * b.friction[bb]);
    }
  }
  s.row_mass = (s.jacobian * s.inverse_mass * s.jacobian.transpose()).diagonal().cwiseInverse();
  return s;
}

// Apart, the surface may be reached. Else a spring and a damper push, of stiffness k = m w^2 and damping d = 2 m z w, with the force that
// they have at the end of the substep: p = -h (k (s + h n.v) + d n.v), which is n.v + s k / (d + h k) + p / (h (d + h k)) = 0.
inline Wanted soft(const SolverSettings& settings, const System& s) {
  const double h = settings.time_step / settings.substeps, w = 2 * std::numbers::pi * std::min(settings.hertz, .25 / h);
  Wanted wanted{VectorXd::Zero(s.points()), VectorXd::Zero(s.points())};
  for (int i = 0; i < s.points(); ++i) {
    const double mass = s.row_mass(3 * i), k = mass * w * w, d = 2 * mass * settings.damping * w;
    if (s.separation(i) > 0) {
      wanted.target(i) = s.separation(i) / h;
    } else {
      wanted.target(i) = std::max(s.separation(i) * k / (d + h * k), -settings.max_bias_velocity);
      wanted.compliance(i) = 1 / (h * (d + h * k));
    }
  }
  return wanted;
}

// After bodies have moved with v for a substep; static ones stay, whatever velocity they are said to have.
inline Wanted rigid(const SolverSettings& settings, const System& s, const VectorXd& v) {
  const double h = settings.time_step / settings.substeps;
  const VectorXd speed = s.jacobian * (s.inverse_mass.diagonal().array() > 0).select(v, 0);
  Wanted wanted{VectorXd::Zero(s.points()), VectorXd::Zero(s.points())};
  for (int i = 0; i < s.points(); ++i) wanted.target(i) = std::max(s.separation(i) / h + speed(3 * i), 0.);
  return wanted;
}

// What the problem sets perpendicular to the impulses along normals, and the speeds along tangents.
inline VectorXd gaps(const System& s, const Wanted& wanted, const VectorXd& p) {
  VectorXd w = s.jacobian * s.after(p);
  for (int k = 0; k < s.points(); ++k) w(3 * k) += wanted.target(k) + wanted.compliance(k) * p(3 * k);
  return w;
}

// Impulses by Lemke's algorithm; empty where it finds none. Of a point with friction, seven variables: along the normal; along one way,
// along the other, and a slack, the sliding speed, for each tangent. Without friction anywhere the normals alone.
inline VectorXd pivoted(const System& s, const Wanted& wanted) {
  const int points = s.points(), each = s.friction.maxCoeff() > 0 ? 7 : 1;
  MatrixXd to_impulses = MatrixXd::Zero(3 * points, each * points), m = MatrixXd::Zero(each * points, each * points);
  VectorXd offset = VectorXd::Zero(each * points);
  for (int k = 0; k < points; ++k) {
    const int normal = each * k;
    to_impulses(3 * k, normal) = 1;
    offset(normal) = wanted.target(k);
    m(normal, normal) = wanted.compliance(k);
    for (int tangent = 1; each == 7 && tangent <= 2; ++tangent) {
      const int forth = normal + 3 * tangent - 2, back = forth + 1, slack = forth + 2;
      to_impulses(3 * k + tangent, forth) = 1, to_impulses(3 * k + tangent, back) = -1;
      m(forth, slack) = m(back, slack) = 1;
      m(slack, normal) = s.friction(k), m(slack, forth) = m(slack, back) = -1;
    }
  }
  const MatrixXd directions = to_impulses.transpose() * s.jacobian;
  const LcpSolution solution = solve_lcp(m + directions * s.inverse_mass * directions.transpose(), directions * s.before + offset);
  if (!solution.found) return {};
  expect_complementary(solution);
  return to_impulses * solution.z;
}

// How far impulses are from a solution, m/s: what any one row would still change of its own speed. Zero in a solution, and nowhere else.
inline double residual(const System& s, const Wanted& wanted, const VectorXd& p) {
  const VectorXd w = gaps(s, wanted, p);
  double worst = 0;
  const auto count = [&](int row, double other) { worst = std::max(worst, std::abs(p(row) - other) / s.row_mass(row)); };
  for (int k = 0; k < s.points(); ++k) {
    const double mass = 1 / (1 / s.row_mass(3 * k) + wanted.compliance(k)), most = s.friction(k) * std::max(p(3 * k), 0.);
    count(3 * k, std::max(p(3 * k) - mass * w(3 * k), 0.));
    for (int row = 3 * k + 1; row < 3 * k + 3; ++row) count(row, std::clamp(p(row) - s.row_mass(row) * w(row), -most, most));
  }
  return worst;
}

// What rounding may leave between velocities and impulses, m/s and rad/s: every change of a row changes both bodies' velocities, and rounds
// in them as often as it has operations, 16 at most, by u each of a velocity no larger than all there were at the start and all impulses
// give together. The rows of all contacts of a body change in each sweep; tensors and arms are rounded, too, once.
inline double drift_bound(const System& s, const VectorXd& p, int sweeps, double unit_roundoff) {
  const MatrixXd pushes = s.jacobian.cwiseAbs();
  const double largest = s.before.cwiseAbs().maxCoeff() + (s.inverse_mass.cwiseAbs() * (pushes.transpose() * p.cwiseAbs())).maxCoeff();
  int rows = 0;
  for (Eigen::Index body = 0; body < s.before.size() / 6; ++body)
    rows = std::max(rows, static_cast<int>((pushes.middleCols(6 * body, 6).rowwise().sum().array() > 0).count()));
  return 16 * unit_roundoff * largest * (static_cast<double>(rows) * sweeps + 1);
}

// The same in the speed of a row.
inline double row_bound(const System& s, double drift) { return drift * s.jacobian.cwiseAbs().rowwise().sum().maxCoeff(); }

// dv . M dv, of velocities that static bodies share.
inline double energy(const System& s, const VectorXd& dv) {
  double sum = 0;
  for (Eigen::Index i = 0; i < dv.size(); i += 3)
    if (s.inverse_mass(i, i) > 0) {
      const Eigen::Vector3d part = dv.segment<3>(i);
      sum += part.dot(Eigen::Matrix3d(s.inverse_mass.block<3, 3>(i, i)).inverse() * part);
    }
  return sum;
}

// How far the velocities of two near-solutions p, q may be apart, in energy. With w the gaps, dv . M dv + compliance dp . dp = dp . dw, a
// sum over rows. Along normals, where p, q >= 0 and p w, q w and the negative parts of w are nearly zero, the terms are at most |p w_p| +
// |q w_q| + p (-w_q)+ + q (-w_p)+.
inline double normal_terms(const System& s, const Wanted& wanted, const VectorXd& p, const VectorXd& q) {
  const VectorXd at_p = gaps(s, wanted, p), at_q = gaps(s, wanted, q);
  double sum = 0;
  for (int row = 0; row < p.size(); row += 3) {
    const double wp = at_p(row), wq = at_q(row), pp = std::abs(p(row)), pq = std::abs(q(row));
    sum += pp * std::abs(wp) + pq * std::abs(wq) + pp * std::max(-wq, 0.) + pq * std::max(-wp, 0.);
  }
  return sum;
}

// Along tangents, where both stick, they are at most (|p| + |q|) (|w_p| + |w_q|).
inline double sticking_terms(const System& s, const Wanted& wanted, const VectorXd& p, const VectorXd& q) {
  const VectorXd at_p = gaps(s, wanted, p), at_q = gaps(s, wanted, q);
  double sum = 0;
  for (int row = 0; row < p.size(); ++row)
    if (row % 3 != 0) sum += (std::abs(p(row)) + std::abs(q(row))) * (std::abs(at_p(row)) + std::abs(at_q(row)));
  return sum;
}

// Where they slide, p w = -mu p_n |w| but for r_p, so the term is at most r_p + r_q - mu dp_n (|w_p| - |w_q|). Of the last part, summed,
// no more than mu sqrt(2) |dp| |J dv| is left, and that is at most `contraction` times dv . M dv, for J dv <= sqrt(largest) and
// dp <= 1 / sqrt(least eigenvalue of J M^-1 J^T) times the root of dv . M dv. So where contraction < 1, velocities are unique, and
// dv . M dv <= (normal_terms + sliding_terms) / (1 - contraction).
inline double sliding_terms(const System& s, const Wanted& wanted, const VectorXd& p, const VectorXd& q) {
  double sum = 0;
  for (const VectorXd* i : {&p, &q}) {
    const VectorXd w = gaps(s, wanted, *i);
    for (int row = 0; row < p.size(); ++row)
      if (row % 3 != 0) sum += std::abs((*i)(row)*w(row) + s.friction(row / 3) * (*i)(row - row % 3) * std::abs(w(row)));
  }
  return sum;
}
inline double contraction_of(const System& s, double friction) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(s.jacobian * s.inverse_mass * s.jacobian.transpose(), Eigen::EigenvaluesOnly);
  const VectorXd& eigenvalues = solver.eigenvalues();
  return friction * std::numbers::sqrt2 * std::sqrt(eigenvalues.maxCoeff() / eigenvalues.minCoeff());
}

// The body's axes along tangent, normal, -bitangent.
inline Quaternion<double> frame_of(const Vector& normal) {
  Vector t, b;
  make_tangents(normal, t, b);
  Eigen::Matrix3d axes;
  axes << eigen(t), eigen(normal), -eigen(b);
  const Eigen::Quaterniond q(axes);
  return {q.x(), q.y(), q.z(), q.w()};
}

// A box of mass 2 on a slope through the origin.
inline Problem<double> box_on_slope(const Vector& normal, const Vector& velocity, double friction) {
  Problem<double> p;
  const int ground = add_ground(p);
  Vector t, b;
  make_tangents(normal, t, b);
  const int box = add_box(
      p, box_half,
      {.position = box_half.y * normal, .mass = 2, .velocity = velocity, .orientation = frame_of(normal), .friction = friction * friction});
  touch(p, ground, box, normal, rectangle({0, 0, 0}, box_half.x * t, box_half.z * b));
  return p;
}

inline const Vector slope = unit({.3, .9, .2});

}  // namespace lockstep::rigid::contacts
