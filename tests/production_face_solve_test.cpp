// The linear system of a step of Newton's method: against direct solutions by CHOLMOD, at its ends, and with the serial
// bits.
#include "common/production_face/solve.h"

#include <cmath>
#include <limits>

#include "common/linear/multiply.h"
#include "common/production_face/assemble.h"
#include "common/production_face/scene.h"
#include "common/production_face/update_state.h"
#include "tests/linear_cholmod.h"
#include "tests/linear_matrices.h"

namespace lockstep::production_face {
namespace {

using linear::BlockRows;
using linear::Solution;
using linear::Stop;

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

Scene scene_of(const std::string& name) { return load_scene("scenes/production_face/" + name + ".toml"); }

// K of a scene's strained body, held where `is_held` says so of a node's place at rest.
BlockRows<float> stiffness(const std::string& name, bool definite, const auto& is_held) {
  Scene scene = scene_of(name);
  for (int n = 0; n < scene.body.nodes; ++n)
    if (is_held(load(scene.body.rest, n))) scene.body.held.push_back(n);
  Strained<float> strained = make_strained(scene.body);
  openmp::update_state(scene.body, scene.flesh, scene.pose, definite, strained);
  const Pattern pattern = make_pattern(scene.body);
  auto k = make_block_rows<float>(pattern);
  serial::assemble(scene.body, strained, pattern, k);
  return k;
}
constexpr auto at_wall = [](const Vector3<float>& place) { return place.x == 0; };

// Random, and 0 at held nodes.
Array<float> right_side(const BlockRows<float>& k, int seed) {
  Array<float> b = linear::random_vector<float>(3 * std::size_t(k.rows), seed);
  for (int i = 0; i < k.rows; ++i)
    if (k.begin[i] == k.begin[i + 1])
      for (int c = 0; c < 3; ++c) b[3 * std::size_t(i) + c] = 0;
  return b;
}

// The rows of free nodes without the columns of held ones.
BlockRows<float> of_free_nodes(const BlockRows<float>& k) {
  Array<std::int32_t> number;
  int free = 0;
  for (int i = 0; i < k.rows; ++i) number.push_back(k.begin[i] < k.begin[i + 1] ? free++ : -1);
  BlockRows<float> a;
  a.rows = a.columns = free;
  for (int i = 0; i < k.rows; ++i) {
    if (number[i] < 0) continue;
    for (int p = k.begin[i]; p < k.begin[i + 1]; ++p) {
      if (number[k.column[p]] < 0) continue;
      a.column.push_back(number[k.column[p]]);
      a.value.insert(a.value.end(), &k.value[9 * std::size_t(p)], &k.value[9 * std::size_t(p)] + 9);
    }
    a.begin.push_back(static_cast<int>(a.column.size()));
  }
  return a;
}
template <class Real>
Array<Real> of_free_nodes(const BlockRows<float>& k, const Array<Real>& x) {
  Array<Real> free;
  for (int i = 0; i < k.rows; ++i)
    if (k.begin[i] < k.begin[i + 1]) free.insert(free.end(), &x[3 * std::size_t(i)], &x[3 * std::size_t(i)] + 3);
  return free;
}

double norm(const auto& x) { return linear::to_eigen(x).norm(); }

void expect_same(const Solution& a, const Solution& b) {
  EXPECT_EQ(a.iterations, b.iterations);
  EXPECT_EQ(a.recursive_residual, b.recursive_residual);
  EXPECT_EQ(a.true_residual, b.true_residual);
}

// Both versions, at several numbers of threads; the serial answer.
Solution solve_in_both(const BlockRows<float>& k, const Array<float>& b, const Stop& stop, bool preconditioned,
                       Array<float>& x) {
  x.assign(b.size(), nan);
  const Solution solution =
      preconditioned ? serial::solve_block_jacobi(k, b, stop, x) : serial::solve_plain(k, b, stop, x);
  const linear::SlicedBlockRows sliced = linear::slice(k);
  const auto same = [&] {
    Array<float> y(b.size() + 2, 77);
    const auto solve = preconditioned ? openmp::solve_block_jacobi : openmp::solve_plain;
    expect_same(solve(sliced, b, stop, std::span(y).first(b.size())), solution);
    EXPECT_TRUE(linear::same_bits(std::span(y).first(b.size()), x));
    EXPECT_EQ(y[b.size()], 77);
  };
  linear::at_each_thread_count(same);
  omp_set_num_threads(4), same(), omp_set_num_threads(omp_get_num_procs());
  return solution;
}

TEST(ProductionFaceSolve, HasTheSerialBits) {
  for (const char* name : {"twelve", "bar_shaken", "inside_out"})
    for (const bool preconditioned : {false, true}) {
      const auto k = stiffness(name, true, at_wall);
      Array<float> x;
      const Solution s = solve_in_both(k, right_side(k, 1), {1e-3, 60}, preconditioned, x);
      EXPECT_GT(s.iterations, 0);
      for (int i = 0; i < k.rows; ++i)
        if (k.begin[i] == k.begin[i + 1]) {
          EXPECT_EQ(x[3 * std::size_t(i)], 0);
        }
    }
}

TEST(ProductionFaceSolve, TheTrueResidualIsTheTrueOne) {
  const auto k = stiffness("bar_shaken", true, at_wall);
  const Array<float> b = right_side(k, 2);
  for (const double tolerance : {1e-1, 1e-3, 1e-12}) {
    Array<float> x(b.size());
    const Solution s = serial::solve_block_jacobi(k, b, {tolerance, 3000}, x);
    const double truth = linear::residual_norm(k, std::span<const float>(b), std::span<const float>(x)) / norm(b);
    // Each element of r rounds once to float, and so does |r|, relative to itself.
    EXPECT_NEAR(s.true_residual, truth, 0x1.01p-24 * truth) << tolerance;
    if (tolerance < 1e-9) {
      EXPECT_GT(s.true_residual, 2 * s.recursive_residual);  // beyond what float can reach, it says so
    }
  }
}

// A load that is even all over: x is large for its forces, and x in float alone stalls at .015 of it.
TEST(ProductionFaceSolve, ReachesTheToleranceInTruth) {
  const auto k = stiffness("bar_shaken", true, at_wall);
  Array<float> b = right_side(k, 7);
  for (std::size_t i = 0; i < b.size(); ++i)
    if (b[i] != 0) b[i] = i % 3 == 1 ? -1 : 0;
  Array<float> x(b.size());
  const Solution s = serial::solve_block_jacobi(k, b, {1e-3, 3000}, x);
  EXPECT_LE(s.recursive_residual, 1e-3);
  // The rounding of x: u |K| |x|, of absolute values.
  BlockRows<float> sizes = k;
  for (float& e : sizes.value) e = std::abs(e);
  Array<float> rounding(b.size());
  for (float& e : x) e = std::abs(e);
  linear::serial::multiply(sizes, x, rounding);
  EXPECT_LE(s.true_residual, s.recursive_residual + 0x1p-24 * norm(rounding) / norm(b));
}

// In double: |x - x*| <= |K^-1| |b - K x|, with |K^-1| from Eigen's eigenvalues.
TEST(ProductionFaceSolve, IsCholmodsSolution) {
  const auto k = stiffness("twelve", true, at_wall);
  const auto free = of_free_nodes(k);
  const Array<float> b = right_side(k, 3);
  const Array<double> expected = linear::DirectSolver(linear::scalar_rows(free))(of_free_nodes(k, b));
  const double least =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(Eigen::MatrixXd(linear::to_eigen(linear::scalar_rows(free))))
          .eigenvalues()
          .minCoeff();
  const Array<double> b2 = lockstep::convert<double>(b);
  for (const auto solve : {static_cast<Solve<BlockRows<double>, double>*>(serial::solve_plain),
                           static_cast<Solve<BlockRows<double>, double>*>(serial::solve_block_jacobi)}) {
    Array<double> x(b.size());
    const Solution s = solve(linear::convert<double>(k), b2, {1e-9, 1000}, x);
    EXPECT_LE(s.true_residual, 1e-9 * (1 + 1e-3));
    const Eigen::VectorXd off = linear::to_eigen(of_free_nodes(k, x)) - linear::to_eigen(expected);
    EXPECT_LE(off.norm(), 1.01e-9 * norm(b) / least);
  }
}

TEST(ProductionFaceSolve, BlockJacobiNeedsFewerIterations) {
  const auto k = stiffness("bar_shaken", true, at_wall);
  const Array<float> b = right_side(k, 4);
  Array<float> x(b.size());
  const int plain = serial::solve_plain(k, b, {1e-3, 5000}, x).iterations;
  const int preconditioned = serial::solve_block_jacobi(k, b, {1e-3, 5000}, x).iterations;
  EXPECT_LT(preconditioned, plain / 3);
}

TEST(ProductionFaceSolve, OfNothingIsNothing) {
  const auto k = stiffness("twelve", true, at_wall);
  Array<float> x;
  for (const bool preconditioned : {false, true}) {
    const Array<float> zero(3 * std::size_t(k.rows), 0);
    expect_same(solve_in_both(k, zero, {}, preconditioned, x), Solution{});
    EXPECT_EQ(x, zero);
    const auto held = stiffness("twelve", true, [](const auto&) { return true; });
    expect_same(solve_in_both(held, zero, {}, preconditioned, x), Solution{});
    EXPECT_EQ(x, zero);
    expect_same(solve_in_both(BlockRows<float>{}, {}, {}, preconditioned, x), Solution{});
  }
}

// The middle of the cell alone is free: its block's inverse is the answer.
TEST(ProductionFaceSolve, OneFreeNodeNeedsOneIteration) {
  const auto k = stiffness("twelve", true, [](const Vector3<float>& p) { return p.x != .0025f; });
  ASSERT_EQ(of_free_nodes(k).rows, 1);
  const Array<float> b = right_side(k, 5);
  Array<float> x;
  const Solution s = solve_in_both(k, b, {1e-5, 10}, true, x);
  EXPECT_EQ(s.iterations, 1);
  EXPECT_LE(s.true_residual, 1e-5);
  EXPECT_LE(solve_in_both(k, b, {1e-3, 10}, false, x).iterations, 4);
}

BlockRows<float> diagonal_blocks(const Array<Array<float>>& blocks) {
  BlockRows<float> k;
  for (const Array<float>& block : blocks) {
    k.column.push_back(k.rows++);
    k.value.insert(k.value.end(), block.begin(), block.end());
    k.begin.push_back(k.rows);
  }
  k.columns = k.rows;
  return k;
}

TEST(ProductionFaceSolve, OfAnIndefiniteMatrixStopsAndSaysSo) {
  const auto k = diagonal_blocks({{2, 0, 0, 0, 3, 0, 0, 0, 4}, {-1, 0, 0, 0, 1, 0, 0, 0, 1}});
  for (const bool preconditioned : {false, true}) {
    Array<float> x;
    const Solution s = solve_in_both(k, {0, 0, 0, 1, 0, 0}, {}, preconditioned, x);
    EXPECT_EQ(s.iterations, 0);
    EXPECT_EQ(s.recursive_residual, 1);
    EXPECT_EQ(s.true_residual, 1);
    EXPECT_EQ(x, Array<float>(6, 0));
  }
}

// --- The inverse of a block

SymmetricBlock<float> block_of_matrix(const Eigen::Matrix3d& a) {
  SymmetricBlock<float> block;
  for (int c = 0; c < 3; ++c) block.diagonal[c] = float(a(c, c)), block.next[c] = float(a(c, (c + 1) % 3));
  return block;
}
Eigen::Matrix3d matrix_of_block(const SymmetricBlock<float>& block) {
  Eigen::Matrix3d a;
  for (int c = 0; c < 3; ++c) a(c, c) = block.diagonal[c], a(c, (c + 1) % 3) = a((c + 1) % 3, c) = block.next[c];
  return a;
}

// A cofactor of a block of trace 1 is wrong by a few u, the determinant likewise, and the determinant is at least the
// product of the eigenvalues: an inverse's error is below 16 u / determinant, in units of the trace.
TEST(ProductionFaceSolve, InvertsDefiniteBlocks) {
  const Array<float> random = linear::random_vector<float>(9 * 1000, 6);
  for (const double scale : {1e-25, 1., 1e30})
    for (int n = 0; n < 1000; ++n) {
      const Eigen::Matrix3d g = Eigen::Map<const Eigen::Matrix3f>(&random[9 * std::size_t(n)]).cast<double>();
      const Eigen::Matrix3d a =
          matrix_of_block(block_of_matrix(scale * (g * g.transpose() + .01 * Eigen::Matrix3d::Identity())));
      const Eigen::Matrix3d inverted = matrix_of_block(inverse(block_of_matrix(a)));
      const double trace = a.trace(), determinant = (a / trace).determinant();
      const double of_inverse = 1 + (a / trace).inverse().norm();
      EXPECT_LE((inverted * trace - (a / trace).inverse()).norm(), 16 * 0x1p-24 * of_inverse / determinant);
    }
}

TEST(ProductionFaceSolve, GivesOtherBlocksTheirSize) {
  const Eigen::Vector3d diagonals[] = {{1, 2, -3}, {-1, -1, -1}, {1, 0, 1}};
  for (const Eigen::Vector3d& d : diagonals) {
    const Eigen::Matrix3d inverted = matrix_of_block(inverse(block_of_matrix(d.asDiagonal())));
    // The sum of sizes, its reciprocal and a product round once each.
    EXPECT_LE((inverted - Eigen::Matrix3d::Identity() / d.cwiseAbs().sum()).norm(), 3 * 0x1p-24 * std::sqrt(3.));
  }
  EXPECT_EQ(matrix_of_block(inverse(SymmetricBlock<float>{})).norm(), 0);
}

}  // namespace
}  // namespace lockstep::production_face
