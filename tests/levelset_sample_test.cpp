// Trilinear samples against facts: what interpolation must reproduce, and where it must stop.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/levelset/sample.h"

namespace lockstep::levelset {
namespace {

using SampleFloat = Sample<float>;
SampleFloat* const versions[] = {serial::sample, openmp::sample};

constexpr float u = std::numeric_limits<float>::epsilon() / 2;

template <class F>
Field<float> field_of(int nx, int ny, int nz, float spacing, F value) {
  Field<float> field = make_field<float>(nx, ny, nz, spacing, std::numeric_limits<float>::quiet_NaN());
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) field(x, y, z) = value(x, y, z);
  return field;
}

struct Positions {
  int count = 0;
  Vectors<float> at;

  explicit Positions(int n) : count(n) { at.resize(n); }
  void set(int i, float x, float y, float z) { at.x[i] = x, at.y[i] = y, at.z[i] = z; }
};

Array<float> sampled(SampleFloat* sample, const Field<float>& field, const Positions& positions) {
  Array<float> value(padded(positions.count), -1.f);
  sample(field, positions.count, positions.at, value);
  return value;
}

// A sequence of numbers in 0 .. 1.
struct Numbers {
  unsigned state = 1;
  float operator()() { return static_cast<float>((state = state * 1664525u + 1013904223u) >> 8) * 0x1p-24f; }
};

TEST(LevelsetSample, FindsThePointsThemselves) {
  const Field<float> field = field_of(5, 4, 3, .5f, [](int x, int y, int z) { return float(x + 10 * y + 100 * z); });
  Positions positions(5 * 4 * 3);
  for (int i = 0; i < positions.count; ++i) positions.set(i, .5f * (i % 5), .5f * (i / 5 % 4), .5f * (i / 20));
  for (SampleFloat* sample : versions) {
    const Array<float> value = sampled(sample, field, positions);
    for (int i = 0; i < positions.count; ++i)
      EXPECT_EQ(value[i], float(i % 5 + 10 * (i / 5 % 4) + 100 * (i / 20))) << i;
  }
}

// A linear function is its own interpolation. Each of the seven interpolations rounds three times, and the position
// twice.
TEST(LevelsetSample, ReproducesALinearFunction) {
  constexpr float spacing = .125f;  // a power of two: positions in spacings are exact
  const Field<float> field =
      field_of(17, 9, 33, spacing, [](int x, int y, int z) { return 1 + 2.f * x - 3.f * y + .5f * z; });
  Positions positions(1000);
  Numbers number;
  for (int i = 0; i < positions.count; ++i)
    positions.set(i, 16 * spacing * number(), 8 * spacing * number(), 32 * spacing * number());
  for (SampleFloat* sample : versions) {
    const Array<float> value = sampled(sample, field, positions);
    for (int i = 0; i < positions.count; ++i) {
      const double exact = 1 + (2. * positions.at.x[i] - 3. * positions.at.y[i] + .5 * positions.at.z[i]) / spacing;
      // Three levels, each 4 u of the largest value.
      EXPECT_NEAR(value[i], exact, 3 * 4 * u * (1 + 2 * 16 + 3 * 8 + .5 * 32)) << i;
    }
  }
}

TEST(LevelsetSample, StaysBetweenItsEightPoints) {
  Numbers number;
  const Field<float> field = field_of(8, 8, 8, 1, [&](int, int, int) { return number() - .5f; });
  Positions positions(500);
  for (int i = 0; i < positions.count; ++i) positions.set(i, 7 * number(), 7 * number(), 7 * number());
  for (SampleFloat* sample : versions) {
    const Array<float> value = sampled(sample, field, positions);
    for (int i = 0; i < positions.count; ++i) {
      const int x = int(positions.at.x[i]), y = int(positions.at.y[i]), z = int(positions.at.z[i]);
      float least = 1, most = -1;
      for (int corner = 0; corner < 8; ++corner) {
        const float at = field(x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2));
        least = std::min(least, at), most = std::max(most, at);
      }
      EXPECT_GE(value[i], least - 4 * u) << i;
      EXPECT_LE(value[i], most + 4 * u) << i;
    }
  }
}

TEST(LevelsetSample, TakesTheBoundaryOutside) {
  const Field<float> field = field_of(3, 2, 4, 2, [](int x, int y, int z) { return float(x + 10 * y + 100 * z); });
  constexpr float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  Positions positions(6);
  positions.set(0, -1, -1, -1);
  positions.set(1, 100, 100, 100);
  positions.set(2, inf, -inf, inf);
  positions.set(3, nan, nan, nan);
  positions.set(4, 1e30f, 0, -1e30f);
  positions.set(5, 4, 2, 6);
  const float expected[] = {0, 312, 302, 0, 2, 312};
  for (SampleFloat* sample : versions) {
    const Array<float> value = sampled(sample, field, positions);
    for (int i = 0; i < positions.count; ++i) EXPECT_EQ(value[i], expected[i]) << i;
  }
}

TEST(LevelsetSample, WritesAsManyAsItIsAsked) {
  const Field<float> field = field_of(2, 2, 2, 1, [](int, int, int) { return 5.f; });
  for (const int count : {0, 1, 15, 16, 17, 33})
    for (SampleFloat* sample : versions) {
      const Array<float> value = sampled(sample, field, Positions(count));
      for (std::size_t i = 0; i < value.size(); ++i)
        EXPECT_EQ(value[i], i < std::size_t(count) ? 5.f : -1.f) << count << ' ' << i;
    }
}

}  // namespace
}  // namespace lockstep::levelset
