// Reseeding against facts: where new particles may be, how they are spread, and who stays.
#include "common/production_fluid/reseed.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "tests/production_fluid_particles.h"
#include "tests/production_fluids.h"

namespace lockstep::production_fluid {
namespace {

Reseed<float>* const versions[] = {serial::reseed, openmp::reseed};

constexpr float h = .125f;  // so that positions in cells are exact

Particles<float> reseeded(Reseed<float>* reseed, const Fluid<float>& fluid, const ReseedSettings& settings,
                          const Particles<float>& particles = {}) {
  Particles<float> result;
  reseed(fluid, settings, particles, result);
  return result;
}

Vector3<double> position_of(const Particles<float>& particles, int i) {
  const Vector3<float> p = load(particles.position, i);
  return {p.x, p.y, p.z};
}

// Calls f(x, y, z, begin, end) for each block: which particles it holds.
template <class F>
void for_each_block(const Fluid<float>& fluid, const Particles<float>& particles, const F& f) {
  int block = 0;
  ASSERT_EQ(particles.first.size(), fluid.nx * fluid.ny * fluid.nz + 1u);
  EXPECT_EQ(particles.first.front(), 0);
  EXPECT_EQ(particles.first.back(), particles.count);
  for_each_place(fluid.phi, [&](int x, int y, int z) {
    f(x, y, z, particles.first[block], particles.first[block + 1]);
    ++block;
  });
}

// That what is said to be in a block is there, and in the box.
void expect_sorted(const Fluid<float>& fluid, const Particles<float>& particles) {
  ASSERT_GE(particles.radius.size(), padded(particles.count));
  const auto is_in = [](double position, int n, int k) {
    const double at = position / h, low = k == 0 ? 0 : k + .5, high = k == n - 1 ? n : k + 1.5;
    return low <= at && at < high;
  };
  for_each_block(fluid, particles, [&](int x, int y, int z, int begin, int end) {
    for (int i = begin; i < end; ++i) {
      const Vector3<double> p = position_of(particles, i);
      EXPECT_TRUE(is_in(p.x, fluid.nx, x) && is_in(p.y, fluid.ny, y) && is_in(p.z, fluid.nz, z)) << i;
    }
  });
}

void expect_same(const Particles<float>& a, const Particles<float>& b) {
  ASSERT_EQ(a.count, b.count);
  EXPECT_EQ(a.first, b.first);
  for (int i = 0; i < a.count; ++i) {
    const Vector3<float> p = load(a.position, i), q = load(b.position, i);
    ASSERT_TRUE(p.x == q.x && p.y == q.y && p.z == q.z && a.radius[i] == b.radius[i] && a.sign[i] == b.sign[i]) << i;
  }
}

// A ball of liquid, and half of a wall beside it, whose side is not along the grid.
Fluid<float> ball_at_a_wall(int n) {
  Fluid<float> fluid = make_fluid<float>(n, n, n, h, [&](double x, double y, double z) {
    const double r = n * h / 2;
    return std::sqrt((x - r) * (x - r) + (y - r) * (y - r) + (z - r) * (z - r)) - .6 * r;
  });
  for_each_place(fluid.solid, [&](int x, int y, int z) {
    fluid.solid(x, y, z) = .8f * (.75f * n - x) * h + .6f * (.5f * n - z) * h;
    if (y > n / 2) fluid.solid(x, y, z) = h;
  });
  return fluid;
}

// phi is h (y - height) with heights in cells.
Fluid<float> pool(int nx, int ny, int nz, float height) {
  return make_fluid<float>(nx, ny, nz, h, [&](double, double y, double) { return y - double(height) * h; });
}

// How far a float's interpolation of numbers up to `size` is off: seven roundings of numbers up to that, twice over,
// and the position's.
double rounding(double size) { return 32 * size * 0x1p-24; }

// The interpolation is linear along each axis, so its slope is the difference between the two ends, with the other
// two coordinates as they are.
TEST(ProductionFluidReseed, KnowsTheSlopeOfAnInterpolation) {
  std::mt19937 random(1);
  const auto number = [&] { return static_cast<double>(random() % 2001) / 1000 - 1; };
  for (int trial = 0; trial < 100; ++trial) {
    Corners<double> c;
    for (double& value : c.value) value = number();
    const double x = std::abs(number()), y = std::abs(number()), z = std::abs(number());
    const Vector3<double> found = slope(c, x, y, z);
    EXPECT_NEAR(found.x, interpolate(c, 1., y, z) - interpolate(c, 0., y, z), 1e-14);
    EXPECT_NEAR(found.y, interpolate(c, x, 1., z) - interpolate(c, x, 0., z), 1e-14);
    EXPECT_NEAR(found.z, interpolate(c, x, y, 1.) - interpolate(c, x, y, 0.), 1e-14);
  }
}

TEST(ProductionFluidReseed, PutsNewOnesInTheBandOnTheirSideOutsideObstacles) {
  constexpr int n = 14;
  const Fluid<float> fluid = ball_at_a_wall(n);
  const double bound = rounding(n * h);
  for (Reseed<float>* reseed : versions) {
    const Particles<float> made = reseeded(reseed, fluid, {});
    expect_sorted(fluid, made);
    for (int i = 0; i < made.count; ++i) {
      const Vector3<double> p = position_of(made, i);
      const double distance = double(made.sign[i]) * value_at(fluid.phi, p);
      EXPECT_GE(distance, .1 * double(h) - bound);
      EXPECT_LE(distance, 3 * h + bound);
      EXPECT_GE(value_at(fluid.solid, p), -bound);
      EXPECT_NEAR(made.radius[i], std::clamp(distance, .1 * double(h), .5 * double(h)), bound);
    }
    // All blocks with a corner well within the band and all corners open are full; those far away are empty.
    int full = 0, empty = 0;
    for_each_block(fluid, made, [&](int x, int y, int z, int begin, int end) {
      double nearest = 1e9, farthest = 0, most_solid = 1e9;
      for (int k = 0; k < 8; ++k) {
        const int a = std::min(x + k % 2, n - 1), b = std::min(y + k / 2 % 2, n - 1), c = std::min(z + k / 4, n - 1);
        nearest = std::min(nearest, std::abs(double(fluid.phi(a, b, c))));
        farthest = std::max(farthest, std::abs(double(fluid.phi(a, b, c))));
        most_solid = std::min(most_solid, double(fluid.solid(a, b, c)));
      }
      EXPECT_LE(end - begin, 16);
      const bool is_far = nearest > 3 * h, is_near = farthest < 3 * h && most_solid > 0;
      EXPECT_TRUE(!is_far || begin == end);
      EXPECT_TRUE(!is_near || end - begin == 16);
      empty += is_far, full += is_near;
    });
    EXPECT_GT(full, 100);
    EXPECT_GT(empty, 100);
  }
}

// The level set is the same everywhere and within the band, so no particle moves, and each coordinate is a unit
// number. The sum of squares of 64 bins has a chi-square distribution of k = 63 degrees, which exceeds
// k + 2 sqrt(k t) + 2 t with a probability of at most exp(-t) (Laurent and Massart, Ann. Statist. 28, 2000).
TEST(ProductionFluidReseed, SpreadsNewOnesEvenly) {
  const Fluid<float> fluid = make_fluid<float>(9, 7, 8, h, [](double, double, double) { return -1.5 * double(h); });
  constexpr double k = 63, t = 12;
  for (Reseed<float>* reseed : versions)
    for (const ReseedSettings& settings : {ReseedSettings{16, 0, 0}, {16, 0, 1}, {16, 1, 0}, {3, 77, 9}}) {
      const Particles<float> made = reseeded(reseed, fluid, settings);
      ASSERT_EQ(made.count, 9 * 7 * 8 * settings.per_block);
      std::vector<int> of_block(64), of_pairs(64);
      const auto share = [](double position, int n, int at) {
        const double low = at == 0 ? 0 : at + .5, high = at == n - 1 ? n : at + 1.5;
        return static_cast<int>(4 * (position / h - low) / (high - low));
      };
      for_each_block(fluid, made, [&](int x, int y, int z, int begin, int end) {
        for (int i = begin; i < end; ++i) {
          const Vector3<double> p = position_of(made, i);
          EXPECT_EQ(made.sign[i], -1);
          EXPECT_EQ(made.radius[i], .5f * h);
          const int a = share(p.x, 9, x), b = share(p.y, 7, y), c = share(p.z, 8, z);
          ++of_block[a + 4 * b + 16 * c];
          // Of one particle and the next, which must know nothing of each other.
          if (i % 3 > 0) continue;
          const Vector3<double> q = position_of(made, i + 1 < end ? i + 1 : begin);
          if (end - begin > 1) ++of_pairs[a + 4 * share(q.x, 9, x) + 16 * c];
        }
      });
      for (const std::vector<int>& bins : {of_block, of_pairs}) {
        double expected = 0, squares = 0;
        for (const int bin : bins) expected += bin / 64.;
        for (const int bin : bins) squares += (bin - expected) * (bin - expected) / expected;
        EXPECT_LE(squares, k + 2 * std::sqrt(k * t) + 2 * t);
        EXPECT_GT(squares, 20);  // nor are they as even as a grid
      }
    }
}

// The surface is a quarter of the way up the blocks of a layer, so a quarter of their particles is liquid: up to six
// standard deviations. Distances are even between .1 h and the block's end: so are their means, up to as much.
TEST(ProductionFluidReseed, GivesEachSideItsShare) {
  constexpr int n = 30;
  const Fluid<float> fluid = pool(n, 12, n, 5.75f);
  for (Reseed<float>* reseed : versions) {
    const Particles<float> made = reseeded(reseed, fluid, {});
    double count[2] = {}, sum[2] = {};
    for_each_block(fluid, made, [&](int, int y, int, int begin, int end) {
      if (y != 5) return;
      EXPECT_EQ(end - begin, 16);
      for (int i = begin; i < end; ++i) {
        const int side = made.sign[i] > 0;
        ++count[side], sum[side] += std::abs(position_of(made, i).y / h - 5.75);
      }
    });
    const double all = 16. * n * n;
    EXPECT_NEAR(count[0], .25 * all, 6 * std::sqrt(.25 * .75 * all));
    const double width[] = {.15, .65};
    for (int side = 0; side < 2; ++side)
      EXPECT_NEAR(sum[side] / count[side], .1 + width[side] / 2, 6 * width[side] / std::sqrt(12 * count[side]));
  }
}

TEST(ProductionFluidReseed, LeavesFullBlocksAlone) {
  const Fluid<float> fluid = ball_at_a_wall(14);
  for (Reseed<float>* reseed : versions) {
    const Particles<float> once = reseeded(reseed, fluid, {});
    const Particles<float> twice = reseeded(reseed, fluid, {.per_block = 16, .seed = 0, .round = 1}, once);
    expect_sorted(fluid, twice);
    int given_up = 0;
    for (std::size_t block = 0; block + 1 < once.first.size(); ++block) {
      const int before = once.first[block + 1] - once.first[block], now = twice.first[block + 1] - twice.first[block];
      ASSERT_GE(now, before);
      given_up += before > 0 ? 16 - before : 0;
      EXPECT_TRUE(before < 16 || now == 16);
      for (int i = 0; i < before; ++i)
        EXPECT_EQ(once.position.x[once.first[block] + i], twice.position.x[twice.first[block] + i]);
    }
    EXPECT_LT(given_up, once.count / 20);  // where the obstacle leaves hardly any of a block
  }
}

// A pool's particles in one block, at given heights above the surface.
struct Held {
  float height, sign, radius;  // in cells
};
Particles<float> in_block(const Fluid<float>& fluid, int x, int y, int z, const std::vector<Held>& held) {
  Particles<float> particles;
  resize(particles, held.size());
  for (std::size_t i = 0; i < held.size(); ++i) {
    store(particles.position, i, {h * (x + .75f), h * (6 + held[i].height), h * (z + .75f)});
    particles.radius[i] = h * held[i].radius, particles.sign[i] = held[i].sign;
  }
  const int block = x + fluid.nx * (y + fluid.ny * z);
  particles.first.resize(fluid.nx * fluid.ny * fluid.nz + 1);
  std::fill(particles.first.begin() + block + 1, particles.first.end(), particles.count);
  return particles;
}
// The x-coordinates would be the same, so a particle is known by its height and radius.
std::vector<std::pair<float, float>> names(const Particles<float>& particles, int count) {
  std::vector<std::pair<float, float>> result;
  for (int i = 0; i < count; ++i) result.emplace_back(particles.position.y[i], particles.radius[i]);
  return result;
}

// Three cells are still in the band. What has escaped stays wherever it is.
TEST(ProductionFluidReseed, DropsThoseBeyondTheBandUnlessTheyEscaped) {
  const Fluid<float> fluid = pool(3, 14, 3, 6);
  const Particles<float> held =
      in_block(fluid, 1, 8, 1, {{2.75f, 1, .5f}, {3, 1, .5f}, {3.125f, 1, .5f}, {3.125f, -1, .5f}, {3.375f, -1, .25f}});
  for (Reseed<float>* reseed : versions) {
    const Particles<float> left = reseeded(reseed, fluid, {.per_block = 4}, held);
    const int block = 1 + 3 * (8 + 14);
    ASSERT_EQ(left.first[block + 1] - left.first[block], 4);
    Particles<float> expected =
        in_block(fluid, 1, 8, 1, {{2.75f, 1, .5f}, {3, 1, .5f}, {3.125f, -1, .5f}, {3.375f, -1, .25f}});
    const auto all = names(left, left.count), want = names(expected, 4);
    EXPECT_TRUE(std::equal(want.begin(), want.end(), all.begin() + left.first[block]));
  }
}

// Against an oracle that sorts. Heights and radii are multiples of 1/64 of a cell, so ranks are exact, and there are
// ties. The first `escaped` of them are liquid in the air.
TEST(ProductionFluidReseed, KeepsTheLeastOfABlockThatIsTooFull) {
  const Fluid<float> fluid = pool(2, 14, 3, 6);
  std::mt19937 random(3);
  for (const int count : {0, 1, 15, 16, 17, 31, 32, 33, 100, 1000})
    for (const int escaped : {0, 1, 16, 20}) {
      std::vector<Held> held;
      for (int i = 0; i < std::max(count, escaped); ++i)
        held.push_back({.5f + float(random() % 64) / 64, 1, float(7 + random() % 26) / 64});
      for (int i = 0; i < escaped; ++i) held[i] = {1 + float(random() % 32) / 64, -1, .5f};
      std::shuffle(held.begin(), held.end(), random);

      std::vector<std::pair<float, int>> ranked;
      for (std::size_t i = 0; i < held.size(); ++i)
        ranked.emplace_back(held[i].sign < 0 ? -1e9f : held[i].height - held[i].radius, static_cast<int>(i));
      std::sort(ranked.begin(), ranked.end());
      ranked.resize(std::min<std::size_t>(ranked.size(), std::max(16, escaped)));
      std::sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
      std::vector<Held> expected;
      for (const auto& [rank, i] : ranked) expected.push_back(held[i]);

      const Particles<float> before = in_block(fluid, 1, 6, 1, held), wanted = in_block(fluid, 1, 6, 1, expected);
      for (Reseed<float>* reseed : versions) {
        const Particles<float> after = reseeded(reseed, fluid, {}, before);
        expect_sorted(fluid, after);
        const int block = 1 + 2 * (6 + 14), first = after.first[block];
        EXPECT_EQ(after.first[block + 1] - first, std::max<int>(16, wanted.count));
        const auto all = names(after, after.count), want = names(wanted, wanted.count);
        EXPECT_TRUE(std::equal(want.begin(), want.end(), all.begin() + first)) << count << ' ' << escaped;
      }
    }
}

TEST(ProductionFluidReseed, AddsNothingWhereThereIsNoRoom) {
  const auto constant = [](double phi) { return [phi](double, double, double) { return phi; }; };
  for (Reseed<float>* reseed : versions) {
    EXPECT_EQ(reseeded(reseed, make_box(5, 4, 3), {}).count, 0);  // solid
    EXPECT_EQ(reseeded(reseed, make_fluid<float>(5, 4, 3, h, constant(.05 * h)), {}).count, 0);
    EXPECT_EQ(reseeded(reseed, make_fluid<float>(5, 4, 3, h, constant(-3.01 * h)), {}).count, 0);
    for (const int per_block : {0, 1, 15, 16, 17}) {
      const Particles<float> of_one = reseeded(reseed, make_fluid<float>(1, 1, 1, h, constant(h)), {per_block});
      EXPECT_EQ(of_one.count, per_block);
      expect_sorted(make_air(1, 1, 1), of_one);
    }
    const Fluid<float> surface = pool(5, 9, 3, 4);
    EXPECT_EQ(reseeded(reseed, surface, {0}, reseeded(reseed, surface, {})).count, 0);
  }
}

TEST(ProductionFluidReseed, LeavesTheSameBitsAtEveryNumberOfThreads) {
  const int threads_before = omp_get_max_threads();
  int seed = 0;
  for (const auto& [nx, ny, nz] : {Vector3<int>{1, 1, 1}, {2, 1, 3}, {17, 5, 4}, {15, 1, 1}, {16, 3, 2}, {50, 7, 6}}) {
    const Fluid<float> before = make_random(nx, ny, nz, ++seed), now = make_random(nx, ny, nz, ++seed);
    const Particles<float> first = reseeded(serial::reseed, before, {20}),
                           second = reseeded(serial::reseed, now, {14}, first);
    for (const int threads : {1, 2, 3, 8}) {
      omp_set_num_threads(threads);
      expect_same(reseeded(openmp::reseed, before, {20}), first);
      expect_same(reseeded(openmp::reseed, now, {14}, first), second);
    }
  }
  omp_set_num_threads(threads_before);
}

}  // namespace
}  // namespace lockstep::production_fluid
