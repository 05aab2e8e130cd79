// Products of stiffness: against differences of forces, each form against the others within derived bounds, symmetry,
// null space, held nodes; and the serial bits.
#include "common/production_face/multiply.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "common/linear/multiply.h"
#include "common/production_face/assemble.h"
#include "common/production_face/forces.h"
#include "tests/production_face_bodies.h"
#include "tests/production_face_matrices.h"

namespace lockstep::production_face {
namespace {

template <class Real>
Array<Real> matrix_free(const Body<Real>& body, const Strained<Real>& s, const Array<Real>& x) {
  Array<Real> y(x.size(), std::numeric_limits<Real>::quiet_NaN());
  serial::multiply_matrix_free(body, s, x, y);
  return y;
}

template <class Real>
linear::BlockRows<Real> stiffness(const Body<Real>& body, const Strained<Real>& s) {
  const Pattern pattern = make_pattern(body);
  auto k = make_block_rows<Real>(pattern);
  serial::assemble(body, s, pattern, k);
  return k;
}

template <class Real>
Array<Real> by_rows(const linear::BlockRows<Real>& k, const Array<Real>& x) {
  Array<Real> y(x.size(), std::numeric_limits<Real>::quiet_NaN());
  linear::serial::multiply(k, std::span<const Real>(x), std::span<Real>(y));
  return y;
}

template <class Real>
Array<Real> by_edges(const linear::BlockRows<Real>& k, const Array<Real>& x) {
  Array<Real> y(x.size(), std::numeric_limits<Real>::quiet_NaN());
  serial::multiply_edges(make_edges(k), x, y);
  return y;
}

template <class Real>
double norm_of(const Array<Real>& x) {
  double sum = 0;
  for (const Real e : x) sum += double(e) * e;
  return std::sqrt(sum);
}

// The product with all numbers replaced by their sizes, and each x_a - x_0 by the sum of all corners' sizes: what a
// rounding error of any operation is relative to. The formula adds only, so it is its own sum of sizes.
std::vector<double> sizes_of_product(const Body<float>& body, const Strained<float>& s, const Array<float>& x) {
  std::vector<double> size(x.size(), 0);
  for (int t = 0; t < body.tetrahedra; ++t) {
    const auto at = [](int place) {
      return [place](const Blocked<float>& array, int k) { return std::abs(double(array.at(place, k))); };
    };
    Vector3<double> all = {0, 0, 0};
    for (int a = 0; a < 4; ++a)
      all = all + size_of(convert<double>(at_node(std::span<const float>(x), body.corner.at(t, a))));
    const Moved<double> moved = {{all, all, all}};
    const auto e = strained_element<double>(body, s, at(t));
    Parts<double> part;
    set_flesh_product(e, moved, part);
    for (int slot = body.first_fibre[t / lanes]; slot < body.first_fibre[t / lanes + 1]; ++slot)
      add_fibre_product(e, strained_fibre<double>(body, s, at(slot * lanes + t % lanes)), moved, part);
    set_first_corner(part);
    for (int a = 0; a < 4; ++a) add_to_node(std::span<double>(size), body.corner.at(t, a), size_of(part.of[a]));
  }
  return size;
}

// One product's roundings one after another: x_a - x_0 1, in the frame of U 3, V^T gradient 3 and once more, dF' 3,
// dP' 3, times b 3, out of the frame 3, volume 1, two fibres 2, corner 0 2; and one for each tetrahedron of the node.
double roundings_of_product(const Body<float>& body, int node) {
  return 27 + body.first_corner[node + 1] - body.first_corner[node];
}

// The matrix's: volume 1, V^T gradient 3 and once more, M 4, U on both sides 6, two fibres 2, corner 0 2, the sum of a
// block's shares, at most a node's tetrahedra, the diagonal's sum of blocks, and the product's of three a block and 1.
// Sizes may count thrice: the diagonal is a sum of blocks of which each is one, and K_00 and K_0c are sums again.
double roundings_of_rows(const Body<float>& body, const linear::BlockRows<float>& k, int node) {
  return 3 * (22 + body.first_corner[node + 1] - body.first_corner[node] + 4 * (k.begin[node + 1] - k.begin[node]));
}

TEST(ProductionFaceMultiply, IsMinusTheSlopeOfTheForces) {
  for (const double shake : {0., .0002, .0008, .004}) {
    const InDouble d = widened(tetrahedra(24, shake));
    // Forces are curved over the size of a cell, so that the error is about (1e-8 / 5e-3)^2; their rounding, 2^-53 by
    // the step in units of a cell, is 5e-11. What is left is the curves' coefficients, which are float.
    constexpr double step = 1e-8;
    for (const unsigned seed : {1u, 2u, 3u}) {
      const Array<double> x = random_vector<double>(d.body.nodes, seed);
      const Array<double> y = matrix_free(d.body, strained(d.body, d.flesh, d.pose, false), x);
      const auto force_at = [&](double by) {
        Array<double> force(x.size());
        serial::forces(d.body, strained(d.body, d.flesh, moved<double>(d.pose, by, x), false), force);
        return force;
      };
      const Array<double> ahead = force_at(step), behind = force_at(-step);
      for (std::size_t i = 0; i < x.size(); ++i)
        EXPECT_NEAR(y[i], (behind[i] - ahead[i]) / (2 * step), 1e-6 * norm_of(y)) << shake << ' ' << i;
    }
  }
}

TEST(ProductionFaceMultiply, AllFormsAgreeWithinRounding) {
  for (const char* name : {"twelve", "bar_shaken", "inside_out"})
    for (const bool definite : {false, true}) {
      const Scene scene = scene_of(name);
      const Strained<float> s = strained(scene.body, scene.flesh, scene.pose, definite);
      const auto k = stiffness(scene.body, s);
      const Array<float> x = random_vector<float>(scene.body.nodes, 4);
      const Array<float> free = matrix_free(scene.body, s, x), rows = by_rows(k, x), edges = by_edges(k, x);
      const std::vector<double> size = sizes_of_product(scene.body, s, x);
      double worst = 0;
      for (std::size_t i = 0; i < x.size(); ++i) {
        const int node = int(i / 3);
        const double of_rows = roundings_of_rows(scene.body, k, node);
        const double bound = 0x1p-24 * (roundings_of_product(scene.body, node) + of_rows) * size[i];
        ASSERT_LE(std::abs(double(free[i]) - rows[i]), bound) << name << ' ' << i;
        worst = std::max(worst, std::abs(double(free[i]) - rows[i]) / bound);
        double terms = 0;
        for (int place = k.begin[node]; place < k.begin[node + 1]; ++place)
          for (int c = 0; c < 3; ++c)
            terms += std::abs(double(k.value[9 * std::size_t(place) + 3 * (i % 3) + c]) * x[3 * k.column[place] + c]);
        ASSERT_LE(std::abs(double(edges[i]) - rows[i]), 2 * 3 * (k.begin[node + 1] - k.begin[node]) * 0x1p-24 * terms)
            << name << ' ' << i;
      }
      std::printf("%s: matrix_free and block_rows differ by %.2g of the bound\n", name, worst);
    }
}

TEST(ProductionFaceMultiply, IsSymmetric) {
  for (const char* name : {"twelve", "bar_shaken", "inside_out"}) {
    const Scene scene = scene_of(name);
    const Strained<float> s = strained(scene.body, scene.flesh, scene.pose, true);
    const Array<float> x = random_vector<float>(scene.body.nodes, 5), y = random_vector<float>(scene.body.nodes, 6);
    const Array<float> kx = matrix_free(scene.body, s, x), ky = matrix_free(scene.body, s, y);
    const std::vector<double> of_x = sizes_of_product(scene.body, s, x), of_y = sizes_of_product(scene.body, s, y);
    double difference = 0, bound = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      difference += double(x[i]) * ky[i] - double(y[i]) * kx[i];
      bound += 0x1p-24 * roundings_of_product(scene.body, int(i / 3)) *
               (std::abs(x[i]) * of_y[i] + std::abs(y[i]) * of_x[i]);
    }
    EXPECT_LE(std::abs(difference), bound) << name;
  }
}

// At rest U and V are the identity. Four more roundings are those of gradients, of x and of the derivative.
TEST(ProductionFaceMultiply, RigidMotionsAreTheNullSpaceAtRest) {
  Scene scene = scene_of("bar_shaken");
  scene.pose.displacement = {};
  scene.pose.displacement.resize(scene.body.nodes);
  scene.pose.activation.assign(scene.body.muscles, 0);
  const Strained<float> s = strained(scene.body, scene.flesh, scene.pose, false);
  for (int motion = 0; motion < 6; ++motion) {
    Array<float> x(3 * static_cast<std::size_t>(scene.body.nodes), 0);
    for (int n = 0; n < scene.body.nodes; ++n) {
      const Vector axis = {double(motion % 3 == 0), double(motion % 3 == 1), double(motion % 3 == 2)};
      const Vector by = motion < 3 ? axis : cross(axis, convert<double>(load(scene.body.rest, n)));
      add_to_node(std::span<float>(x), n, convert<float>(by));
    }
    const Array<float> y = matrix_free(scene.body, s, x);
    const std::vector<double> size = sizes_of_product(scene.body, s, x);
    for (std::size_t i = 0; i < y.size(); ++i) {
      if (motion < 3) {
        ASSERT_EQ(y[i], 0) << motion;
      }
      ASSERT_LE(std::abs(y[i]), 0x1p-24 * (4 + roundings_of_product(scene.body, int(i / 3))) * size[i]) << motion;
    }
  }
}

TEST(ProductionFaceMultiply, HeldNodesFeelNothingButTheirDisplacementsCount) {
  InDouble d = widened(tetrahedra(40, .0008));
  const Strained<double> s = strained(d.body, d.flesh, d.pose, true);
  const Array<double> x = random_vector<double>(d.body.nodes, 7), whole = matrix_free(d.body, s, x);
  d.body.held = {0, 3, 4, 11};
  const auto k = stiffness(d.body, s);
  for (const Array<double>& y : {matrix_free(d.body, s, x), by_rows(k, x), by_edges(k, x)})
    for (std::size_t i = 0; i < y.size(); ++i) {
      if (std::ranges::binary_search(d.body.held, int(i / 3)))
        EXPECT_EQ(y[i], 0) << i;
      else
        EXPECT_NEAR(y[i], whole[i], 1e-12 * norm_of(whole)) << i;  // 1e4 u
    }
}

TEST(ProductionFaceMultiply, LanesHaveTheSerialBitsAtEverySizeAndThreadCount) {
  for (const int count : {1, 2, 15, 16, 17, 31, 32, 33, 90}) {
    Scene scene = tetrahedra(count, .0008);
    if (count > 16) scene.body.held = {1, 7};
    const Strained<float> s = strained(scene.body, scene.flesh, scene.pose, true);
    const Array<float> x = random_vector<float>(scene.body.nodes, 8), expected = matrix_free(scene.body, s, x);
    for (const int blocks : {1, 2, 2048})
      for (const int threads : {1, 2, 3, 8}) {
        omp_set_num_threads(threads);
        const Waves waves = make_waves(scene.body, blocks);
        Array<float> parts = make_parts(scene.body), y(expected.size(), NAN);
        std::ranges::fill(parts, NAN);
        openmp::multiply_matrix_free(scene.body, s, x, waves, parts, y);
        EXPECT_EQ(std::memcmp(y.data(), expected.data(), 4 * y.size()), 0) << count << ' ' << threads;
      }
  }
  omp_set_num_threads(1);
}

}  // namespace
}  // namespace lockstep::production_face
