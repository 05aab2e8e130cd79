// Particles in the order of their blocks, against an oracle that sorts.
#include "common/production_fluid/sort_particles.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "tests/production_fluids.h"

namespace lockstep::production_fluid {
namespace {

SortParticles<float>* const sorts[] = {serial::sort_particles, openmp::sort_particles};

constexpr float h = .125f;  // so that positions in cells are exact

using Point = Vector3<float>;

// Their radii are their numbers, so that each is known wherever it goes.
Particles<float> particles_at(const std::vector<Point>& points) {
  Particles<float> particles;
  resize(particles, points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    store(particles.position, i, points[i]);
    particles.radius[i] = static_cast<float>(i), particles.sign[i] = i % 3 == 0 ? 1.f : -1.f;
  }
  return particles;
}

// Anywhere in the box, its sides included.
std::vector<Point> random_points(const Fluid<float>& fluid, int count, int seed) {
  std::mt19937 random(seed);
  const auto along = [&](int n) { return float(n) * h * static_cast<float>(random() % 65537) / 65536; };
  std::vector<Point> points(count);
  for (Point& p : points) p = {along(fluid.nx), along(fluid.ny), along(fluid.nz)};
  return points;
}

// Left by an earlier step, to be overwritten.
Particles<float> old() {
  Particles<float> particles = particles_at(std::vector<Point>(40, Point{-1, -1, -1}));
  particles.first.assign(7, -1);
  return particles;
}

// Positions in cells are exact, and so are their floors.
int block_of(const Fluid<float>& fluid, const Point& p) {
  const auto along = [](float x, int n) { return std::clamp(int(std::floor(double(x) / h - .5)), 0, n - 1); };
  return along(p.x, fluid.nx) + fluid.nx * (along(p.y, fluid.ny) + fluid.ny * along(p.z, fluid.nz));
}

void expect_sorts(SortParticles<float>* sort, const Fluid<float>& fluid, const std::vector<Point>& points) {
  const int count = static_cast<int>(points.size()), blocks = fluid.nx * fluid.ny * fluid.nz;
  std::vector<int> order(count), first(blocks + 1);
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](int i) { return block_of(fluid, points[i]); });
  for (const Point& p : points) ++first[block_of(fluid, p) + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());

  Particles<float> from = particles_at(points), sorted = old();
  from.first.assign(3, -1);  // of no use after a move
  sort(fluid.phi, from, sorted);
  ASSERT_EQ(sorted.count, count);
  ASSERT_TRUE(std::ranges::equal(sorted.first, first));
  ASSERT_GE(std::min(sorted.radius.size(), sorted.sign.size()), padded(count));
  for (int k = 0; k < count; ++k) {
    const int i = order[k];
    ASSERT_EQ(sorted.radius[k], float(i)) << "at " << k;
    ASSERT_EQ(sorted.sign[k], from.sign[i]);
    const Point p = load(sorted.position, k);
    ASSERT_TRUE(p.x == points[i].x && p.y == points[i].y && p.z == points[i].z) << "at " << k;
  }
}

// Few and many lines of blocks, and fewer and more particles than blocks, so that most or none are empty.
TEST(ProductionFluidSortParticles, IsStableAndKnowsWhereBlocksBegin) {
  const int threads_before = omp_get_max_threads();
  int seed = 0;
  for (const auto& [nx, ny, nz] : {Vector3<int>{1, 1, 1}, {2, 1, 3}, {17, 5, 4}, {50, 7, 6}, {3, 20, 21}})
    for (const int count : {0, 1, 15, 16, 17, 127, 1025, 20001}) {
      SCOPED_TRACE(testing::Message() << nx << ' ' << ny << ' ' << nz << ", " << count);
      const Fluid<float> fluid = make_air(nx, ny, nz);
      std::vector<Point> points = random_points(fluid, count, ++seed);
      for (const int threads : {1, 2, 3, 8}) {
        omp_set_num_threads(threads);
        for (SortParticles<float>* sort : sorts) expect_sorts(sort, fluid, points);
      }
      // In order already, in the reverse order, and all in one block.
      std::ranges::stable_sort(points, {}, [&](const Point& p) { return block_of(fluid, p); });
      for (SortParticles<float>* sort : sorts) expect_sorts(sort, fluid, points);
      std::ranges::reverse(points);
      for (SortParticles<float>* sort : sorts) expect_sorts(sort, fluid, points);
      std::ranges::fill(points, Point{nx * h, .5f * ny * h, nz * h});
      for (SortParticles<float>* sort : sorts) expect_sorts(sort, fluid, points);
    }
  omp_set_num_threads(threads_before);
}

// A block begins at a centre; the first and the last along an axis reach to the sides.
TEST(ProductionFluidSortParticles, BlocksLieBetweenCentres) {
  const Fluid<float> fluid = make_air(5, 4, 3);
  constexpr float below = 1 - 0x1p-20f;
  struct Case {
    Point at;  // in cells
    int block;
  };
  for (SortParticles<float>* sort : sorts)
    for (const auto& [at, block] : {Case{{0, 0, 0}, 0},
                                    {{.5f, .5f, .5f}, 0},
                                    {{1.5f * below, 1.5f * below, 1.5f * below}, 0},
                                    {{1.5f, 1, 1}, 1},
                                    {{1, 1.5f, 1}, 5},
                                    {{1, 1, 1.5f}, 20},
                                    {{4.5f * below, 1, 1}, 3},
                                    {{4.5f, 1, 1}, 4},
                                    {{5, 4, 3}, 59}}) {
      Particles<float> sorted = old();
      sort(fluid.phi, particles_at({{at.x * h, at.y * h, at.z * h}}), sorted);
      ASSERT_EQ(sorted.first.size(), 61u);
      for (int b = 0; b <= 60; ++b) EXPECT_EQ(sorted.first[b], b > block) << "block " << b;
    }
}

}  // namespace
}  // namespace lockstep::production_fluid
