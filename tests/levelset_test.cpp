// Marching and sweeping against exact distances, against each other, and both versions against each other on shapes of
// grids that no scene has.
#include <gtest/gtest.h>
#include <omp.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iterator>
#include <limits>
#include <thread>

#include "common/levelset/blocks.h"
#include "common/levelset/eikonal.h"
#include "common/levelset/fast_marching.h"
#include "common/levelset/fast_sweeping.h"
#include "common/levelset/initialize.h"
#include "common/levelset/scene.h"
#include "common/levelset/shapes.h"
#include "common/simd.h"

namespace lockstep::levelset {
namespace {

constexpr float everywhere = std::numeric_limits<float>::infinity();

template <class Real>
Field<Real> field_of(const std::vector<Shape>& shapes, const Grid& grid) {
  Field<Real> phi = make_field<Real>(grid.nx, grid.ny, grid.nz, static_cast<Real>(grid.spacing), 1);
  for (int z = 0; z < grid.nz; ++z)
    for (int y = 0; y < grid.ny; ++y)
      for (int x = 0; x < grid.nx; ++x)
        phi(x, y, z) = static_cast<Real>(signed_distance(shapes, grid.position(x, y, z)));
  return phi;
}

template <class Real>
Distances<Real> started(const std::vector<Shape>& shapes, const Grid& grid) {
  Distances<Real> distances;
  serial::initialize(field_of<Real>(shapes, grid), distances);
  return distances;
}

struct Errors {
  double mean, most;  // in m, of all points that have a distance
  long points;
};

template <class Real>
Errors errors(const Distances<Real>& d, const std::vector<Shape>& shapes, const Grid& grid) {
  Errors e = {0, 0, 0};
  for (int z = 0; z < grid.nz; ++z)
    for (int y = 0; y < grid.ny; ++y)
      for (int x = 0; x < grid.nx; ++x) {
        if (d.distance(x, y, z) >= far<Real>) continue;
        const double error = std::abs(d.distance(x, y, z) - std::abs(signed_distance(shapes, grid.position(x, y, z))));
        e.mean += error, e.most = std::max(e.most, error), ++e.points;
      }
  e.mean /= double(e.points);
  return e;
}

Grid unit_cube(int n) { return {n, n, n, 1. / n, {0, 0, 0}}; }

const std::vector<Shape> spheres = {Sphere{{.3, .3, .35}, .17}, Sphere{{.7, .35, .6}, .15}};
const std::vector<Shape> spheres_and_box = {Sphere{{.3, .3, .35}, .17}, Sphere{{.7, .35, .6}, .15},
                                            Box{{.45, .72, .5}, {.2, .12, .18}}};

// --- The upwind solution

TEST(LevelsetUpwind, SolvesTheEquation) {
  // sum of ((u - v) / h)^2 = 1 over the neighbours that are nearer than u.
  for (const auto& [a, b, c] : {std::array{1., 1., 1.},
                                {1., 1.2, 1.3},
                                {1.3, 1., 1.9},
                                {1., 1.05, 5.},
                                {0., far<double>, far<double>},
                                {.3, .3, 2.}}) {
    const double h = .5, u = upwind(a, b, c, h);
    double sum = 0;
    for (const double v : {a, b, c})
      if (v < u) sum += (u - v) * (u - v) / (h * h);
    EXPECT_NEAR(sum, 1, 1e-12);
    for (const auto& [p, q, r] : {std::array{b, c, a}, {c, a, b}, {b, a, c}}) EXPECT_EQ(upwind(p, q, r, h), u);
  }
  EXPECT_GE(upwind(far<float>, far<float>, far<float>, .1f), far<float>);
}

TEST(LevelsetUpwind, LanesGiveTheBitsOfNumbers) {
  float in[3][lanes], out[lanes];
  for (int l = 0; l < lanes; ++l)
    for (int k = 0; k < 3; ++k)
      in[k][l] = (l * 7 + k * 5) % 11 == 0 ? far<float> : std::fmod(.37f * (l + 3 * k) * (k + 1), 1.7f);
  store(out, upwind(load(in[0]), load(in[1]), load(in[2]), floatv(.6f)));
  for (int l = 0; l < lanes; ++l) EXPECT_EQ(out[l], upwind(in[0][l], in[1][l], in[2][l], .6f));
}

// --- Exact distances

// The order at which errors fall with the spacing over three grids, in the mean and at the most.
void converges_at_first_order(const char* what, const std::vector<Shape>& shapes, double band) {
  std::vector<Errors> found;
  for (const int n : {64, 128, 256}) {
    Distances<double> d = started<double>(shapes, unit_cube(n));
    serial::fast_marching_heap(d, band);
    found.push_back(errors(d, shapes, unit_cube(n)));
  }
  for (int k = 0; k < 2; ++k) {
    const double mean = std::log2(found[k].mean / found[k + 1].mean),
                 most = std::log2(found[k].most / found[k + 1].most);
    std::printf("  %s, %d to %d: order %.2f in the mean, %.2f at the most; error at %d: mean %.3f h, most %.3f h\n",
                what, 64 << k, 128 << k, mean, most, 128 << k, found[k + 1].mean * (128 << k),
                found[k + 1].most * (128 << k));
    EXPECT_GT(mean, .8);
    EXPECT_GT(most, .6);
  }
}

TEST(LevelsetMarching, ConvergesAtFirstOrderOnSpheres) {
  // The band does not shrink with the spacing, so that it means the same on all grids. On the spheres' medial surface,
  // where distances come from two sides, and at their centres they have a kink: the band stays away from both.
  converges_at_first_order("spheres, band .06", spheres, .06);
}

TEST(LevelsetMarching, ConvergesAtFirstOrderOnATorus) {
  converges_at_first_order("torus, band .06", {Torus{{.5, .5, .5}, .28, .12}}, .06);
}

TEST(LevelsetMarching, IsExactBesideAPlane) {
  // Of a plane along an axis first order makes no error at all; each step adds h.
  const Grid grid = {20, 7, 9, .1, {0, 0, 0}};
  Distances<double> d;
  Field<double> phi = make_field<double>(grid.nx, grid.ny, grid.nz, grid.spacing, 0.);
  for (int z = 0; z < grid.nz; ++z)
    for (int y = 0; y < grid.ny; ++y)
      for (int x = 0; x < grid.nx; ++x) phi(x, y, z) = x * .1 - .73;
  serial::initialize(phi, d);
  serial::fast_marching_heap(d, std::numeric_limits<double>::infinity());
  for (int x = 0; x < grid.nx; ++x) EXPECT_NEAR(d.distance(x, 3, 4), std::abs(x * .1 - .73), 1e-12);
}

TEST(LevelsetMarching, BandErrorIsNoWorseThanThePeers) {
  // shared facts: mean .042 h in a band of 5 h at 256^3, from the corrupted input. Without it, the same field, made
  // here.
  const Scene scene = load_scene("scenes/levelset/corrupted_256.toml");
  Distances<float> marched, swept;
  serial::initialize(scene.phi, marched);
  swept = marched;
  serial::fast_marching_heap(marched, static_cast<float>(scene.band));
  openmp::fast_sweeping_sweeps(swept, static_cast<float>(scene.band), scene.rounds);
  const double h = scene.phi.spacing;
  for (const auto& [what, d] : {std::pair{"marching", &marched}, {"sweeping", &swept}}) {
    const Errors e = errors(*d, scene.shapes, scene.grid);
    std::printf("  corrupted_256, %s: mean %.4f h, most %.3f h, %ld points\n", what, e.mean / h, e.most / h, e.points);
    EXPECT_LE(e.mean / h, .042);
  }
}

// --- Both versions

TEST(LevelsetTwins, AgreeToTheBitOnEveryGrid) {
  for (const auto& [nx, ny, nz] :
       {std::array{16, 16, 16}, {17, 33, 5}, {70, 15, 21}, {33, 47, 29}, {2, 40, 31}, {100, 2, 2}})
    for (const float band : {3.2f, 7.f, everywhere}) {
      const Grid grid = {nx, ny, nz, 1. / 40, {0, 0, 0}};
      // The middle of the grid is inside the sphere, whatever its shape; some point is outside.
      const Vector3<double> middle = grid.position(nx / 2, ny / 2, nz / 2);
      const Distances<float> start = started<float>({Sphere{middle, .3 * std::max({nx, ny, nz}) / 40}}, grid);
      ASSERT_FALSE(start.interface.empty());
      const float width = band / 40;
      Distances<float> swept = start, swept_blocks = start, marched_blocks = start;
      const int rounds = serial::fast_sweeping_sweeps(swept, width, 3);
      serial::fast_sweeping_blocks(swept_blocks, width, 1, 16);
      serial::fast_marching_blocks(marched_blocks, width, 16);
      for (const int threads : {1, 2, 3, 5, 8}) {
        omp_set_num_threads(threads);
        Distances<float> a = start, b = start, c = start;
        EXPECT_EQ(openmp::fast_sweeping_sweeps(a, width, 3), rounds);
        openmp::fast_sweeping_blocks(b, width, 1, 16);
        openmp::fast_marching_blocks(c, width, 16);
        EXPECT_EQ(a.distance.value, swept.distance.value)
            << nx << ' ' << ny << ' ' << nz << " band " << band << ", " << threads;
        EXPECT_EQ(b.distance.value, swept_blocks.distance.value)
            << nx << ' ' << ny << ' ' << nz << " band " << band << ", " << threads;
        EXPECT_EQ(c.distance.value, marched_blocks.distance.value)
            << nx << ' ' << ny << ' ' << nz << " band " << band << ", " << threads;
      }
    }
}

// The most threads this process has had at a time while `work` ran, as far as looking again and again finds out.
int most_threads_during(const std::function<void()>& work) {
  std::atomic<bool> done = false;
  int most = 0;
  std::thread watch([&] {
    do {
      const std::filesystem::directory_iterator tasks("/proc/self/task");
      most = std::max(most, static_cast<int>(std::distance(begin(tasks), end(tasks))));
    } while (!done);
  });
  work();
  done = true;
  watch.join();
  return most;
}

TEST(LevelsetTwins, BlocksDoNotOpenTeamsOfTheirOwn) {
  const Distances<float> start = started<float>(spheres_and_box, unit_cube(64));
  const int levels = omp_get_max_active_levels();
  omp_set_num_threads(3);
  const auto sweep = [&] {
    Distances<float> d = start;
    openmp::fast_sweeping_blocks(d, 4.f / 64, 2, 16);
  };
  sweep();  // the team is there from now on
  const int before = most_threads_during([] {});
  omp_set_max_active_levels(3);
  EXPECT_LE(most_threads_during(sweep), before);
  omp_set_max_active_levels(levels);
}

TEST(LevelsetTwins, NothingBeyondTheBandIsTouched) {
  const Grid grid = unit_cube(48);
  Distances<float> d = started<float>(spheres_and_box, grid);
  openmp::fast_sweeping_sweeps(d, 4.f / 48, 1);
  for (const float v : d.distance.value) EXPECT_TRUE(v <= 4.f / 48 || v == far<float>);
}

// --- Blocks

TEST(LevelsetBlocks, HoldTheInterfaceOfTheirPadding) {
  const Distances<float> d = started<float>(spheres_and_box, unit_cube(80));
  const auto within = [](int i, Extent e) { return e.begin <= i && i < e.end; };
  for (const int size : {16, 27, 64})
    for (const Block& b : make_blocks(d, 5.f / 80, size)) {
      std::size_t next = 0;
      for (const Point& p : d.interface) {
        if (!within(p.x, b.padded_x) || !within(p.y, b.padded_y) || !within(p.z, b.padded_z)) continue;
        ASSERT_LT(next, b.interface.size());
        const Point& q = b.interface[next++];
        ASSERT_TRUE(q.x == p.x && q.y == p.y && q.z == p.z);
      }
      EXPECT_EQ(next, b.interface.size());
    }
}

TEST(LevelsetBlocks, CoverTheBandOnceAndDoNotChangeIt) {
  const Grid grid = unit_cube(80);
  const Distances<float> start = started<float>(spheres_and_box, grid);
  const float band = 5.f / 80;
  Distances<float> whole = start;
  serial::fast_marching_heap(whole, band);
  for (const int size : {16, 27, 64}) {
    Field<float> covered = make_field<float>(80, 80, 80, 0.f, 0.f);
    for (const Block& b : make_blocks(start, band, size))
      for (int z = b.z.begin; z < b.z.end; ++z)
        for (int y = b.y.begin; y < b.y.end; ++y)
          for (int x = b.x.begin; x < b.x.end; ++x) covered(x, y, z) += 1;
    Distances<float> blocks = start;
    serial::fast_marching_blocks(blocks, band, size);
    for (std::size_t i = 0; i < covered.value.size(); ++i) {
      EXPECT_LE(covered.value[i], 1);
      if (whole.distance.value[i] < far<float>) {
        ASSERT_EQ(covered.value[i], 1);
        // Rounding, by a path of at most 15 steps of ten roundings.
        ASSERT_NEAR(blocks.distance.value[i], whole.distance.value[i], 150 * 0x1p-24 * band);
      }
    }
  }
}

}  // namespace
}  // namespace lockstep::levelset
