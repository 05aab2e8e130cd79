// Coarse levels of the face: aggregates, coarse matrices against Eigen's, and the inverses of their blocks.
#include "common/production_face/coarsening.h"

#include <cmath>

#include "tests/production_face_systems.h"

namespace lockstep::production_face {
namespace {

using linear::BlockRows;
using DoubleRoom = Multigrid<double, BlockRows<double>>;

linear::EigenRows eigen_of(const BlockRows<double>& a) { return linear::to_eigen(linear::scalar_rows(a)); }

// P of a level, from the definition.
linear::EigenRows prolongation(const CoarseLevel<double>& level) {
  std::vector<Eigen::Triplet<double>> entries;
  const int rows = 3 * level.parts;
  for (int i = 0; i < int(level.members()); ++i) {
    const int a = level.of[i];
    if (a < 0) continue;
    const double* const d = &level.arm[3 * std::size_t(i)];
    for (int c = 0; c < 3; ++c) {
      const int next = (c + 1) % 3, last = (c + 2) % 3;
      entries.emplace_back(rows * i + c, 6 * a + c, 1);
      entries.emplace_back(rows * i + c, 6 * a + 3 + next, d[last]);  // w x d
      entries.emplace_back(rows * i + c, 6 * a + 3 + last, -d[next]);
      if (level.parts == 2) entries.emplace_back(rows * i + 3 + c, 6 * a + 3 + c, 1);
    }
  }
  linear::EigenRows p(rows * int(level.members()), 6 * level.count());
  p.setFromTriplets(entries.begin(), entries.end());
  return p;
}

TEST(ProductionFaceCoarsening, AggregatesTakeEachFreeNodeOnce) {
  for (const char* name : {"twelve", "bar_shaken", "face_6k", "face_smile"}) {
    const FaceSystem s = system_of(name);
    ASSERT_FALSE(s.coarsening.level.empty());
    EXPECT_LE(s.coarsening.level.back().count(), most_at_last);
    for (std::size_t l = 0; l < s.coarsening.level.size(); ++l) {
      const auto& level = s.coarsening.level[l];
      ASSERT_EQ(level.members(), std::size_t(l ? s.coarsening.level[l - 1].count() : s.body.nodes));
      std::size_t members = 0;
      for (int a = 0; a < level.count(); ++a) {
        EXPECT_LT(level.first[a], level.first[a + 1]);
        for (int k = level.first[a]; k < level.first[a + 1]; ++k, ++members) {
          EXPECT_EQ(level.of[level.member[k]], a);
          if (k > level.first[a]) {
            EXPECT_LT(level.member[k - 1], level.member[k]);
          }
        }
      }
      for (std::size_t i = 0; i < level.members(); ++i) {
        const bool is_free = l > 0 || s.k.begin[i] < s.k.begin[i + 1];
        EXPECT_EQ(level.of[i] >= 0, is_free);
        members -= is_free;
      }
      EXPECT_EQ(members, 0u);
    }
  }
}

// Differences of arms are those of places over one length, and arms of nodes sum to 0. So P has the rigid motions.
TEST(ProductionFaceCoarsening, ArmsArePlacesFromTheCentre) {
  const FaceSystem s = system_of("face_6k");
  const auto& level = s.coarsening_in_double.level[0];
  // A place from its centre, over the length: three roundings, u = 2^-53 each, of the place and of the result. All
  // centres are means of places, each the mean of the one before and of another place: as many roundings as members.
  constexpr double u = 0x1p-53;
  double length = 0, of_length = 0, farthest = 0;
  int turning = 0;
  for (int n = 0; n < s.body.nodes; ++n) {
    const Vector3<double> x = {s.body.rest.x[n], s.body.rest.y[n], s.body.rest.z[n]};
    farthest = std::max(farthest, std::sqrt(dot(x, x)));
  }
  for (int a = 0; a < level.count(); ++a) {
    Vector3<double> sum = {};
    const auto arm = [&](int k) {
      const double* const d = &level.arm[3 * std::size_t(level.member[k])];
      return Vector3<double>{d[0], d[1], d[2]};
    };
    const auto place = [&](int k) {
      const int n = level.member[k];
      return Vector3<double>{s.body.rest.x[n], s.body.rest.y[n], s.body.rest.z[n]};
    };
    const int first = level.first[a];
    for (int k = first; k < level.first[a + 1]; ++k) {
      sum = sum + arm(k);
      const Vector3<double> of_arms = arm(k) - arm(first), of_places = place(k) - place(first);
      if (dot(of_arms, of_arms) == 0) continue;
      const double distance = std::sqrt(dot(of_places, of_places));
      // The length is measured by one pair, whose arms are off by 4 u of the farthest place.
      if (length == 0) length = distance / std::sqrt(dot(of_arms, of_arms)), of_length = 8 * u * farthest / distance;
      const Vector3<double> off = length * of_arms - of_places;
      EXPECT_LE(std::sqrt(dot(off, off)), 8 * u * farthest + 2 * of_length * distance);
      ++turning;
    }
    const int members = level.first[a + 1] - first;
    if (length > 0) {
      EXPECT_LE(length * std::sqrt(dot(sum, sum)), 8 * u * members * members * farthest) << a;
    }
  }
  EXPECT_GT(turning, 1000);
  EXPECT_GT(length, .001);
}

// A sum of n products in double is off by at most n u of their sizes, u = 2^-53. Each entry of P^T K P is a sum over
// the entries of two columns of P and of their rows of K, and each product has two roundings more; Eigen's likewise.
TEST(ProductionFaceCoarsening, CoarseMatricesAreGalerkins) {
  for (const char* name : {"twelve", "bar_shaken", "face_smile"}) {
    const FaceSystem s = system_of(name);
    DoubleRoom room = serial::make_multigrid(s.coarsening_in_double, s.k_in_double);
    serial::set_coarse(s.coarsening_in_double, s.k_in_double, room);
    linear::EigenRows fine = eigen_of(s.k_in_double);
    for (std::size_t l = 0; l < room.level.size(); ++l) {
      const linear::EigenRows p = prolongation(s.coarsening_in_double.level[l]);
      const linear::EigenRows expected = p.transpose() * (fine * p), a = eigen_of(room.level[l].a);
      const linear::EigenRows sizes = p.cwiseAbs().transpose() * (fine.cwiseAbs() * p.cwiseAbs());
      linear::EigenRows ones = fine, ones_p = p;
      for (double& e : std::span(ones.valuePtr(), ones.nonZeros())) e = 1;
      for (double& e : std::span(ones_p.valuePtr(), ones_p.nonZeros())) e = 1;
      const linear::EigenRows counts = ones_p.transpose() * (ones * ones_p);
      const Eigen::MatrixXd bound =
          2 * 0x1p-53 * Eigen::MatrixXd(sizes).cwiseProduct((Eigen::MatrixXd(counts).array() + 2).matrix());
      EXPECT_TRUE(((Eigen::MatrixXd(expected) - Eigen::MatrixXd(a)).cwiseAbs().array() <= bound.array()).all()) << name;
      EXPECT_EQ((a - linear::EigenRows(a.transpose())).norm(), 0) << name;
      fine = a;
    }
  }
}

// --- The inverse of a 6x6 block

// L D L^T is A but for 7 u of |L| D |L^T|, which is no longer than 6 |A|; that makes 42 u cond(A) of the inverse.
// L^-1 is off by 6 u of |L^-1| |L| |L^-1|, once on either side: 2 6 6^2 = 432 u cond(A). The sum of six: 8 u of |L^-T|
// D^-1 |L^-1|, no longer than 6 times the inverse: 48 u. (Higham, Accuracy and Stability of Numerical Algorithms, 8 and
// 10.) Eigen's inverse is off by no more.
TEST(ProductionFaceCoarsening, SmoothersAreHalfTheInverse) {
  const Array<double> random = linear::random_vector<double>(36 * 200, 8);
  for (int n = 0; n < 200; ++n) {
    const Eigen::Matrix<double, 6, 6> g = Eigen::Map<const Eigen::Matrix<double, 6, 6>>(&random[36 * std::size_t(n)]);
    Eigen::Matrix<double, 6, 6> a = g * g.transpose() + .01 * Eigen::Matrix<double, 6, 6>::Identity();
    const int without = n % 7;  // a row that is not there; or all are
    if (without < 6) a.row(without).setZero(), a.col(without).setZero();
    Block6<double> block;
    for (int i = 0; i < 36; ++i) block.e[i / 6][i % 6] = a(i / 6, i % 6);
    const Block6<double> got = smoother_of(block);
    if (without < 6) a(without, without) = 1;
    Eigen::Matrix<double, 6, 6> expected = .5 * a.inverse();
    if (without < 6) expected(without, without) = 0;
    const double condition = a.norm() * a.inverse().norm(), bound = 2 * 522 * 0x1p-53 * condition * expected.norm();
    for (int i = 0; i < 36; ++i) EXPECT_NEAR(got.e[i / 6][i % 6], expected(i / 6, i % 6), bound);
  }
}

// A sum of squares of L^-1's rows over positive pivots, but for its own roundings: 8 u of sums of sizes, which are no
// more than the trace.
TEST(ProductionFaceCoarsening, SmoothersOfOtherBlocksAreSemidefinite) {
  const Array<double> random = linear::random_vector<double>(36 * 200, 9);
  for (int n = 0; n < 200; ++n) {
    Block6<double> block;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j <= i; ++j) block.e[i][j] = block.e[j][i] = random[36 * std::size_t(n) + 6 * i + j];
    const Block6<double> got = smoother_of(block);
    Eigen::Matrix<double, 6, 6> a;
    for (int i = 0; i < 36; ++i) a(i / 6, i % 6) = got.e[i / 6][i % 6];
    EXPECT_GE(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(a).eigenvalues().minCoeff(), -8 * 0x1p-53 * a.trace());
  }
}

}  // namespace
}  // namespace lockstep::production_face
