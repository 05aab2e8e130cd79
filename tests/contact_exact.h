// The contacts of one substep as a dense linear complementarity problem, its solution by pivoting (tests/lcp.h), and
// bounds on how far the iterative solver's result may be from it. The code shares with the solver only its contracts
// and its tangents: friction is bounded along them.
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

// A body has six velocities; a point has three impulses, along the normal, the tangent and the bitangent. v = before +
// inverse_mass J^T p.
struct System {
  MatrixXd inverse_mass, jacobian;
  VectorXd before;      // [6 body]: with gravity
  VectorXd separation;  // [point], m
  VectorXd friction;    // [point]
  VectorXd row_mass;    // [row]: 1 / (J M^-1 J^T), kg

  int points() const { return static_cast<int>(separation.size()); }
  VectorXd after(const VectorXd& impulses) const { return before + inverse_mass * (jacobian.transpose() * impulses); }
};

// The condition along normals: 0 <= p perpendicular to n . v + target + compliance p >= 0.
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
      for (const auto* row : {p.impulses[k].normal, p.impulses[k].tangent, p.impulses[k].bitangent})
        all.push_back(row[i]);
  return Eigen::Map<VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

// The system of the first substep.
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
    s.inverse_mass.block<3, 3>(6 * i + 3, 6 * i + 3) =
        r * Eigen::Vector3d(inverse.x, inverse.y, inverse.z).asDiagonal() * r.transpose();
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
        const auto arm = [&](int body) {
          return Eigen::Vector3d(eigen(m.point[i].position) - eigen(b.pose[body].position));
        };
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

// A point that is apart may close its gap, and no more. At any other point a spring and a damper push, of stiffness k =
// m w^2 and damping d = 2 m z w, with the force that they have at the end of the substep: p = -h (k (s + h n.v) + d
// n.v). This is n.v + s k / (d + h k) + p / (h (d + h k)) = 0.
inline Wanted soft(const SolverSettings& settings, const System& s) {
  const double h = settings.time_step / settings.substeps, w = 2 * std::numbers::pi * std::min(settings.hertz, .25 / h);
  const double z = std::max(settings.damping, 13.4 * h * w);
  Wanted wanted{VectorXd::Zero(s.points()), VectorXd::Zero(s.points())};
  for (int i = 0; i < s.points(); ++i) {
    const double mass = s.row_mass(3 * i), k = mass * w * w, d = 2 * mass * z * w;
    if (s.separation(i) > 0) {
      wanted.target(i) = s.separation(i) / h;
    } else {
      wanted.target(i) = std::max(s.separation(i) * k / (d + h * k), -settings.max_bias_velocity);
      wanted.compliance(i) = 1 / (h * (d + h * k));
    }
  }
  return wanted;
}

// The condition after bodies have moved with v for a substep. Static bodies stay in place, whatever velocity they have.
inline Wanted rigid(const SolverSettings& settings, const System& s, const VectorXd& v) {
  const double h = settings.time_step / settings.substeps;
  const VectorXd speed = s.jacobian * (s.inverse_mass.diagonal().array() > 0).select(v, 0);
  Wanted wanted{VectorXd::Zero(s.points()), VectorXd::Zero(s.points())};
  for (int i = 0; i < s.points(); ++i) wanted.target(i) = std::max(s.separation(i) / h + speed(3 * i), 0.);
  return wanted;
}

// The gaps: what the problem sets perpendicular to the impulses along normals, and the speeds along tangents.
inline VectorXd gaps(const System& s, const Wanted& wanted, const VectorXd& p) {
  VectorXd w = s.jacobian * s.after(p);
  for (int k = 0; k < s.points(); ++k) w(3 * k) += wanted.target(k) + wanted.compliance(k) * p(3 * k);
  return w;
}

// Impulses by Lemke's algorithm; empty if it finds none. A point with friction has seven variables: the normal impulse,
// and for each tangent the impulses in either direction and a slack, the sliding speed. Without friction the system has
// the normal impulses alone.
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
  const LcpSolution solution =
      solve_lcp(m + directions * s.inverse_mass * directions.transpose(), directions * s.before + offset);
  if (!solution.found) return {};
  expect_complementary(solution);
  return to_impulses * solution.z;
}

// The residual of impulses, m/s: the most that a single row would still change of its own speed. It is zero for a
// solution and only for a solution.
inline double residual(const System& s, const Wanted& wanted, const VectorXd& p) {
  const VectorXd w = gaps(s, wanted, p);
  double worst = 0;
  const auto count = [&](int row, double other) {
    worst = std::max(worst, std::abs(p(row) - other) / s.row_mass(row));
  };
  for (int k = 0; k < s.points(); ++k) {
    const double mass = 1 / (1 / s.row_mass(3 * k) + wanted.compliance(k)),
                 most = s.friction(k) * std::max(p(3 * k), 0.);
    count(3 * k, std::max(p(3 * k) - mass * w(3 * k), 0.));
    for (int row = 3 * k + 1; row < 3 * k + 3; ++row)
      count(row, std::clamp(p(row) - s.row_mass(row) * w(row), -most, most));
  }
  return worst;
}

// The most by which rounding may separate velocities from impulses, m/s and rad/s. Every update of a row changes the
// velocities of both bodies. It rounds them once for each of its operations, 16 at most, each time by u of a velocity
// that is no larger than the initial velocities and all impulses give together. Each sweep updates the rows of all
// contacts of a body. Tensors and arms are rounded once, too.
inline double drift_bound(const System& s, const VectorXd& p, int sweeps, double unit_roundoff) {
  const MatrixXd pushes = s.jacobian.cwiseAbs();
  const double largest =
      s.before.cwiseAbs().maxCoeff() + (s.inverse_mass.cwiseAbs() * (pushes.transpose() * p.cwiseAbs())).maxCoeff();
  int rows = 0;
  for (Eigen::Index body = 0; body < s.before.size() / 6; ++body)
    rows = std::max(rows, static_cast<int>((pushes.middleCols(6 * body, 6).rowwise().sum().array() > 0).count()));
  return 16 * unit_roundoff * largest * (static_cast<double>(rows) * sweeps + 1);
}

// The same bound for the speed of a row.
inline double row_bound(const System& s, double drift) {
  return drift * s.jacobian.cwiseAbs().rowwise().sum().maxCoeff();
}

// The energy dv . M dv of the difference of two velocities; static bodies have the same velocity in both.
inline double energy(const System& s, const VectorXd& dv) {
  double sum = 0;
  for (Eigen::Index i = 0; i < dv.size(); i += 3)
    if (s.inverse_mass(i, i) > 0) {
      const Eigen::Vector3d part = dv.segment<3>(i);
      sum += part.dot(Eigen::Matrix3d(s.inverse_mass.block<3, 3>(i, i)).inverse() * part);
    }
  return sum;
}

// A bound on the energy of the difference between the velocities of two near-solutions p and q. With the gaps w, dv . M
// dv + compliance dp . dp = dp . dw, a sum over rows. Along normals p, q >= 0, and p w, q w and the negative parts of w
// are nearly zero. The terms are therefore at most |p w_p| + |q w_q| + p (-w_q)+ + q (-w_p)+.
inline double normal_terms(const System& s, const Wanted& wanted, const VectorXd& p, const VectorXd& q) {
  const VectorXd at_p = gaps(s, wanted, p), at_q = gaps(s, wanted, q);
  double sum = 0;
  for (int row = 0; row < p.size(); row += 3) {
    const double wp = at_p(row), wq = at_q(row), pp = std::abs(p(row)), pq = std::abs(q(row));
    sum += pp * std::abs(wp) + pq * std::abs(wq) + pp * std::max(-wq, 0.) + pq * std::max(-wp, 0.);
  }
  return sum;
}

// Along tangents at which both stick, the terms are at most (|p| + |q|) (|w_p| + |w_q|).
inline double sticking_terms(const System& s, const Wanted& wanted, const VectorXd& p, const VectorXd& q) {
  const VectorXd at_p = gaps(s, wanted, p), at_q = gaps(s, wanted, q);
  double sum = 0;
  for (int row = 0; row < p.size(); ++row)
    if (row % 3 != 0) sum += (std::abs(p(row)) + std::abs(q(row))) * (std::abs(at_p(row)) + std::abs(at_q(row)));
  return sum;
}

// Along tangents at which they slide, p w = -mu p_n |w| but for a residual r_p, so a term is at most r_p + r_q - mu
// dp_n (|w_p| - |w_q|). The sum of the last part is at most mu sqrt(2) |dp| |J dv|. This is at most `contraction` times
// dv . M dv, because |J dv| is at most sqrt(largest eigenvalue of J M^-1 J^T) and |dp| at most 1 / sqrt(its least
// eigenvalue), each times the root of dv . M dv. If contraction < 1, velocities are therefore unique, and dv . M dv <=
// (normal_terms + sliding_terms) / (1 - contraction).
inline double sliding_terms(const System& s, const Wanted& wanted, const VectorXd& p, const VectorXd& q) {
  double sum = 0;
  for (const VectorXd* i : {&p, &q}) {
    const VectorXd w = gaps(s, wanted, *i);
    for (int row = 0; row < p.size(); ++row)
      if (row % 3 != 0)
        sum += std::abs((*i)(row)*w(row) + s.friction(row / 3) * (*i)(row - row % 3) * std::abs(w(row)));
  }
  return sum;
}
inline double contraction_of(const System& s, double friction) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(s.jacobian * s.inverse_mass * s.jacobian.transpose(),
                                                       Eigen::EigenvaluesOnly);
  const VectorXd& eigenvalues = solver.eigenvalues();
  return friction * std::numbers::sqrt2 * std::sqrt(eigenvalues.maxCoeff() / eigenvalues.minCoeff());
}

// The orientation whose axes lie along tangent, normal and -bitangent.
inline Quaternion<double> frame_of(const Vector& normal) {
  Vector t, b;
  make_tangents(normal, t, b);
  Eigen::Matrix3d axes;
  axes << eigen(t), eigen(normal), -eigen(b);
  const Eigen::Quaterniond q(axes);
  return {q.x(), q.y(), q.z(), q.w()};
}

// A box of mass 2 rests on a slope through the origin.
inline Problem<double> box_on_slope(const Vector& normal, const Vector& velocity, double friction) {
  Problem<double> p;
  const int ground = add_ground(p);
  Vector t, b;
  make_tangents(normal, t, b);
  const int box = add_box(p, box_half,
                          {.position = box_half.y * normal,
                           .mass = 2,
                           .velocity = velocity,
                           .orientation = frame_of(normal),
                           .friction = friction * friction});
  touch(p, ground, box, normal, rectangle({0, 0, 0}, box_half.x * t, box_half.z * b));
  return p;
}

inline const Vector slope = unit({.3, .9, .2});

}  // namespace lockstep::rigid::contacts
