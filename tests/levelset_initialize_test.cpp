// Where distances begin: exact for planes, in order, and with the same bits at every thread count.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "common/levelset/initialize.h"
#include "tests/levelset_fields.h"

namespace lockstep::levelset {
namespace {

// What is in the way of an answer.
template <class Real>
Distances<Real> litter() {
  return {.distance = make_field<Real>(3, 4, 5, 7, -1), .interface = {{1, 2, 3}}};
}

template <class Real>
Distances<Real> serial_of(const Field<Real>& phi) {
  Distances<Real> distances = litter<Real>();
  serial::initialize(phi, distances);
  return distances;
}

Distances<float> openmp_of(const Field<float>& phi, int threads) {
  Distances<float> distances = litter<float>();
  const int before = omp_get_max_threads();
  omp_set_num_threads(threads);
  openmp::initialize(phi, distances);
  omp_set_num_threads(before);
  return distances;
}

template <class Real>
std::vector<std::array<int, 3>> interface_of(const Distances<Real>& distances) {
  std::vector<std::array<int, 3>> points;
  for (const auto& [x, y, z] : distances.interface) points.push_back({x, y, z});
  return points;
}

void expect_same(const Distances<float>& a, const Distances<float>& b) {
  EXPECT_EQ(interface_of(a), interface_of(b));
  const Field<float>&d = a.distance, &e = b.distance;
  ASSERT_EQ((std::array{d.nx, d.ny, d.nz, d.pitch}), (std::array{e.nx, e.ny, e.nz, e.pitch}));
  EXPECT_EQ(d.spacing, e.spacing);
  ASSERT_EQ(d.value.size(), e.value.size());
  EXPECT_EQ(std::memcmp(d.value.data(), e.value.data(), d.value.size() * sizeof(float)), 0) << "padding as well";
}

TEST(Initialize, HasTheSameBitsAtEveryThreadCount) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  for (const auto& [nx, ny, nz] :
       {std::array{2, 2, 2}, {3, 1, 2}, {15, 4, 3}, {16, 5, 7}, {17, 9, 2}, {33, 47, 29}, {64, 3, 2}}) {
    // Noise, so that most points are beside the interface; some zeros, of both signs; and one shape, so that few are.
    const Field<float> noise = field_of<float>(nx, ny, nz, .1f, [&](int, int, int) {
      const float phi = normal(random);
      return std::abs(phi) < .1f ? std::copysign(0.f, phi) : phi;
    });
    const Field<float> ball =
        field_of<float>(nx, ny, nz, .1f, [&](int x, int y, int z) { return std::hypot(x - 9, y - 5, z - 6) - 3.3; });
    for (const Field<float>* phi : {&noise, &ball})
      for (const int threads : {1, 2, 3, 5}) expect_same(serial_of(*phi), openmp_of(*phi, threads));
  }
}

TEST(Initialize, ListsWhatIsBesideTheInterfaceInOrder) {
  std::mt19937 random(1);
  const Field<float> phi = field_of<float>(18, 7, 6, 1, [&](int, int, int) {
    return random() % 10 == 0 ? -1 : random() % 20 == 0 ? 0 : 2;
  });
  std::vector<std::array<int, 3>> expected;
  const auto sign = [&](int x, int y, int z) { return phi(x, y, z) < 0 ? -1 : phi(x, y, z) > 0 ? 1 : 0; };
  for_each_point(phi, [&](int x, int y, int z) {
    const int s = sign(x, y, z);
    if (s == 0 || (x > 0 && sign(x - 1, y, z) != s) || (x < 17 && sign(x + 1, y, z) != s) ||
        (y > 0 && sign(x, y - 1, z) != s) || (y < 6 && sign(x, y + 1, z) != s) || (z > 0 && sign(x, y, z - 1) != s) ||
        (z < 5 && sign(x, y, z + 1) != s))
      expected.push_back({x, y, z});
  });
  const Distances<float> distances = serial_of(phi);
  EXPECT_EQ(interface_of(distances), expected);
  std::size_t known = 0;
  for (const float d : distances.distance.value) known += d != far<float>;
  EXPECT_EQ(known, expected.size());
  for (const auto& [x, y, z] : distances.interface) {
    EXPECT_LE(distances.distance(x, y, z), 1);
    EXPECT_EQ(distances.distance(x, y, z) == 0, phi(x, y, z) == 0);
  }
}

// Along an axis that a plane comes near it crosses at exact places; so where it crosses all axes that it is not along,
// it is where it is.
template <class Real>
void expect_planes_exact(Real tolerance) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> anywhere(-1, 1);
  constexpr double spacing = .25;
  int exact_points = 0;
  for (int n = 0; n < 60; ++n) {
    // At first planes along two axes, along one, and ones that cut all alike.
    std::array<double, 3> normal{};
    for (int axis = 0; axis < 3; ++axis) normal[axis] = n >= 14 ? anywhere(random) : (n / 2 + 1) >> axis & 1;
    if (n < 14 && n % 2) normal[0] = -normal[0], normal[2] = -normal[2];
    const double length = std::hypot(normal[0], normal[1], normal[2]), offset = anywhere(random);
    for (double& x : normal) x /= length;
    const auto from_plane = [&](int x, int y, int z) {
      return spacing * (normal[0] * (x - 8) + normal[1] * (y - 6) + normal[2] * (z - 7)) - offset;
    };
    for (const double slope : {1., -1., 1e-12, 3e9}) {
      const Distances<Real> distances = serial_of(
          field_of<Real>(17, 13, 15, spacing, [&](int x, int y, int z) { return slope * from_plane(x, y, z); }));
      EXPECT_FALSE(distances.interface.empty());
      for (const auto& [x, y, z] : distances.interface) {
        const double exact = std::abs(from_plane(x, y, z));
        const Real found = distances.distance(x, y, z);
        EXPECT_GE(found, exact - tolerance) << "too near";
        EXPECT_LE(found, spacing * (1 + tolerance)) << "too far";
        const int place[] = {x, y, z}, size[] = {17, 13, 15};
        bool all_axes = true;
        for (int axis = 0; axis < 3; ++axis) {
          const int towards = from_plane(x, y, z) * normal[axis] > 0 ? -1 : 1;
          const bool there = place[axis] + towards >= 0 && place[axis] + towards < size[axis];
          all_axes &= normal[axis] == 0 || (there && exact <= .999 * spacing * std::abs(normal[axis]));
        }
        if (!all_axes) continue;
        ++exact_points;
        EXPECT_NEAR(found, exact, tolerance);
      }
    }
  }
  EXPECT_GT(exact_points, 10'000);
}

TEST(Initialize, IsExactForPlanes) {
  expect_planes_exact<float>(2e-6f);
  expect_planes_exact<double>(1e-14);
}

// Planes through points: these are at 0, and their neighbours on both sides are as far as they are.
TEST(Initialize, IsExactForPlanesThroughPoints) {
  for (const int sign : {1, -1}) {
    const Distances<float> d =
        serial_of(field_of<float>(20, 6, 5, .5f, [&](int x, int y, int) { return sign * (x + y - 11); }));
    for_each_point(d.distance, [&](int x, int y, int z) {
      const int steps = std::abs(x + y - 11);
      const bool has_both = x + y < 11 ? y < 5 : y > 0;
      if (steps == 0) {
        EXPECT_EQ(d.distance(x, y, z), 0);
      }
      if (steps == 1 && has_both) {
        EXPECT_FLOAT_EQ(d.distance(x, y, z), .5 / std::sqrt(2.));
      }
      if (steps > 1) {
        EXPECT_EQ(d.distance(x, y, z), far<float>);
      }
    });
  }
}

TEST(Initialize, TakesAnyFinitePhi) {
  for (const float small : {std::numeric_limits<float>::denorm_min(), 1e-38f, 1e-20f, 1.f, 1e38f})
    for (const float large : {1e-30f, 1.f, 1e38f}) {
      const Field<float> phi = field_of<float>(18, 3, 2, .5f, [&](int x, int, int) { return x < 9 ? -small : large; });
      const Distances<float> d = serial_of(phi);
      EXPECT_EQ(d.interface.size(), 2 * 3 * 2u);
      EXPECT_NEAR(d.distance(8, 1, 1), .5 * small / (double(small) + large), 1e-7);
      EXPECT_NEAR(d.distance(9, 1, 1), .5 * large / (double(small) + large), 1e-7);
      expect_same(d, openmp_of(phi, 2));
    }
}

TEST(Initialize, FindsNothingWhereThereIsNone) {
  const Field<float> phi = field_of<float>(18, 3, 2, .5f, [](int, int, int) { return 1; });
  for (const Distances<float>& d : {serial_of(phi), openmp_of(phi, 2)}) {
    EXPECT_TRUE(d.interface.empty());
    EXPECT_TRUE(std::ranges::all_of(d.distance.value, [](float x) { return x == far<float>; }));
  }
}

}  // namespace
}  // namespace lockstep::levelset
