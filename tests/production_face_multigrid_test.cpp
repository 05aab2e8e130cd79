// Multigrid for the solve of the face: the cycle as a preconditioner, what it is worth, and the solve at its ends.
#include "common/production_face/multigrid.h"

#include <cmath>
#include <cstdio>
#include <limits>

#include "common/linear/multiply.h"
#include "common/production_face/solve.h"
#include "tests/linear_cholmod.h"
#include "tests/production_face_systems.h"

namespace lockstep::production_face {
namespace {

using linear::BlockRows;
using linear::Solution;
using linear::Stop;
using SerialRoom = Multigrid<double, BlockRows<double>>;

// M^-1 r from its definition, by the serial corrections.
Array<double> cycle_of(const FaceSystem& s, SerialRoom& room, const Array<double>& r) {
  Array<double> z(r.size(), 0), product(r.size()), rest = r;
  const auto smooth = [&] {
    for (int i = 0; i < s.k.rows; ++i)
      for (int p = s.k.begin[i]; p < s.k.begin[i + 1]; ++p) {
        if (s.k.column[p] != i) continue;
        const Eigen::Matrix3d block = Eigen::Map<const Eigen::Matrix3d>(&s.k_in_double.value[9 * std::size_t(p)]);
        const Eigen::Vector3d step =
            .5 * (block.inverse() * Eigen::Map<const Eigen::Vector3d>(&rest[3 * std::size_t(i)]));
        for (int c = 0; c < 3; ++c) z[3 * std::size_t(i) + c] += step[c];
      }
    linear::serial::multiply(s.k_in_double, linear::view(z), std::span(product));
    for (std::size_t i = 0; i < r.size(); ++i) rest[i] = r[i] - product[i];
    for (int i = 0; i < s.k.rows; ++i)
      if (s.k.begin[i] == s.k.begin[i + 1])
        for (int c = 0; c < 3; ++c) rest[3 * std::size_t(i) + c] = 0;
  };
  smooth();
  serial::correct(s.coarsening_in_double, rest, z, room);
  linear::serial::multiply(s.k_in_double, linear::view(z), std::span(product));
  for (std::size_t i = 0; i < r.size(); ++i) rest[i] = r[i] - product[i];
  smooth();
  return z;
}

double dot_of(const Array<double>& x, const Array<double>& y) { return linear::to_eigen(x).dot(linear::to_eigen(y)); }

// The greatest condition of a block that is inverted, rows of 0 apart.
double greatest_condition(const FaceSystem& s, const SerialRoom& room) {
  double greatest = 1;
  const auto take = [&](const Eigen::MatrixXd& block) {
    const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(block).eigenvalues();
    const double size = values.maxCoeff();
    double least = size;
    for (const double e : values)
      if (e > 1e-12 * size) least = std::min(least, e);
    if (size > 0) greatest = std::max(greatest, size / least);
  };
  for (int i = 0; i < s.k.rows; ++i)
    for (int p = s.k.begin[i]; p < s.k.begin[i + 1]; ++p)
      if (s.k.column[p] == i) take(Eigen::Map<const Eigen::Matrix3d>(&s.k_in_double.value[9 * std::size_t(p)]));
  for (const auto& m : room.level)
    for (int a = 0; a < m.a.rows; a += 2) {
      Eigen::Matrix<double, 6, 6> block;
      for (int row = 0; row < 2; ++row)
        for (int p = m.a.begin[a + row]; p < m.a.begin[a + row + 1]; ++p)
          if (m.a.column[p] / 2 == a / 2)
            for (int e = 0; e < 9; ++e)
              block(3 * row + e / 3, 3 * (m.a.column[p] % 2) + e % 3) = m.a.value[9 * std::size_t(p) + e];
      take(block);
    }
  take(Eigen::MatrixXd(linear::to_eigen(linear::scalar_rows(room.level.back().a))));
  return greatest;
}

// One after another: two smoothings and two products of nodes, and of each coarse level five of both, twice as often as
// of the one before. A product rounds once for each of three entries a block, an inverse of a block 6 times.
double roundings_of_cycle(const FaceSystem& s, const SerialRoom& room) {
  const auto longest = [](const BlockRows<double>& a) {
    int most = 0;
    for (int i = 0; i < a.rows; ++i) most = std::max(most, a.begin[i + 1] - a.begin[i]);
    return 3 * most;
  };
  double roundings = 2 * (longest(s.k_in_double) + 6), times = 1;
  for (const auto& m : room.level) roundings += times * 5 * (longest(m.a) + 6), times *= visits;
  return roundings;
}

TEST(ProductionFaceMultigrid, TheCycleIsSymmetricAndDefinite) {
  for (const char* name : {"twelve", "bar_shaken", "inside_out", "face_smile"}) {
    const FaceSystem s = system_of(name);
    SerialRoom room = serial::make_multigrid(s.coarsening_in_double, s.k_in_double);
    serial::set_coarse(s.coarsening_in_double, s.k_in_double, room);
    ASSERT_TRUE(room.last) << name;
    const double rounding = roundings_of_cycle(s, room) * 0x1p-53 * greatest_condition(s, room);
    EXPECT_LT(rounding, 1e-6) << name << ": the bound says something";
    for (int seed = 0; seed < 6; ++seed) {
      const Array<double> x = random_load(s.k_in_double, 2 * seed), y = random_load(s.k_in_double, 2 * seed + 1);
      const Array<double> mx = cycle_of(s, room, x), my = cycle_of(s, room, y);
      const double size = std::sqrt(dot_of(x, mx) * dot_of(y, my));
      EXPECT_GT(dot_of(x, mx), 0) << name;
      // A cycle inverts blocks, and the last matrix, whose condition rounding is multiplied by.
      EXPECT_NEAR(dot_of(y, mx), dot_of(x, my), rounding * size) << name;
    }
  }
}

// The first iteration's x is along M^-1 b.
TEST(ProductionFaceMultigrid, TheSolveTakesTheCycle) {
  for (const char* name : {"twelve", "bar_shaken", "face_smile"}) {
    const FaceSystem s = system_of(name);
    SerialRoom room = serial::make_multigrid(s.coarsening_in_double, s.k_in_double);
    const Array<double> b = random_load(s.k_in_double, 5);
    Array<double> x(b.size());
    serial::solve_multigrid(s.coarsening_in_double, s.k_in_double, b, {1e-12, 1}, x, room);
    const Array<double> z = cycle_of(s, room, b);
    const double along = dot_of(x, z) / dot_of(z, z);
    const double rounding = roundings_of_cycle(s, room) * 0x1p-53 * greatest_condition(s, room);
    EXPECT_LE((linear::to_eigen(x) - along * linear::to_eigen(z)).norm(), rounding * linear::to_eigen(x).norm())
        << name;
  }
}

// --- The solve

TEST(ProductionFaceMultigrid, NeedsAFifthOfPlainsIterations) {
  for (const char* name : {"bar_shaken", "face_6k", "face_smile"}) {
    const FaceSystem s = system_of(name);
    const Array<float> b = random_load(s.k, 3);
    Array<float> x(b.size());
    auto room = serial::make_multigrid(s.coarsening, s.k);
    const int plain = serial::solve_plain(s.k, b, {1e-3, 5000}, x).iterations;
    const Solution solution = serial::solve_multigrid(s.coarsening, s.k, b, {1e-3, 5000}, x, room);
    std::printf("%s: %d iterations of plain, %d of multigrid\n", name, plain, solution.iterations);
    EXPECT_LE(5 * solution.iterations, plain) << name;
    EXPECT_LE(solution.recursive_residual, 1e-3);
  }
}

// |x - x*| <= |K^-1| |b - K x|, |K^-1| by the power method on CHOLMOD's solutions.
TEST(ProductionFaceMultigrid, IsCholmodsSolution) {
  const FaceSystem s = system_of("face_6k");
  Array<std::int32_t> number;
  int free_nodes = 0;
  for (int i = 0; i < s.k.rows; ++i) number.push_back(s.k.begin[i] < s.k.begin[i + 1] ? free_nodes++ : -1);
  BlockRows<float> a;
  a.rows = a.columns = free_nodes;
  const Array<double> b = random_load(s.k_in_double, 4);
  Array<double> right;
  for (int i = 0; i < s.k.rows; ++i) {
    if (number[i] < 0) continue;
    right.insert(right.end(), &b[3 * std::size_t(i)], &b[3 * std::size_t(i)] + 3);
    for (int p = s.k.begin[i]; p < s.k.begin[i + 1]; ++p)
      if (number[s.k.column[p]] >= 0) {
        a.column.push_back(number[s.k.column[p]]);
        a.value.insert(a.value.end(), &s.k.value[9 * std::size_t(p)], &s.k.value[9 * std::size_t(p)] + 9);
      }
    a.begin.push_back(static_cast<int>(a.column.size()));
  }
  linear::DirectSolver solver(linear::scalar_rows(a));
  Array<double> power = right;
  double of_inverse = 0;
  for (int k = 0; k < 60; ++k) {
    const double norm = linear::to_eigen(power).norm();
    for (double& e : power) e /= norm;
    power = solver(power);
    of_inverse = linear::to_eigen(power).norm();
  }
  SerialRoom room = serial::make_multigrid(s.coarsening_in_double, s.k_in_double);
  Array<double> x(b.size()), of_free;
  const Solution solution = serial::solve_multigrid(s.coarsening_in_double, s.k_in_double, b, {1e-9, 1000}, x, room);
  EXPECT_LE(solution.true_residual, 1.01e-9);
  for (int i = 0; i < s.k.rows; ++i)
    if (number[i] >= 0) of_free.insert(of_free.end(), &x[3 * std::size_t(i)], &x[3 * std::size_t(i)] + 3);
  const double off = (linear::to_eigen(of_free) - linear::to_eigen(solver(right))).norm();
  EXPECT_LE(off, 1.1 * of_inverse * 1.01e-9 * linear::to_eigen(right).norm());
}

// Both versions, at several numbers of threads; the serial answer.
Solution solve_in_both_versions(const FaceSystem& s, const Array<float>& b, const Stop& stop, Array<float>& x) {
  x.assign(b.size(), std::numeric_limits<float>::quiet_NaN());
  auto room = serial::make_multigrid(s.coarsening, s.k);
  const Solution expected = serial::solve_multigrid(s.coarsening, s.k, b, stop, x, room);
  const linear::SlicedBlockRows sliced = linear::slice(s.k);
  auto slices = openmp::make_multigrid(s.coarsening, sliced);
  const auto same = [&] {
    Array<float> y(b.size() + 2, 77);
    const Solution got = openmp::solve_multigrid(s.coarsening, sliced, b, stop, std::span(y).first(b.size()), slices);
    EXPECT_EQ(got.iterations, expected.iterations);
    EXPECT_EQ(got.recursive_residual, expected.recursive_residual);
    EXPECT_EQ(got.true_residual, expected.true_residual);
    EXPECT_TRUE(linear::same_bits(std::span(y).first(b.size()), x));
    EXPECT_EQ(y[b.size()], 77);
  };
  linear::at_each_thread_count(same);
  omp_set_num_threads(4), same(), omp_set_num_threads(omp_get_num_procs());
  return expected;
}

TEST(ProductionFaceMultigrid, HasTheSerialBits) {
  Array<float> x;
  for (const char* name : {"twelve", "bar_shaken", "inside_out", "face_6k", "face_smile"}) {
    const FaceSystem s = system_of(name);
    EXPECT_GT(solve_in_both_versions(s, random_load(s.k, 1), {1e-3, 60}, x).iterations, 0);
  }
}

TEST(ProductionFaceMultigrid, OfNothingIsNothing) {
  Array<float> x;
  const FaceSystem free = system_of("twelve"), held = system_of("twelve", true, [](const auto&) { return true; });
  EXPECT_TRUE(held.coarsening.level.empty());
  for (const FaceSystem& s : {free, held, FaceSystem{}}) {
    const Array<float> zero(3 * std::size_t(s.k.rows), 0);
    EXPECT_EQ(solve_in_both_versions(s, zero, {}, x).iterations, 0);
    EXPECT_EQ(x, zero);
  }
}

// One free node does not turn, and its aggregate's matrix is its block.
TEST(ProductionFaceMultigrid, OneFreeNodeIsOneAggregate) {
  const FaceSystem s = system_of("twelve", true, [](const Vector3<float>& p) { return p.x != .0025f; });
  ASSERT_EQ(s.coarsening.level.size(), 1u);
  ASSERT_EQ(s.coarsening.level[0].count(), 1);
  for (const float d : s.coarsening.level[0].arm) EXPECT_EQ(d, 0);
  Array<float> x;
  EXPECT_EQ(solve_in_both_versions(s, random_load(s.k, 5), {1e-5, 10}, x).iterations, 1);
}

// A body that no bone holds has K's null space: a load without force and torque has an answer, and it is found.
TEST(ProductionFaceMultigrid, ABodyWithoutBonesIsSolved) {
  const FaceSystem s = system_of("bar_shaken", true, no_more);
  ASSERT_TRUE(s.body.held.empty());
  Array<float> shape = random_load(s.k, 6), b(shape.size()), x;
  linear::serial::multiply(s.k, linear::view(shape), std::span(b));
  const Solution solution = solve_in_both_versions(s, b, {1e-3, 2000}, x);
  EXPECT_LE(solution.recursive_residual, 1e-3);
}

// K of a derivative that is not made definite, inside out: the solve ends, with finite numbers and the serial bits.
TEST(ProductionFaceMultigrid, AnIndefiniteMatrixEndsIt) {
  const FaceSystem s = system_of("inside_out", false, at_wall_of_bar);
  Array<float> x;
  const Solution solution = solve_in_both_versions(s, random_load(s.k, 7), {1e-6, 300}, x);
  EXPECT_GT(solution.recursive_residual, 1e-6);
  for (const float e : x) EXPECT_TRUE(std::isfinite(e));
}

}  // namespace
}  // namespace lockstep::production_face
