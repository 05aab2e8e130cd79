// What rounding may do to the stiffness matrix: against double, its definiteness, its null space.
//
// An entry of a tetrahedron's K_ac is a sum of products of the arrays' numbers. None of these is rounded more than 21
// times on its way: by the volume (1), V^T gradient of both corners (6), their product (1) and that with the derivative
// (1), M's sums (2), U M U^T (6), the sums of two fibres (2), the sum for corner 0 (2). A fibre's products are rounded
// less often. Then tetrahedra around two nodes are added up, and blocks of a row for the diagonal. So, to first order,
// an entry is off by at most so many u of its products' sizes. The same formulas make these of the sizes of all
// numbers.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "common/linear/matrix.h"
#include "common/production_face/assemble.h"
#include "tests/linear_matrices.h"
#include "tests/production_face_bodies.h"

namespace lockstep::production_face {
namespace {

using Dense = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

constexpr double u = 0x1p-24;

linear::BlockRows<float> stiffness(const Scene& scene, const Strained<float>& s) {
  const Pattern pattern = make_pattern(scene.body);
  auto k = make_block_rows<float>(pattern);
  serial::assemble(scene.body, s, pattern, k);
  return k;
}

Strained<double> in_double(const Body<double>& body, const Strained<float>& narrow) {
  Strained<double> wide = make_strained(body);
  std::ranges::copy(narrow.u.value, wide.u.value.begin());
  std::ranges::copy(narrow.v.value, wide.v.value.begin());
  std::ranges::copy(narrow.derivative.value, wide.derivative.value.begin());
  std::ranges::copy(narrow.pull.value, wide.pull.value.begin());
  return wide;
}

// The sizes of the products of a tetrahedron's blocks; those of corners with themselves are not made.
ElementStiffness<double> sizes_of_products(const Body<double>& body, const Strained<double>& s, int t) {
  const auto size_in = [](int place) {
    return [=](const Blocked<double>& array, int k) { return std::abs(array.at(place, k)); };
  };
  const auto e = strained_element<double>(body, s, size_in(t));
  ElementStiffness<double> sizes;
  set_flesh_stiffness(e, sizes);
  for (int slot = body.first_fibre[t / lanes]; slot < body.first_fibre[t / lanes + 1]; ++slot)
    add_fibre_stiffness(e, strained_fibre<double>(body, s, size_in(slot * lanes + t % lanes)), sizes);
  set_first_corner(sizes);
  for (auto& block : sizes.block)
    for (double& size : block) size = std::abs(size);
  return sizes;
}

// Calls f(i, j, row, column, error) for each two nodes of each tetrahedron. The errors of an entry add up. Those of a
// diagonal block are the sum of those of its row.
template <class F>
void for_each_error(const Scene& scene, const Strained<float>& narrow, const F& f) {
  const Body<double> body = in_double(scene.body);
  const Strained<double> s = in_double(body, narrow);
  const Pattern pattern = make_pattern(scene.body);
  std::vector<int> around(body.nodes, 0);
  for (int t = 0; t < body.tetrahedra; ++t)
    for (int a = 0; a < 4; ++a) ++around[body.corner.at(t, a)];
  for (int t = 0; t < body.tetrahedra; ++t) {
    const ElementStiffness<double> sizes = sizes_of_products(body, s, t);
    for (int a = 0; a < 4; ++a)
      for (int c = 0; c < 4; ++c) {
        if (a == c) continue;
        const int i = body.corner.at(t, a), j = body.corner.at(t, c);
        const int roundings = 21 + around[i] + pattern.begin[i + 1] - pattern.begin[i];
        for (int e = 0; e < 9; ++e) f(i, j, e / 3, e % 3, roundings * u * sizes.at(a, c, e / 3, e % 3));
      }
  }
}

TEST(ProductionFaceRounding, IsAllThatFloatAndDoubleDifferBy) {
  const Scene scene = tetrahedra(40, .0004);
  const Body<double> body = in_double(scene.body);
  const Pattern pattern = make_pattern(body);
  for (const bool definite : {false, true}) {
    const Strained<float> s = strained(scene.body, scene.flesh, scene.pose, definite);
    auto truth = make_block_rows<double>(pattern);
    serial::assemble(body, in_double(body, s), pattern, truth);
    Dense bound = Dense::Zero(3 * body.nodes, 3 * body.nodes);
    for_each_error(scene, s, [&](int i, int j, int row, int column, double error) {
      bound(3 * i + row, 3 * j + column) += error, bound(3 * i + row, 3 * i + column) += error;
    });
    const Dense k = linear::to_dense(stiffness(scene, s)), off = k - linear::to_dense(truth);
    EXPECT_TRUE((off.cwiseAbs().array() <= bound.array()).all());
    EXPECT_LT(bound.norm(), 1e-4 * k.norm()) << "the bound says something";
  }
}

// How far tetrahedra's forms may be below zero, of displacements x.
double off_definite(const Scene& scene, const Strained<float>& s, const Vector& x) {
  const Body<float>& body = scene.body;
  double off = 0;
  for (int t = 0; t < body.tetrahedra; ++t) {
    Eigen::Matrix3d df = Eigen::Matrix3d::Zero();
    for (int a = 0; a < 3; ++a) {
      const Eigen::Vector3d gradient(body.gradient.at(t, 3 * a), body.gradient.at(t, 3 * a + 1),
                                     body.gradient.at(t, 3 * a + 2));
      df +=
          (x.segment<3>(3 * body.corner.at(t, a + 1)) - x.segment<3>(3 * body.corner.at(t, 0))) * gradient.transpose();
    }
    double squares = 0, pulls = 0;
    for (int k = 0; k < 6; ++k) squares += (k < 3 ? 1 : 2) * std::pow(s.derivative.at(t, k), 2);
    for (int slot = body.first_fibre[t / lanes]; slot < body.first_fibre[t / lanes + 1]; ++slot)
      pulls += s.pull.at(slot * lanes + t % lanes, 3);
    off += body.volume.at(t, 0) * u * (13 * std::sqrt(squares) + 8 * pulls) * df.squaredNorm();
  }
  return off;
}

// The form of a tetrahedron's strains is definite but for 13 u of the flesh's block and 8 u of its fibres' pulls
// (production_face_update_state_test). K's entries round besides. Held nodes have no rows, and x is 0 there.
TEST(ProductionFaceRounding, LeavesDefiniteWhatStrainsMakeSo) {
  for (const char* name : {"twelve", "bar_shaken", "inside_out"}) {
    const Scene scene = scene_of(name);
    const Strained<float> s = strained(scene.body, scene.flesh, scene.pose, true);
    const auto k = linear::convert<double>(stiffness(scene, s));
    double most = 0;  // the greatest sum of a row, at least |K|
    for (int i = 0; i < k.rows; ++i) {
      double sum = 0;
      for (std::size_t e = 9 * std::size_t(k.begin[i]); e < 9 * std::size_t(k.begin[i + 1]); ++e)
        sum += std::abs(k.value[e]);
      most = std::max(most, sum);
    }
    std::mt19937 random(2);
    std::normal_distribution<double> normal;
    for (int trial = 0; trial < 20; ++trial) {
      Vector x(3 * k.rows), y = Vector::Zero(3 * k.rows);
      for (double& e : x) e = normal(random);
      for (const int node : scene.body.held) x.segment<3>(3 * node).setZero();
      // Steps against the gradient go where K is weakest.
      for (int step = 0; step < 10; ++step) {
        y.setZero();
        for (int i = 0; i < k.rows; ++i)
          for (int b = k.begin[i]; b < k.begin[i + 1]; ++b)
            for (int e = 0; e < 9; ++e)
              y[3 * i + e / 3] += k.value[9 * std::size_t(b) + e] * x[3 * k.column[b] + e % 3];
        double bound = off_definite(scene, s, x);
        for_each_error(scene, s, [&](int i, int j, int row, int column, double error) {
          bound += error * std::abs(x[3 * i + row]) * (std::abs(x[3 * j + column]) + std::abs(x[3 * i + column]));
        });
        ASSERT_GE(x.dot(y), -bound) << name;
        ASSERT_LE(bound, 1e-4 * most * x.squaredNorm()) << "the bound says something";
        x -= 1 / most * y;
      }
    }
  }
}

// At rest U is V, and the stress 0. A turn W strains nothing but by the rounding of gradients, u of each, and by that
// of alpha and beta, which are equal: 16 u of the terms they are made of, 2 (m10 + 2 m01) and the parts of the
// pressure. Entries of K round besides.
TEST(ProductionFaceRounding, LeavesRigidMotionsInTheNullSpace) {
  Scene scene = scene_of("twelve");
  for (Array<float>* component : {&scene.pose.displacement.x, &scene.pose.displacement.y, &scene.pose.displacement.z})
    std::ranges::fill(*component, 0.f);
  std::ranges::fill(scene.pose.activation, 0.f);
  scene.body.held.clear();
  const Body<float>& body = scene.body;
  const Strained<float> s = strained(scene.body, scene.flesh, scene.pose, false);
  const Dense k = linear::to_dense(stiffness(scene, s));
  const auto vector_at = [](const Blocked<float>& array, int t, int a) {
    return Eigen::Vector3d(array.at(t, 3 * a), array.at(t, 3 * a + 1), array.at(t, 3 * a + 2));
  };
  const auto rest_of = [&](int n) {
    const Vector3<float> at = load(body.rest, n);
    return Eigen::Vector3d(at.x, at.y, at.z);
  };
  Dense motions = Dense::Zero(3 * body.nodes, 6), bounds = motions;
  for (int motion = 0; motion < 6; ++motion) {
    const Eigen::Vector3d axis = Eigen::Vector3d::Unit(motion % 3);
    auto x = motions.col(motion), bound = bounds.col(motion);
    for (int n = 0; n < body.nodes; ++n) x.segment<3>(3 * n) = motion < 3 ? axis : axis.cross(rest_of(n));
    for_each_error(scene, s, [&](int i, int j, int row, int column, double error) {
      bound[3 * i + row] += error * (std::abs(x[3 * j + column]) + std::abs(x[3 * i + column]));
    });
    if (motion < 3) continue;
    for (int t = 0; t < body.tetrahedra; ++t) {
      double derivative = 0, strain = 0, terms = 2 * (scene.flesh.m10 + 2 * scene.flesh.m01);
      terms += 2. / 3 * (3 * scene.flesh.m10 + 6 * scene.flesh.m01);
      for (int e = 0; e < 12; ++e) derivative += 2 * std::pow(s.derivative.at(t, e), 2);  // each stands twice
      Eigen::Vector3d gradient[4] = {{0, 0, 0}};
      for (int a = 1; a < 4; ++a) {
        gradient[a] = vector_at(body.gradient, t, a - 1);
        gradient[0] -= gradient[a];
        strain += u * gradient[a].norm() * (rest_of(body.corner.at(t, a)) - rest_of(body.corner.at(t, 0))).norm();
      }
      const double stress = std::sqrt(2) * (std::sqrt(derivative) * strain + 16 * u * terms);  // |W| is sqrt 2
      for (int a = 0; a < 4; ++a)
        bound.segment<3>(3 * body.corner.at(t, a)).array() += body.volume.at(t, 0) * stress * gradient[a].norm();
    }
  }
  EXPECT_TRUE(((k * motions).cwiseAbs().array() <= bounds.array()).all());
  // Of the six motions as columns of a matrix with orthogonal columns, K makes no more than this.
  const Dense r = Eigen::HouseholderQR<Dense>(motions).matrixQR().topRows(6).triangularView<Eigen::Upper>();
  const double most = bounds.norm() * r.inverse().norm();
  const Vector values = Eigen::SelfAdjointEigenSolver<Dense>(k).eigenvalues();
  EXPECT_LE(values.head(6).cwiseAbs().maxCoeff(), most);
  EXPECT_GT(values[6], most) << "no other motion is without force";
}

}  // namespace
}  // namespace lockstep::production_face
