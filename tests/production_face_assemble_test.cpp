// The stiffness matrix: against differences of forces, its null space, its definiteness; and with the serial bits.
#include "common/production_face/assemble.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "common/production_face/make.h"
#include "common/production_face/scene.h"
#include "common/production_face/update_state.h"
#include "tests/linear_matrices.h"
#include "tests/production_face_bodies.h"

namespace lockstep::production_face {
namespace {

// Twelve tetrahedra, of which some have no fibre, some one, some two.
Scene small_scene(double shake) {
  const Mesh mesh = make_lattice({1, 1, 1}, .005);
  std::vector<Fibre> fibres;
  for (int t = 0; t < 8; ++t) fibres.push_back({t, 0, {.6, .8, 0}, 1});
  for (int t = 3; t < 5; ++t) fibres.insert(fibres.begin() + 2 * t - 2, {t, 1, {0, .6, -.8}, .5});
  Scene scene = {.name = "", .path = "", .body = make_body(mesh, fibres, 2), .flesh = {}, .pose = {}, .motion = {}};
  scene.pose.displacement.resize(scene.body.nodes);
  std::mt19937 random(1);
  for (Array<float>* component : {&scene.pose.displacement.x, &scene.pose.displacement.y, &scene.pose.displacement.z})
    for (int n = 0; n < scene.body.nodes; ++n)
      (*component)[n] = static_cast<float>(shake * std::uniform_real_distribution<double>(-1, 1)(random));
  scene.pose.activation = {.7f, .4f};
  return scene;
}

using Dense = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

Strained<float> strained(const Scene& scene, bool definite) {
  Strained<float> s = make_strained(scene.body);
  serial::update_state(scene.body, scene.flesh, scene.pose, definite, s);
  return s;
}

linear::BlockRows<float> stiffness(const Scene& scene, bool definite) {
  const Pattern pattern = make_pattern(scene.body);
  auto k = make_block_rows<float>(pattern);
  k.value.assign(k.value.size(), NAN);
  serial::assemble(scene.body, strained(scene, definite), pattern, k);
  return k;
}

// --- A second text of the forces, in double: corner by corner, by minus the slope of the energy along F.

Vector forces(const InDouble& d, const Vector& moved) {
  Vector all = Vector::Zero(3 * d.body.nodes);
  for (int t = 0; t < d.body.tetrahedra; ++t) {
    Eigen::Matrix3d g, du;  // columns: gradients; displacements against corner 0
    const auto at = [&](int a) {
      const int n = d.body.corner.at(t, a);
      const Vector3<double> u = load(d.pose.displacement, n);
      return Eigen::Vector3d(Eigen::Vector3d(u.x, u.y, u.z) + moved.segment<3>(3 * n));
    };
    for (int a = 0; a < 3; ++a) {
      for (int i = 0; i < 3; ++i) g(i, a) = d.body.gradient.at(t, 3 * a + i);
      du.col(a) = at(a + 1) - at(0);
    }
    const Eigen::Matrix3d f = Eigen::Matrix3d::Identity() + du * g.transpose();
    // Eigen's singular values, with the sign of det F on the last.
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(f, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d s = svd.singularValues();
    Eigen::Matrix3d u = svd.matrixU();
    if (f.determinant() < 0) s[2] = -s[2], u.col(2) = -u.col(2);
    const Vector3<double> stretch = {s[0], s[1], s[2]};
    const Vector3<double> p = principal_stress(flesh_slopes(d.flesh, stretch), stretch);
    Eigen::Matrix3d stress = u * Eigen::Vector3d(p.x, p.y, p.z).asDiagonal() * svd.matrixV().transpose();
    const int block = t / lanes;
    for (int slot = d.body.first_fibre[block]; slot < d.body.first_fibre[block + 1]; ++slot) {
      const int place = slot * lanes + t % lanes, muscle = d.body.muscle.at(place, 0);
      if (muscle < 0) continue;
      const Eigen::Vector3d w(d.body.fibre.at(place, 0), d.body.fibre.at(place, 1), d.body.fibre.at(place, 2));
      const Eigen::Vector3d along = f * w;
      const double pull = double(muscle_stress) * d.pose.activation[muscle] * d.body.fibre.at(place, 3);
      stress += tension<double>(along.norm(), pull, muscle_stress, false).per_stretch * along * w.transpose();
    }
    for (int a = 0; a < 3; ++a) {
      const Eigen::Vector3d force = -d.body.volume.at(t, 0) * stress * g.col(a);
      all.segment<3>(3 * d.body.corner.at(t, a + 1)) += force;
      all.segment<3>(3 * d.body.corner.at(t, 0)) -= force;
    }
  }
  return all;
}

Dense stiffness_in_double(const InDouble& d) {
  const Pattern pattern = make_pattern(d.body);
  auto k = make_block_rows<double>(pattern);
  Strained<double> s = make_strained(d.body);
  serial::update_state(d.body, d.flesh, d.pose, false, s);
  serial::assemble(d.body, s, pattern, k);
  return linear::to_dense(k);
}

TEST(ProductionFaceAssemble, IsMinusTheSlopeOfTheForces) {
  for (const double shake : {0., .0002, .0008, .004}) {
    const InDouble d = widened(small_scene(shake));
    const Dense k = stiffness_in_double(d);
    // Forces are curved over the size of a cell, so that the error is about (1e-8 / 5e-3)^2; their rounding, 2^-53 by
    // the step in units of a cell, is 5e-11. What is left is the curves' coefficients, which are float.
    constexpr double step = 1e-8;
    for (int i = 0; i < k.cols(); ++i) {
      const Vector unit = step * Vector::Unit(k.cols(), i);
      const Vector by_differences = (forces(d, -unit) - forces(d, unit)) / (2 * step);
      EXPECT_LT((k.col(i) - by_differences).norm(), 1e-6 * k.norm()) << shake << ' ' << i;
    }
  }
}

TEST(ProductionFaceAssemble, IsSymmetricToTheBit) {
  for (const char* name : {"twelve", "bar_shaken", "inside_out"})
    for (const bool definite : {false, true}) {
      const auto k = stiffness(scene_of(name), definite);
      for (int i = 0; i < k.rows; ++i)
        for (int b = k.begin[i]; b < k.begin[i + 1]; ++b) {
          const auto first = k.column.begin() + k.begin[k.column[b]];
          const auto found = std::lower_bound(first, k.column.begin() + k.begin[k.column[b] + 1], i);
          const std::size_t other = found - k.column.begin();
          for (int e = 0; e < 9; ++e) {
            const float here = k.value[9 * std::size_t(b) + e], there = k.value[9 * other + e % 3 * 3 + e / 3];
            ASSERT_EQ(std::memcmp(&here, &there, sizeof here), 0) << name << ' ' << i << ' ' << b << ' ' << e;
          }
        }
    }
}

TEST(ProductionFaceAssemble, RowsOfHeldNodesAreEmptyAndOthersAsTheyWere) {
  Scene scene = small_scene(.0008);
  const auto whole = stiffness(scene, true);
  scene.body.held = {0, 3, 8};
  const auto k = stiffness(scene, true);
  ASSERT_EQ(k.rows, whole.rows);
  for (int i = 0; i < k.rows; ++i) {
    const int blocks = k.begin[i + 1] - k.begin[i];
    EXPECT_EQ(blocks, std::ranges::binary_search(scene.body.held, i) ? 0 : whole.begin[i + 1] - whole.begin[i]);
    for (int b = 0; b < blocks; ++b) {
      EXPECT_EQ(k.column[k.begin[i] + b], whole.column[whole.begin[i] + b]);
      for (int e = 0; e < 9; ++e)
        EXPECT_EQ(k.value[9 * (k.begin[i] + b) + e], whole.value[9 * (whole.begin[i] + b) + e]) << i << ' ' << b;
    }
  }
}

TEST(ProductionFaceAssemble, LanesHaveTheSerialBitsAtEveryThreadCount) {
  std::vector<Scene> scenes = {small_scene(.0008), scene_of("bar_shaken"), scene_of("inside_out")};
  scenes.push_back(scenes[1]);
  for (int n = 5; n < 100; n += 3) scenes.back().body.held.push_back(n);
  for (const Scene& scene : scenes) {
    const Pattern pattern = make_pattern(scene.body);
    const Strained<float> s = strained(scene, true);
    const linear::SlicedBlockRows expected = linear::slice(stiffness(scene, true));
    for (const int threads : {1, 2, 3, 4, 8}) {
      omp_set_num_threads(threads);
      auto k = make_block_rows<float>(pattern);
      k.value.assign(k.value.size(), NAN);
      auto sliced = linear::slice(k);
      auto shares = make_shares(scene.body);
      openmp::assemble(scene.body, s, pattern, shares, sliced);
      EXPECT_EQ(std::memcmp(sliced.value.data(), expected.value.data(), 4 * expected.value.size()), 0) << threads;
    }
  }
  omp_set_num_threads(1);
}

TEST(ProductionFaceAssemble, PatternHasABlockForEachTwoNodesOfATetrahedron) {
  const Body<float> body = small_scene(0).body;
  const Pattern pattern = make_pattern(body);
  // Eight corners, the middle, twelve edges of the cube, six diagonals of its faces, eight edges to the middle.
  EXPECT_EQ(pattern.blocks(), 9 + 2 * (12 + 6 + 8));
  EXPECT_EQ(pattern.share.size(), 12u * body.tetrahedra);
  for (int k = 0; k < pattern.blocks(); ++k)
    for (int s = pattern.first_share[k] + 1; s < pattern.first_share[k + 1]; ++s)
      EXPECT_LT(pattern.share[s - 1] / pairs, pattern.share[s] / pairs);
}

}  // namespace
}  // namespace lockstep::production_face
