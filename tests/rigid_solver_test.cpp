// The contact solver against exact solutions of the same problem by pivoting (tests/lcp.h), and against the physics of a block on a slope,
// of bounces, of a conveyor; batches and levels by what defines them; free bodies against free fall and the symmetric top; contacts matched
// from step to step against a look-up; and both versions against each other, bit by bit.
//
// Nothing here is shared with the solver but the contracts and the tangents, in whose frame the box of friction stands.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <random>
#include <set>

#include "common/convert.h"
#include "common/math.h"
#include "common/rigid/batches.h"
#include "common/rigid/contact_row.h"
#include "common/rigid/contact_solver.h"
#include "common/rigid/integrate.h"
#include "common/rigid/make.h"
#include "common/rigid/match_contacts.h"
#include "tests/lcp.h"

namespace lockstep::rigid {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;
using Vector = Vector3<double>;

constexpr double u = std::numeric_limits<double>::epsilon() / 2, u_float = std::numeric_limits<float>::epsilon() / 2;
constexpr double g = 9.81;
const int thread_counts[] = {1, 2, 3, 4, 8};

// --- Lemke's algorithm alone

// How negative what should be zero may come out: ties are ties to within 1e-10 (tests/lcp.h).
double noise_of(const LcpSolution& s) { return 1e-10 * (1 + s.z.cwiseAbs().maxCoeff() + s.w.cwiseAbs().maxCoeff()); }

void expect_complementary(const LcpSolution& s) {
  ASSERT_TRUE(s.found);
  EXPECT_GE(s.z.minCoeff(), -noise_of(s));
  EXPECT_GE(s.w.minCoeff(), -noise_of(s));
  EXPECT_LE(s.z.cwiseMin(s.w).maxCoeff(), noise_of(s));
}

TEST(Lcp, InOneDimension) {
  const auto solve = [](double m, double q) { return solve_lcp(MatrixXd::Constant(1, 1, m), VectorXd::Constant(1, q)); };
  EXPECT_DOUBLE_EQ(solve(2, -3).z(0), 1.5);
  EXPECT_EQ(solve(2, 3).z(0), 0);
  EXPECT_EQ(solve(2, 3).w(0), 3);
  EXPECT_TRUE(solve(0, 0).found);
  EXPECT_FALSE(solve(0, -1).found);
  EXPECT_FALSE(solve(-1, -1).found);
}

TEST(Lcp, WithoutSolutionIsReported) {
  // Two rows that push the same body apart, one each way: w0 = z0 - z1 - 1, w1 = z1 - z0 - 1 would add up to -2.
  const MatrixXd m{{1, -1}, {-1, 1}};
  EXPECT_FALSE(solve_lcp(m, VectorXd::Constant(2, -1)).found);
  EXPECT_TRUE(solve_lcp(m, VectorXd{{-1, 1}}).found);  // w = 0 0 at z = 1 0
}

// A string from 0 to 1 under a load f, above a floor c below its ends: it lies on the floor between x and 1 - x, f x^2 / 2 = c, and is a
// parabola beside it. Second differences of a parabola are exact, so the nodes have the values of the curve.
TEST(Lcp, StringAboveAFloor) {
  constexpr int nodes = 99, first_down = 30;  // node i at (i + 1) h
  constexpr double h = .01, f = 8, x = first_down * h, c = f * x * x / 2;
  MatrixXd m = MatrixXd::Zero(nodes, nodes);
  for (int i = 0; i < nodes; ++i) {
    m(i, i) = 2 / (h * h);
    if (i > 0) m(i, i - 1) = m(i - 1, i) = -1 / (h * h);
  }
  // z is the height above the floor: M (z - c) + f >= 0, where the ends, at height c, belong to the first and the last row.
  VectorXd q = VectorXd::Constant(nodes, f);
  q(0) -= c / (h * h), q(nodes - 1) -= c / (h * h);
  const LcpSolution s = solve_lcp(m, q);
  expect_complementary(s);
  for (int i = 0; i < nodes; ++i) {
    const double side = std::min((i + 1) * h, 1 - (i + 1) * h);
    const double height = side < x ? f * (x - side) * (x - side) / 2 : 0;
    // What the rounding of q, 4 / h^2 c u, does through the inverse of M, of norm 1 / pi^2 (its lowest mode), times the nodes.
    EXPECT_NEAR(s.z(i), height, nodes * 4 / (h * h) * c * u) << i;
  }
}

// All complementary bases tried: of a P-matrix, exactly one gives a solution, whatever q [Cottle, Pang, Stone, 3.3.7].
TEST(Lcp, OfPMatricesAgainstAllBases) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int problem = 0; problem < 200; ++problem) {
    const int n = 1 + problem % 7;
    const auto any = [&] { return unit(random); };
    const MatrixXd a = MatrixXd::NullaryExpr(n, n, any), skew = MatrixXd::NullaryExpr(n, n, any);
    const MatrixXd m = a * a.transpose() + .1 * MatrixXd::Identity(n, n) + (skew - skew.transpose());  // positive definite, unsymmetric
    VectorXd q = VectorXd::NullaryExpr(n, any);
    if (problem % 3 == 0) q.setConstant(-1);  // ties
    VectorXd expected;
    for (int basis = 0; basis < 1 << n; ++basis) {
      MatrixXd columns(n, n);
      for (int i = 0; i < n; ++i) columns.col(i) = basis >> i & 1 ? -m.col(i) : VectorXd(VectorXd::Unit(n, i));
      const VectorXd values = columns.partialPivLu().solve(q);
      if (values.minCoeff() < 0) continue;
      expected = VectorXd::Zero(n);
      for (int i = 0; i < n; ++i)
        if (basis >> i & 1) expected(i) = values(i);
    }
    ASSERT_EQ(expected.size(), n);
    const LcpSolution s = solve_lcp(m, q);
    expect_complementary(s);
    // The same basis, solved by the same factorisation of columns in another order; M's lowest eigenvalue is at least .1, its norm 3 n.
    EXPECT_LE((s.z - expected).norm(), n * n * u * (3 * n / .1) * expected.norm() + u) << problem;
  }
}

// --- Hand-made contacts

template <class Real>
struct Problem {
  Bodies<Real> bodies;
  Array<Manifold<Real>> manifolds;
  std::vector<std::int32_t> body;  // [collider]
  Array<Impulses<Real>> impulses;  // [manifold]
  Array<Motion<Real>> moving;
};

struct Body {
  Vector position = {0, 0, 0};
  double mass = 0;                                   // kg; 0: static
  Vector inertia = {1, 1, 1};                        // kg m^2
  Vector velocity = {0, 0, 0}, angular = {0, 0, 0};  // m/s, rad/s
  Quaternion<double> orientation = no_rotation;
  double friction = 0, restitution = 0;
};

// With a collider of its own, of its own number.
int add(Problem<double>& p, const Body& body) {
  Bodies<double>& b = p.bodies;
  const int i = b.count++;
  b.pose.resize(padded(b.count), no_offset);
  b.motion.resize(padded(b.count)), b.inverse_mass.resize(padded(b.count));
  b.friction.resize(padded(b.count)), b.restitution.resize(padded(b.count));
  b.pose[i] = {body.position, body.orientation, 0};
  b.motion[i] = {body.velocity, body.angular, {}};
  if (body.mass > 0) b.inverse_mass[i] = {1 / body.inertia.x, 1 / body.inertia.y, 1 / body.inertia.z, 1 / body.mass};
  b.friction[i] = body.friction, b.restitution[i] = body.restitution;
  p.body.push_back(i);
  return i;
}

int add_box(Problem<double>& p, const Vector& half, Body body) {
  const Vector squares = {half.x * half.x, half.y * half.y, half.z * half.z};
  body.inertia = body.mass / 3 * Vector{squares.y + squares.z, squares.x + squares.z, squares.x + squares.y};
  return add(p, body);
}

using Points = std::vector<ContactPoint<double>>;

void touch(Problem<double>& p, int collider_a, int collider_b, const Vector& normal, const Points& points) {
  Manifold<double> m{};
  m.normal = normal;
  m.count = static_cast<std::int32_t>(points.size());
  m.a = collider_a, m.b = collider_b;
  std::ranges::copy(points, m.point);
  p.manifolds.push_back(m);
  p.impulses.push_back({});
}

// Four corners of a rectangle around a middle, with sides along two directions.
Points rectangle(const Vector& middle, const Vector& s, const Vector& t, double separation = 0) {
  return {{middle - s - t, separation}, {middle + s - t, separation}, {middle + s + t, separation}, {middle - s + t, separation}};
}

template <class To, class From>
Problem<To> convert(const Problem<From>& p) {
  if constexpr (std::is_same_v<To, From>) {
    return p;
  } else {
    World<From> world;
    world.bodies = p.bodies;
    Problem<To> to{rigid::convert<To>(world).bodies, {}, p.body, {}, {}};
    for (const Manifold<From>& m : p.manifolds) {
      Manifold<To>& n = to.manifolds.emplace_back();
      n = {lockstep::convert<To>(m.normal), m.count, m.a, m.b, {}, {}, {}, {}};
      for (int k = 0; k < most_points; ++k) {
        n.point[k] = {lockstep::convert<To>(m.point[k].position), static_cast<To>(m.point[k].separation)};
        n.feature[k] = m.feature[k];
      }
    }
    for (const Impulses<From>& from : p.impulses) {
      Impulses<To>& i = to.impulses.emplace_back();
      for (int k = 0; k < most_points; ++k) {
        i.normal[k] = static_cast<To>(from.normal[k]);
        i.tangent[k] = static_cast<To>(from.tangent[k]), i.bitangent[k] = static_cast<To>(from.bitangent[k]);
      }
    }
    return to;
  }
}

template <class Real>
void solve_original(const SolverSettings& settings, Problem<Real>& p) {
  serial::contact_solver_original(settings, p.manifolds, p.body, p.bodies, p.impulses, p.moving);
}
template <class Real>
void solve_batches(const SolverSettings& settings, Problem<Real>& p) {
  const Batches batches = serial::batches(p.manifolds, p.body, p.bodies);
  serial::contact_solver_batches(settings, p.manifolds, p.body, batches, p.bodies, p.impulses, p.moving);
}

// --- The linear complementarity problem, dense

Eigen::Vector3d eigen(const Vector& v) { return {v.x, v.y, v.z}; }

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
System assemble(const SolverSettings& settings, const Problem<double>& p) {
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
Wanted soft(const SolverSettings& settings, const System& s) {
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
Wanted rigid(const SolverSettings& settings, const System& s, const VectorXd& v) {
  const double h = settings.time_step / settings.substeps;
  const VectorXd speed = s.jacobian * (s.inverse_mass.diagonal().array() > 0).select(v, 0);
  Wanted wanted{VectorXd::Zero(s.points()), VectorXd::Zero(s.points())};
  for (int i = 0; i < s.points(); ++i) wanted.target(i) = std::max(s.separation(i) / h + speed(3 * i), 0.);
  return wanted;
}

// What the problem sets perpendicular to the impulses along normals, and the speeds along tangents.
VectorXd gaps(const System& s, const Wanted& wanted, const VectorXd& p) {
  VectorXd w = s.jacobian * s.after(p);
  for (int k = 0; k < s.points(); ++k) w(3 * k) += wanted.target(k) + wanted.compliance(k) * p(3 * k);
  return w;
}

// Impulses by Lemke's algorithm; empty where it finds none. Of a point with friction, seven variables: along the normal; along one way,
// along the other, and a slack, the sliding speed, for each tangent. Without friction anywhere the normals alone.
VectorXd pivoted(const System& s, const Wanted& wanted) {
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
double residual(const System& s, const Wanted& wanted, const VectorXd& p) {
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
double drift_bound(const System& s, const VectorXd& p, int sweeps, double unit_roundoff) {
  const MatrixXd pushes = s.jacobian.cwiseAbs();
  const double largest = s.before.cwiseAbs().maxCoeff() + (s.inverse_mass.cwiseAbs() * (pushes.transpose() * p.cwiseAbs())).maxCoeff();
  int rows = 0;
  for (Eigen::Index body = 0; body < s.before.size() / 6; ++body)
    rows = std::max(rows, static_cast<int>((pushes.middleCols(6 * body, 6).rowwise().sum().array() > 0).count()));
  return 16 * unit_roundoff * largest * (static_cast<double>(rows) * sweeps + 1);
}

// The same in the speed of a row.
double row_bound(const System& s, double drift) { return drift * s.jacobian.cwiseAbs().rowwise().sum().maxCoeff(); }

// dv . M dv, of velocities that static bodies share.
double energy(const System& s, const VectorXd& dv) {
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
double normal_terms(const System& s, const Wanted& wanted, const VectorXd& p, const VectorXd& q) {
  const VectorXd at_p = gaps(s, wanted, p), at_q = gaps(s, wanted, q);
  double sum = 0;
  for (int row = 0; row < p.size(); row += 3) {
    const double wp = at_p(row), wq = at_q(row), pp = std::abs(p(row)), pq = std::abs(q(row));
    sum += pp * std::abs(wp) + pq * std::abs(wq) + pp * std::max(-wq, 0.) + pq * std::max(-wp, 0.);
  }
  return sum;
}

// Along tangents, where both stick, they are at most (|p| + |q|) (|w_p| + |w_q|).
double sticking_terms(const System& s, const Wanted& wanted, const VectorXd& p, const VectorXd& q) {
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
double sliding_terms(const System& s, const Wanted& wanted, const VectorXd& p, const VectorXd& q) {
  double sum = 0;
  for (const VectorXd* i : {&p, &q}) {
    const VectorXd w = gaps(s, wanted, *i);
    for (int row = 0; row < p.size(); ++row)
      if (row % 3 != 0) sum += std::abs((*i)(row)*w(row) + s.friction(row / 3) * (*i)(row - row % 3) * std::abs(w(row)));
  }
  return sum;
}
double contraction_of(const System& s, double friction) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(s.jacobian * s.inverse_mass * s.jacobian.transpose(), Eigen::EigenvaluesOnly);
  const VectorXd& eigenvalues = solver.eigenvalues();
  return friction * std::numbers::sqrt2 * std::sqrt(eigenvalues.maxCoeff() / eigenvalues.minCoeff());
}

// --- Projected Gauss-Seidel, run long, against pivoting

enum class Friction {
  sticks,  // or is none: velocities are unique
  slides,  // a little: velocities are unique where contraction < 1
  any      // velocities need not be unique: what is found must be a solution
};

constexpr int long_run = 4000;

// One substep of soft sweeps without friction, so that their impulses can be seen, or with rigid sweeps after them.
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
    const double noise = 1e-10 * (1 + q.cwiseAbs().maxCoeff()) / s.row_mass.minCoeff();  // as in noise_of, in the speed of a row
    EXPECT_LE(residual(s, wanted, q), noise);
    if (resting && kind == Friction::any) continue;
    const double contraction = slides ? contraction_of(s, s.friction.maxCoeff()) : 0;
    ASSERT_LT(contraction, 1);
    const auto tangent_terms = slides ? sliding_terms : sticking_terms;
    const double terms = normal_terms(s, wanted, p, q) + tangent_terms(s, wanted, p, q);
    // Each term is an impulse times what the residuals leave of a speed, each at most twice; else they do not stick.
    EXPECT_LE(terms, 4 * (p.cwiseAbs().sum() + q.cwiseAbs().sum()) * (row + noise));
    EXPECT_LE(energy(s, s.after(p) - s.after(q)), terms / (1 - contraction));
  }
  // Bodies move with the velocity that pushing ended with.
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

// A ground that does not move, of friction 1, so that the contact's is the root of the other's.
int add_ground(Problem<double>& p) { return add(p, {.friction = 1}); }

constexpr Vector box_half = {.5, .25, .4};

TEST(ContactSolver, BoxOnTheGroundIsTheExactSolution) {
  for (const Vector& velocity : {Vector{0, -1, 0}, Vector{.2, -2, .1}}) {
    Problem<double> p;
    const int ground = add_ground(p);
    const int box = add_box(p, box_half, {.position = {0, box_half.y, 0}, .mass = 2, .velocity = velocity, .friction = .64});
    touch(p, ground, box, {0, 1, 0}, rectangle({0, 0, 0}, {box_half.x, 0, 0}, {0, 0, box_half.z}, -.002));
    expect_solution(p, Friction::sticks);
  }
}

// The body's axes along tangent, normal, -bitangent.
Quaternion<double> frame_of(const Vector& normal) {
  Vector t, b;
  make_tangents(normal, t, b);
  Eigen::Matrix3d axes;
  axes << eigen(t), eigen(normal), -eigen(b);
  const Eigen::Quaterniond q(axes);
  return {q.x(), q.y(), q.z(), q.w()};
}

// A box of mass 2 on a slope through the origin.
Problem<double> box_on_slope(const Vector& normal, const Vector& velocity, double friction) {
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

Vector unit(const Vector& v) { return 1 / std::sqrt(dot(v, v)) * v; }
const Vector slope = unit({.3, .9, .2});

TEST(ContactSolver, BoxOnASlopeIsTheExactSolution) {
  expect_solution(box_on_slope(slope, {0, -1, 0}, .8), Friction::sticks);
  for (const double friction : {0., .05, .2}) expect_solution(box_on_slope(slope, {.1, -1, .2}, friction), Friction::any);
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

// [LRB08] Figure 13, [ITJ07] Figure 2: b2 bridges b1 and b3, which stand on the ground b4.
Problem<double> papers_bodies(double friction, const Vector& velocity) {
  Problem<double> p;
  const int b1 = add_box(p, box_half, {.position = {-.6, .25, 0}, .mass = 1, .velocity = {0, -.1, 0}, .friction = friction});
  const int b2 = add_box(p, {1, .25, .4}, {.position = {0, .75, 0}, .mass = 3, .velocity = velocity, .friction = friction});
  const int b3 = add_box(p, box_half, {.position = {.6, .25, 0}, .mass = 1, .velocity = {0, -.1, 0}, .friction = friction});
  const int b4 = add(p, {.friction = friction});
  touch(p, b1, b2, {0, 1, 0}, rectangle({-.55, .5, 0}, {.45, 0, 0}, {0, 0, .4}));
  touch(p, b2, b3, {0, -1, 0}, rectangle({.55, .5, 0}, {.45, 0, 0}, {0, 0, .4}));
  touch(p, b3, b4, {0, -1, 0}, rectangle({.6, 0, 0}, {.5, 0, 0}, {0, 0, .4}));
  touch(p, b1, b4, {0, -1, 0}, rectangle({-.6, 0, 0}, {.5, 0, 0}, {0, 0, .4}));
  return p;
}

TEST(ContactSolver, ThePapersFourBodiesAreTheExactSolution) {
  expect_solution(papers_bodies(.5, {0, -.1, 0}), Friction::sticks);
  expect_solution(papers_bodies(0, {.3, -.1, .2}), Friction::sticks);
  expect_solution(papers_bodies(.3, {.8, -.1, .2}), Friction::any);
}

// Bodies around a static one, or around none, and contacts of 1 to 4 points between neighbours whose normals lie within 30 degrees of the
// line from one to the other: moving all bodies away from the first one then parts all contacts, so that there is a solution.
Problem<double> cluster(int bodies, int contacts, bool with_static, double friction, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&] { return Vector{uniform(random), uniform(random), uniform(random)}; };
  Problem<double> p;
  for (int i = 0; i < bodies; ++i) {
    const Vector q = vector();
    const Quaternion<double> turned = {.5 * q.x, .5 * q.y, .5 * q.z, std::sqrt(1 - .25 * dot(q, q))};
    const double mass = with_static && i == 0 ? 0 : 1.5 + uniform(random);
    const Vector inertia = mass * Vector{.1 + .05 * uniform(random), .1 + .05 * uniform(random), .1 + .05 * uniform(random)};
    add(p, {.position = i == 0 ? Vector{0, 0, 0} : 2. * vector(),
            .mass = mass,
            .inertia = inertia,
            .velocity = vector(),
            .angular = vector(),
            .orientation = turned,
            .friction = friction});
  }
  for (int k = 0; k < contacts; ++k) {
    const int a = k < bodies - 1 ? random() % (k + 1) : random() % bodies, b = k < bodies - 1 ? k + 1 : random() % bodies;
    if (a >= b) continue;
    const Vector &at_a = p.bodies.pose[a].position, &at_b = p.bodies.pose[b].position;
    const Vector line = unit(at_b - at_a), across = unit(cross(line, vector())), normal = unit(line + .5 * across);
    Vector t, s;
    make_tangents(normal, t, s);
    // Within .8 of both bodies along the line, as if they touched.
    Points points = rectangle(.5 * (at_a + at_b), (.2 + .1 * uniform(random)) * t, (.2 + .1 * uniform(random)) * s);
    points.resize(1 + random() % 4);
    for (ContactPoint<double>& point : points) point.separation = .004 * uniform(random);
    touch(p, a, b, normal, points);
  }
  return p;
}

TEST(ContactSolver, ClustersAreExactSolutions) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const bool with_static = seed % 2 == 0;
    expect_solution(cluster(10, 20, with_static, 0, seed), Friction::sticks);
    expect_solution(cluster(10, 20, with_static, .3, seed), Friction::any);
  }
}

// Spheres that touch like the branches of a tree, one point each: then impulses are unique, too, while friction is small.
TEST(ContactSolver, SlidingSpheresAreTheExactSolution) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    const auto vector = [&] { return Vector{uniform(random), uniform(random), uniform(random)}; };
    Problem<double> p;
    constexpr double radius = .5;
    for (int i = 0; i < 12; ++i) {
      const int to = i == 0 ? 0 : random() % i;
      const Vector away = unit(vector()), at = i == 0 ? Vector{0, 0, 0} : p.bodies.pose[to].position + 2 * radius * away;
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

// A float run, as long as convergence takes, is a near-solution of the same problem in double: its velocities belong to its impulses but
// for drift, its rows are as good as drift lets them be, and so its velocities are as near to the exact ones as such rows allow.
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

// --- Physics

SolverSettings thorough(const Vector& gravity) {
  return {.time_step = .01, .gravity = gravity, .substeps = 2, .biased_sweeps = 50, .relax_sweeps = 500};
}

// What rounding may do to velocities in steps of these settings.
double steps_bound(const SolverSettings& settings, const Problem<double>& p, int steps) {
  const int sweeps = settings.substeps * (settings.biased_sweeps + settings.relax_sweeps + 2);
  const System s = assemble(settings, p);
  return steps * row_bound(s, drift_bound(s, impulses_of(p), sweeps, u));
}

// Down the slope by an angle, along a tangent or between the two, where each tangent's share of the speed meets a friction mu p_n of its
// own: the box is sqrt(2) wide there. Gravity is tilted, not the slope.
void expect_slide(const Vector& normal, double share_t, double share_b, double box_width) {
  constexpr double angle = .5, at_first = .5;
  Vector t, b;
  make_tangents(normal, t, b);
  const Vector down = share_t * t + share_b * b;
  const SolverSettings settings = thorough(g * (std::sin(angle) * down - std::cos(angle) * normal));
  for (const double friction : {.1, .25, .8}) {
    const double acceleration = g * (std::sin(angle) - box_width * friction * std::cos(angle));
    Problem<double> p = box_on_slope(normal, at_first * down, friction);
    for (int step = 1; step <= 30; ++step) {
      solve_original(settings, p);
      // A substep that would turn it round stops it.
      const Vector expected = std::max(at_first + step * settings.time_step * acceleration, 0.) * down;
      const Vector off = p.bodies.motion[1].velocity - expected, spin = p.bodies.motion[1].angular_velocity;
      const double bound = steps_bound(settings, p, step);
      EXPECT_LE(std::sqrt(dot(off, off)), bound) << friction << ' ' << step;
      EXPECT_LE(std::sqrt(dot(spin, spin)), bound) << friction << ' ' << step;
    }
    EXPECT_EQ(acceleration < 0, dot(p.bodies.motion[1].velocity, p.bodies.motion[1].velocity) < 1e-9);
  }
}

TEST(ContactPhysics, BoxOnASlopeSlidesOrStaysAsFrictionSays) {
  for (const Vector& normal : {Vector{0, 1, 0}, slope, unit({-.3, .2, -.8})}) {
    expect_slide(normal, 1, 0, 1);
    expect_slide(normal, 0, -1, 1);
    expect_slide(normal, std::numbers::sqrt2 / 2, std::numbers::sqrt2 / 2, std::numbers::sqrt2);
  }
}

// v1' = v1 + (1 + e) m2 / (m1 + m2) (v2 - v1): of equal masses and e = 1, they swap.
TEST(ContactPhysics, SpheresCollideHeadOn) {
  for (const int substeps : {1, 2, 5})
    for (const double e : {0., .5, 1.})
      for (const double m2 : {1., 3.})
        for (const double apart : {0., .01}) {
          constexpr double m1 = 1, v1 = 2, v2 = -1;
          const SolverSettings settings{.time_step = .01, .gravity = {0, 0, 0}, .substeps = substeps};
          Problem<double> p;
          add(p, {.position = {-.5, 0, 0}, .mass = m1, .inertia = {.1, .1, .1}, .velocity = {v1, 0, 0}, .friction = .5, .restitution = e});
          add(p, {.position = {.5 + apart, 0, 0}, .mass = m2, .inertia = {.1, .1, .1}, .velocity = {v2, 0, 0}, .friction = .5});
          touch(p, 0, 1, {1, 0, 0}, {{{.5 * apart, 0, 0}, apart}});
          solve_original(settings, p);
          const double bound = drift_bound(assemble(settings, p), impulses_of(p), 2 * substeps + 2, u);
          EXPECT_NEAR(p.bodies.motion[0].velocity.x, v1 + (1 + e) * m2 / (m1 + m2) * (v2 - v1), bound)
              << substeps << ' ' << e << ' ' << apart;
          EXPECT_NEAR(p.bodies.motion[1].velocity.x, v2 + (1 + e) * m1 / (m1 + m2) * (v1 - v2), bound)
              << substeps << ' ' << e << ' ' << apart;
          for (const int i : {0, 1}) EXPECT_EQ(p.bodies.motion[i].velocity.y, 0) << i;
        }
}

TEST(ContactPhysics, WithoutStaticBodiesMomentumIsKept) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    Problem<double> p = cluster(12, 30, false, .4, seed);
    std::fill(p.bodies.restitution.begin(), p.bodies.restitution.end(), .1 * seed);
    const SolverSettings settings{.time_step = .01, .gravity = {0, 0, 0}, .bounce_from = .2};
    const System s = assemble(settings, p);
    const int count = p.bodies.count;
    const auto momentum = [&] {
      const VectorXd v = velocities(p.bodies.motion, count);
      Eigen::Matrix<double, 6, 1> sum = Eigen::Matrix<double, 6, 1>::Zero();
      for (int i = 0; i < count; ++i) {
        const Eigen::Vector3d linear = v.segment<3>(6 * i) / s.inverse_mass(6 * i, 6 * i), at = eigen(p.bodies.pose[i].position);
        const Eigen::Matrix3d inertia = s.inverse_mass.block<3, 3>(6 * i + 3, 6 * i + 3).inverse();
        sum.head<3>() += linear;
        sum.tail<3>() += at.cross(linear) + inertia * v.segment<3>(6 * i + 3);
      }
      return sum;
    };
    const Eigen::Matrix<double, 6, 1> before = momentum();
    solve_original(settings, p);
    // Each velocity is off by the drift; bodies are 4 m around, and weigh 2.5 kg at most.
    const double drift = drift_bound(s, impulses_of(p), settings.substeps * (settings.biased_sweeps + settings.relax_sweeps) + 2, u);
    EXPECT_LE((momentum() - before).cwiseAbs().maxCoeff(), count * 2.5 * (1 + 2 * 4) * drift) << seed;
    EXPECT_GT((velocities(p.bodies.motion, count) - s.before).norm(), .5);
  }
}

// A ball above or in the ground, one point.
Problem<double> ball(double separation, double speed_down) {
  Problem<double> p;
  const int ground = add_ground(p);
  const int b = add(p, {.position = {0, .5 + separation, 0}, .mass = 2, .inertia = {.2, .2, .2}, .velocity = {0, -speed_down, 0}});
  touch(p, ground, b, {0, 1, 0}, {{{0, .5 * separation, 0}, separation}});
  return p;
}

TEST(ContactPhysics, APointThatIsApartMayJustMeet) {
  for (const int substeps : {1, 3, 5}) {
    const SolverSettings settings{.time_step = .01, .gravity = {0, 0, 0}, .substeps = substeps};
    for (const double apart : {.001, .02}) {
      for (const double speed : {2.5, 40.}) {
        Problem<double> p = ball(apart, speed);
        solve_original(settings, p);
        const double reaches = std::min(apart, speed * settings.time_step);
        EXPECT_NEAR(p.moving[1].velocity.y * settings.time_step, -reaches, 16 * (substeps + 1) * u * speed * settings.time_step);
      }
      Problem<double> slow = ball(apart, .05);
      solve_original(settings, slow);
      EXPECT_EQ(slow.bodies.motion[1].velocity.y, -.05);
      EXPECT_EQ(slow.impulses[0].normal[0], 0);
    }
  }
}

// At rest in the ground, a ball is pushed out each substep as a damped spring would from rest, by the implicit Euler rule, and stands
// again.
TEST(ContactPhysics, APenetrationIsPushedOutAndLeavesNoSpeed) {
  for (const int substeps : {1, 3, 5})
    for (const double depth : {.0002, .01, 1.}) {
      const SolverSettings settings{.time_step = .01, .gravity = {0, 0, 0}, .substeps = substeps};
      const double h = settings.time_step / substeps, w = 2 * std::numbers::pi * std::min(settings.hertz, .25 / h), z = settings.damping;
      double deep = depth;
      for (int i = 0; i < substeps; ++i) {
        const double soft = h * w * (2 * z + h * w);
        deep -= h * std::min(deep * w / (2 * z + h * w), settings.max_bias_velocity) * soft / (1 + soft);
      }
      Problem<double> p = ball(-depth, 0);
      solve_original(settings, p);
      const double bound = 16 * (substeps + 1) * u * settings.max_bias_velocity;
      EXPECT_NEAR(p.moving[1].velocity.y, (depth - deep) / settings.time_step, bound + 16 * u * depth / settings.time_step);
      EXPECT_NEAR(p.bodies.motion[1].velocity.y, 0, bound);
    }
}

// A body that does not move but has a velocity carries what stands on it.
TEST(ContactPhysics, AConveyorCarriesABox) {
  constexpr double friction = .4, speed = 1;
  Problem<double> p = box_on_slope({0, 1, 0}, {0, 0, 0}, friction);
  p.bodies.motion[0].velocity = {speed, 0, 0};
  const Motion<double> conveyor = p.bodies.motion[0];
  const SolverSettings settings = thorough({0, -g, 0});
  for (int step = 1; step <= 40; ++step) {
    solve_original(settings, p);
    EXPECT_NEAR(p.bodies.motion[1].velocity.x, std::min(step * settings.time_step * friction * g, speed), steps_bound(settings, p, step));
  }
  EXPECT_EQ(std::memcmp(&conveyor, &p.bodies.motion[0], sizeof conveyor), 0);
}

// --- Both versions, bit by bit

template <class T>
bool same_bits(const Array<T>& a, const Array<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

// Contacts of any bodies in any direction, two colliders a body, static ones moving like conveyors.
Problem<float> crowd(int bodies, int contacts, double static_share, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&] { return Vector{uniform(random), uniform(random), uniform(random)}; };
  Problem<double> p;
  for (int i = 0; i < bodies; ++i) {
    const Vector q = vector();
    add(p, {.position = 5. * vector(),
            .mass = uniform(random) < 2 * static_share - 1 ? 0. : 2 + uniform(random),
            .inertia = {.2 + .1 * uniform(random), .2 + .1 * uniform(random), .2},
            .velocity = 3. * vector(),
            .angular = vector(),
            .orientation = {.5 * q.x, .5 * q.y, .5 * q.z, std::sqrt(1 - .25 * dot(q, q))},
            .friction = std::max(0., uniform(random)),
            .restitution = std::max(0., uniform(random))});
  }
  p.body.clear();
  for (int i = 0; i < bodies; ++i) p.body.insert(p.body.end(), 2, i);
  while (static_cast<int>(p.manifolds.size()) < contacts) {
    const int a = random() % (2 * bodies), b = random() % (2 * bodies);
    const auto moves = [&](int collider) { return p.bodies.inverse_mass[p.body[collider]].w > 0; };
    if (p.body[a] >= p.body[b] || (!moves(a) && !moves(b))) continue;
    const Vector middle = .5 * (p.bodies.pose[p.body[a]].position + p.bodies.pose[p.body[b]].position);
    Points points(1 + random() % 4);
    for (ContactPoint<double>& point : points) point = {middle + .3 * vector(), .02 * uniform(random)};
    touch(p, a, b, unit(vector()), points);
    for (std::size_t k = 0; k < points.size(); ++k) {
      p.impulses.back().normal[k] = std::max(0., uniform(random));
      p.impulses.back().tangent[k] = .2 * uniform(random), p.impulses.back().bitangent[k] = .2 * uniform(random);
    }
  }
  Problem<float> crowd = convert<float>(p);
  for (int i = 0; i < bodies; ++i)
    if (crowd.bodies.inverse_mass[i].w == 0) crowd.bodies.motion[i].unused[0] = 7;  // so that a write to a static body would show
  return crowd;
}

void expect_same_bits(const SolverSettings& settings, const Problem<float>& problem) {
  Problem<float> original = problem, batched = problem;
  solve_original(settings, original);
  solve_batches(settings, batched);
  const Batches batches = serial::batches(problem.manifolds, problem.body, problem.bodies);
  for (const int threads : thread_counts) {
    omp_set_num_threads(threads);
    const auto expect = [&](const Problem<float>& expected, const Problem<float>& p, const char* form) {
      EXPECT_TRUE(same_bits(expected.bodies.motion, p.bodies.motion)) << form << ' ' << problem.manifolds.size() << ' ' << threads;
      EXPECT_TRUE(same_bits(expected.moving, p.moving)) << form << ' ' << problem.manifolds.size() << ' ' << threads;
      EXPECT_TRUE(same_bits(expected.impulses, p.impulses)) << form << ' ' << problem.manifolds.size() << ' ' << threads;
    };
    Problem<float> p = problem;
    openmp::contact_solver_original(settings, p.manifolds, p.body, p.bodies, p.impulses, p.moving);
    expect(original, p, "original");
    p = problem;
    openmp::contact_solver_batches(settings, p.manifolds, p.body, batches, p.bodies, p.impulses, p.moving);
    expect(batched, p, "batches");
  }
}

const SolverSettings as_usual{.time_step = 1 / 60., .gravity = {.1, -g, .2}};

TEST(ContactTwins, OfAnyNumberOfContacts) {
  expect_same_bits(as_usual, Problem<float>{});
  unsigned seed = 1;
  for (const int contacts : {0, 1, 2, 15, 16, 17, 33, 200}) expect_same_bits(as_usual, crowd(2 + contacts, contacts, .2, seed++));
  expect_same_bits({.time_step = .02, .gravity = {0, -g, 0}, .substeps = 2, .biased_sweeps = 2, .relax_sweeps = 3, .bounce_from = .1},
                   crowd(100, 300, .1, seed++));
  expect_same_bits({.time_step = .02, .gravity = {0, -g, 0}, .substeps = 1, .biased_sweeps = 0, .relax_sweeps = 0}, crowd(100, 300, .1, seed++));
}

TEST(ContactTwins, OfManyContactsAndMostlyStaticBodies) {
  expect_same_bits(as_usual, crowd(3000, 5000, 0, 21));
  expect_same_bits(as_usual, crowd(3000, 3000, .9, 22));
  expect_same_bits(as_usual, crowd(5000, 2000, .5, 23));
}

// Every contact waits for the one before it: batches and levels of one.
TEST(ContactTwins, OfOneBodyThatAllOthersTouch) {
  Problem<float> p = crowd(300, 300, 0, 31);
  for (std::size_t k = 0; k < p.manifolds.size(); ++k) p.manifolds[k].a = 0, p.manifolds[k].b = 2 + static_cast<std::int32_t>(k * 7 % 598);
  expect_same_bits(as_usual, p);
}

// --- Batches and levels. What first fit is, is tested in tests/cloth_test.cpp.

using Lists = std::vector<std::vector<std::int32_t>>;

Lists lists_of(const Batches& batches) {
  Lists lists;
  for (int k = 0; k < batches.count(); ++k)
    lists.emplace_back(batches.order.begin() + batches.begin[k], batches.order.begin() + batches.begin[k + 1]);
  return lists;
}

// C1 .. C4 are 0 .. 3. The papers take the ground b4 for a body like others; as a static one it changes nothing here.
TEST(ContactBatches, OfThePapersFourBodies) {
  const std::vector<std::int32_t> a = {0, 1, 2, 0}, b = {1, 2, 3, 3};
  const Lists expected = {{0, 2}, {1, 3}};
  EXPECT_EQ(lists_of(make_batches(a, b, std::vector<char>{1, 1, 1, 1})), expected);
  EXPECT_EQ(lists_of(make_batches(a, b, std::vector<char>{1, 1, 1, 0})), expected);
  const Problem<double> p = papers_bodies(0, {0, 0, 0});
  EXPECT_EQ(lists_of(serial::batches(p.manifolds, p.body, p.bodies)), expected);
  // In the original order C2 waits for C1, C3 for C2, and C4 for C1 and, if the ground counts, for C3.
  EXPECT_EQ(lists_of(make_levels(a, b, std::vector<char>{1, 1, 1, 1})), (Lists{{0}, {1}, {2}, {3}}));
  EXPECT_EQ(lists_of(make_levels(a, b, std::vector<char>{1, 1, 1, 0})), (Lists{{0}, {1, 3}, {2}}));
}

TEST(ContactBatches, AreAtMostTwiceTheDegreeAndHaveNoBodyTwice) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const Problem<float> p = crowd(20 + 10 * seed, 300, .04 * seed, seed);
    const Batches batches = serial::batches(p.manifolds, p.body, p.bodies);
    std::vector<int> degree(p.bodies.count), times(p.manifolds.size());
    for (const Manifold<float>& m : p.manifolds)
      for (const int body : {p.body[m.a], p.body[m.b]}) degree[body] += p.bodies.inverse_mass[body].w > 0;
    for (const std::vector<std::int32_t>& batch : lists_of(batches)) {
      EXPECT_TRUE(std::ranges::is_sorted(batch));
      std::set<int> seen;
      for (const std::int32_t k : batch) {
        ++times[k];
        for (const int body : {p.body[p.manifolds[k].a], p.body[p.manifolds[k].b]})
          EXPECT_TRUE(p.bodies.inverse_mass[body].w == 0 || seen.insert(body).second) << body;
      }
    }
    EXPECT_EQ(times, std::vector<int>(p.manifolds.size(), 1));
    EXPECT_LE(batches.count(), 2 * std::ranges::max(degree) - 1);
    for (const int threads : thread_counts) {
      omp_set_num_threads(threads);
      const Batches openmp = openmp::batches(p.manifolds, p.body, p.bodies);
      EXPECT_TRUE(openmp.order == batches.order && openmp.begin == batches.begin);
    }
  }
}

TEST(ContactLevels, AreAsEarlyAsTheOrderLets) {
  EXPECT_EQ(make_levels({}, {}, {}).count(), 0);
  std::mt19937 random(3);
  for (int graph = 0; graph < 30; ++graph) {
    const int objects = 2 + random() % 100, constraints = random() % 400;
    std::vector<char> movable(objects);
    for (char& m : movable) m = random() % 10 != 0;
    std::vector<std::int32_t> a, b;
    for (int k = 0; k < constraints; ++k) {
      a.push_back(random() % objects);
      b.push_back((a.back() + 1 + random() % (objects - 1)) % objects);
    }
    const Lists levels = lists_of(make_levels(a, b, movable));
    std::vector<int> level_of(constraints, -1);
    for (std::size_t level = 0; level < levels.size(); ++level) {
      EXPECT_TRUE(std::ranges::is_sorted(levels[level]));
      for (const std::int32_t k : levels[level]) {
        EXPECT_EQ(level_of[k], -1);
        level_of[k] = static_cast<int>(level);
      }
    }
    for (int k = 0; k < constraints; ++k) {
      int last = -1;  // level that k waits for
      for (int l = 0; l < k; ++l)
        for (const int i : {a[l], b[l]})
          if (movable[i] && (i == a[k] || i == b[k])) last = std::max(last, level_of[l]);
      EXPECT_EQ(level_of[k], last + 1);
    }
  }
}

// --- Free bodies

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
  // N substeps h: v = v0 - N g h, x = v0 N h - g h^2 N (N + 1) / 2. Each of N sums rounds once, and what it adds thrice.
  const double h = settings.time_step / settings.substeps, n = steps * settings.substeps, speed = g * n * h,
               way = g * h * h * n * (n + 1) / 2;
  EXPECT_NEAR(p.bodies.motion[0].velocity.y, 2 - speed, 4 * n * u * speed);
  EXPECT_NEAR(p.bodies.pose[0].position.y, 2 * n * h - way, 4 * n * u * way);
  EXPECT_NEAR(p.bodies.pose[0].position.x, n * h, 4 * n * u * n * h);
  EXPECT_EQ(p.bodies.pose[1].position.y, 0);  // static
  EXPECT_EQ(p.bodies.motion[1].velocity.y, 2);
}

Eigen::Quaterniond eigen(const Quaternion<double>& q) { return {q.w, q.x, q.y, q.z}; }

template <class Real>
struct Free {
  Eigen::Vector3d momentum;
  double energy;
  Free(const Problem<Real>& p) {
    const Pose<Real>& pose = p.bodies.pose[0];
    const Quad<Real>& inverse = p.bodies.inverse_mass[0];
    const Eigen::Matrix3d r =
        Eigen::Quaterniond(pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z).normalized().toRotationMatrix();
    const Eigen::Vector3d w = eigen(lockstep::convert<double>(p.bodies.motion[0].angular_velocity));
    const Eigen::Vector3d local = (r.transpose() * w).cwiseQuotient(Eigen::Vector3d(inverse.x, inverse.y, inverse.z));
    momentum = r * local;
    energy = w.dot(momentum) / 2;
  }
};

const Quaternion<double> askew = {.1, -.5, .3, std::sqrt(1 - .35)};

// Of a body with inertia A A C about its axes, the axis C goes round the angular momentum L by |L| / A, while the body turns about the axis
// by L_C (1 / C - 1 / A) besides.
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
  // Of second order: halving the step leaves a quarter, but for what is of third order, of relative size about the step times the speed.
  const double third_order = 2.6 * time / 200;
  EXPECT_NEAR(coarse / fine, 4, 4 * 2 * third_order);
  EXPECT_NEAR(fine / finest, 4, 4 * third_order);
  RecordProperty("error_rad", std::to_string(coarse));
  // A quarter of the step's angle squared, a step, is more than the midpoint rule and its normalisation leave out.
  EXPECT_LE(coarse, time / 4 * std::pow(2.6, 3) * std::pow(time / 200, 2));
}

// Three different inertias, turning about each axis, also the middle one, about which it tumbles.
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
  // A step turns L into w and back, 4 products with R or its transpose of 3 terms, whose entries are off by 4 roundings and by |q|^2 - 1, 6
  // more: 4 (3 + 10) = 52 roundings, of w times the largest inertia, which is as much as `most / least` |L|. They may go any way, and then
  // are no more than their number's square root together; if each step rounded the same way, this would show it.
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

// --- Contacts from step to step

// Some pairs of 40 colliders, with 1 to 4 points of different features, each about a place of its own feature.
template <class Real>
void some_contacts(std::mt19937& random, int every, Array<Manifold<Real>>& manifolds, Array<Impulses<Real>>& impulses) {
  std::uniform_real_distribution<Real> uniform(-1, 1);
  manifolds.clear(), impulses.clear();
  for (int a = 0; a < 40; ++a)
    for (int b = a + 1; b < 40; ++b) {
      if (random() % every != 0) continue;
      Manifold<Real>& m = manifolds.emplace_back();
      Impulses<Real>& i = impulses.emplace_back();
      m = {}, i = {};
      m.a = a, m.b = b, m.normal = {0, 1, 0}, m.count = 1 + random() % 4;
      std::vector<std::int32_t> features = {11, 12, 13, 14, 15, 16};
      std::ranges::shuffle(features, random);
      for (int k = 0; k < m.count; ++k) {
        m.feature[k] = features[k];
        m.point[k] = {{Real(.02) * uniform(random), Real(.02) * uniform(random), 0}, 0};
        i.normal[k] = uniform(random), i.tangent[k] = uniform(random), i.bitangent[k] = uniform(random);
      }
    }
}

// The contract, word for word.
template <class Real>
Array<Impulses<Real>> looked_up(const Array<Manifold<Real>>& last, const Array<Impulses<Real>>& from,
                                const Array<Manifold<Real>>& manifolds) {
  std::map<std::pair<int, int>, std::size_t> where;
  for (std::size_t j = 0; j < last.size(); ++j) where[{last[j].a, last[j].b}] = j;
  Array<Impulses<Real>> result;
  for (const Manifold<Real>& m : manifolds) {
    Impulses<Real>& impulses = result.emplace_back();
    impulses = {};
    if (!where.contains({m.a, m.b})) continue;
    const Manifold<Real>& old = last[where[{m.a, m.b}]];
    const Impulses<Real>& old_impulses = from[where[{m.a, m.b}]];
    std::map<int, int> source;  // of point k, the old point
    std::set<int> left;
    for (int j = 0; j < old.count; ++j) {
      const auto same = std::find(m.feature, m.feature + m.count, old.feature[j]);
      if (same < m.feature + m.count)
        source[static_cast<int>(same - m.feature)] = j;
      else
        left.insert(j);
    }
    for (int k = 0; k < m.count; ++k) {
      if (source.contains(k) || left.empty()) continue;
      const auto squared = [&](int j) {
        const Vector3<Real> off = m.point[k].position - old.point[j].position;
        return dot(off, off);
      };
      const int nearest = *std::ranges::min_element(left, {}, squared);
      if (squared(nearest) < static_cast<Real>(same_place * same_place)) source[k] = nearest, left.erase(nearest);
    }
    for (const auto& [k, j] : source)
      impulses.normal[k] = old_impulses.normal[j], impulses.tangent[k] = old_impulses.tangent[j],
      impulses.bitangent[k] = old_impulses.bitangent[j];
  }
  return result;
}

TEST(MatchContacts, FindsTheSamePairAndFeatureOrTheNearestPoint) {
  std::mt19937 random(5);
  for (const int last_every : {1, 2, 20, 1000})
    for (const int every : {1, 3, 20, 1000}) {
      Array<Manifold<float>> last, now;
      Array<Impulses<float>> from, unused;
      some_contacts(random, last_every, last, from);
      some_contacts(random, every, now, unused);
      const Array<Impulses<float>> expected = looked_up(last, from, now);
      const auto garbage = [&] { return Array<Impulses<float>>(now.size(), {{7, 7, 7, 7}, {7, 7, 7, 7}, {7, 7, 7, 7}, {7, 7, 7, 7}}); };
      Array<Impulses<float>> impulses = garbage();
      serial::match_contacts(last, from, now, impulses);
      EXPECT_TRUE(same_bits(impulses, expected)) << last_every << ' ' << every;
      for (const int threads : thread_counts) {
        omp_set_num_threads(threads);
        impulses = garbage();
        openmp::match_contacts(last, from, now, impulses);
        EXPECT_TRUE(same_bits(impulses, expected)) << last_every << ' ' << every << ' ' << threads;
      }
    }
}

}  // namespace
}  // namespace lockstep::rigid
