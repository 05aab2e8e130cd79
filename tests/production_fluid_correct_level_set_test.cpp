// The level set that particles correct, and their radii, which it gives back: each rule by hand, and what holds of any
// particles.
#include "common/production_fluid/correct_level_set.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "common/production_fluid/adjust_radii.h"
#include "tests/production_fluid_particles.h"
#include "tests/production_fluids.h"

namespace lockstep::production_fluid {
namespace {

CorrectLevelSet<float>* const corrections[] = {serial::correct_level_set, openmp::correct_level_set};
AdjustRadii<float>* const adjustments[] = {serial::adjust_radii, openmp::adjust_radii};

// Cells of side 1/8 m, so that positions in cells are exact.
constexpr float h = .125f;
constexpr double u = 0x1p-24;
constexpr float poison = 1e9f;

template <class Phi>
Fluid<float> fluid_of(int nx, int ny, int nz, const Phi& phi) {
  return make_fluid<float>(nx, ny, nz, h, phi);
}

Field<float> corrected(CorrectLevelSet<float>* correct, const Fluid<float>& fluid, const Particles<float>& particles) {
  Field<float> result = fluid.phi;
  std::ranges::fill(result.value, poison);
  for_each_place(result, [&](int x, int y, int z) { result(x, y, z) = fluid.phi(x, y, z); });
  correct(particles, result);
  return result;
}

// Of cell (x, y, z).
Vector3<double> centre_of(int x, int y, int z) { return {(x + .5) * h, (y + .5) * h, (z + .5) * h}; }
double distance(const Particle& p, const Vector3<double>& c) {
  return std::sqrt((p.x - c.x) * (p.x - c.x) + (p.y - c.y) * (p.y - c.y) + (p.z - c.z) * (p.z - c.z));
}

// Whether a centre is one of those around a position, along an axis of n cells.
bool is_around(float position, int n, int k) {
  const int first = std::clamp(static_cast<int>(std::floor(position / h - .5)), 0, n - 1);
  return k == first || k == first + 1;
}
bool is_around(const Fluid<float>& fluid, const Particle& p, int x, int y, int z) {
  return is_around(p.x, fluid.nx, x) && is_around(p.y, fluid.ny, y) && is_around(p.z, fluid.nz, z);
}

// --- correct_level_set

// In the midst, on a centre, on the sides of the box and in its corners.
TEST(ProductionFluidCorrectLevelSet, AnEscapedBallReachesTheCentresAroundIt) {
  const Vector3<float> places[] = {{9.25f, 3.125f, 4.625f}, {2.5f, 3.5f, 4.5f}, {0, 3, 4},     {19, 0, .25f},
                                   {16, 5.75f, 6.75f},      {18.75f, 6, 7},     {0, 0, 6.875f}};
  for (const float sign : {-1.f, 1.f}) {
    const Fluid<float> fluid = fluid_of(19, 6, 7, [&](double, double, double) { return -4 * sign * double(h); });
    for (const Vector3<float>& at : places)
      for (const float radius : {h / 8, h / 2}) {
        const Particle p = {at.x * h, at.y * h, at.z * h, radius, sign};
        for (CorrectLevelSet<float>* correct : corrections) {
          const Field<float> after = corrected(correct, fluid, sorted(fluid, {p}));
          for_each_place(after, [&](int x, int y, int z) {
            if (!is_around(fluid, p, x, y, z)) {
              EXPECT_EQ(after(x, y, z), fluid.phi(x, y, z));
              return;
            }
            // The sum of squares is exact; the root and the difference round.
            const double away = distance(p, centre_of(x, y, z)), level = sign * (radius - away);
            EXPECT_NEAR(after(x, y, z), level, u * (away + std::abs(level))) << x << ' ' << y << ' ' << z;
          });
        }
      }
  }
}

// A particle beyond the surface by its radius or less has not escaped.
TEST(ProductionFluidCorrectLevelSet, ParticlesThatHaveNotEscapedChangeNothing) {
  const Fluid<float> fluid = fluid_of(18, 16, 5, [](double, double y, double) { return y - 8 * double(h); });
  const float surface = 8 * h;
  for (CorrectLevelSet<float>* correct : corrections)
    for (const float sign : {-1.f, 1.f})
      for (const float radius : {h / 8, h / 4, h / 2}) {
        const auto with = [&](float phi) {
          return corrected(correct, fluid, sorted(fluid, {{16.5f * h, surface + phi, 2.5f * h, radius, sign}}));
        };
        const Field<float> without = corrected(correct, fluid, sorted(fluid, {}));
        for_each_place(without, [&](int x, int y, int z) { EXPECT_EQ(without(x, y, z), fluid.phi(x, y, z)); });
        for (const float phi : {4 * h, radius, 0.f, -radius / 2, -radius})
          EXPECT_EQ(with(sign * phi).value, without.value);
        // A little deeper it has, and the centre behind it learns so. `away` is how far that is.
        const float phi = -sign * (radius + h / 1024);
        const int behind = sign > 0 ? 7 : 8;
        const float away = sign * (surface + phi - (float(behind) + .5f) * h);
        EXPECT_EQ(with(phi)(16, behind, 2), sign * (radius - std::abs(away)));
      }
}

// A centre between air that escaped downwards and liquid that escaped upwards. phi(x, y, z) is steep, so that both have
// escaped, and 0 at the centre.
TEST(ProductionFluidCorrectLevelSet, TheOneOfLessMagnitudeWinsAndTiesGoToAir) {
  const Fluid<float> fluid = fluid_of(3, 9, 3, [](double, double y, double) { return 4 * (y - 4.5 * double(h)); });
  const float centre = 4.5f * h;
  for (CorrectLevelSet<float>* correct : corrections) {
    const auto between = [&](float radius_of_air, float radius_of_liquid) {
      const Particle air = {1.5f * h, centre - h / 4, 1.5f * h, radius_of_air, 1},
                     liquid = {1.5f * h, centre + h / 4, 1.5f * h, radius_of_liquid, -1};
      const Field<float> one = corrected(correct, fluid, sorted(fluid, {air, liquid})),
                         other = corrected(correct, fluid, sorted(fluid, {liquid, air}));
      EXPECT_EQ(one.value, other.value);
      return one(1, 4, 1);
    };
    EXPECT_EQ(between(h / 2, h / 2), h / 4);
    EXPECT_EQ(between(3 * h / 8, 3 * h / 8), h / 8);
    EXPECT_EQ(between(3 * h / 8, h / 2), h / 8);
    EXPECT_EQ(between(h / 2, 3 * h / 8), -h / 8);
  }
}

// Of several balls of a sign the one that reaches farthest counts.
TEST(ProductionFluidCorrectLevelSet, TheFarthestReachOfASignCounts) {
  for (const float sign : {-1.f, 1.f}) {
    const Fluid<float> fluid = fluid_of(5, 5, 5, [&](double, double, double) { return -4 * sign * double(h); });
    const auto ball = [&](float x, float radius) { return Particle{x * h, 2.5f * h, 2.5f * h, radius, sign}; };
    for (CorrectLevelSet<float>* correct : corrections)
      for (const std::vector<Particle>& list : {std::vector{ball(2.25f, h / 2), ball(2.25f, h / 4)},
                                                {ball(2.25f, h / 4), ball(2.25f, h / 2)},
                                                {ball(2.25f, h / 2), ball(2.75f, h / 4)},
                                                {ball(2.25f, h / 4), ball(2.75f, h / 2)}})
        EXPECT_EQ(corrected(correct, fluid, sorted(fluid, list))(2, 2, 2), sign * h / 4);
  }
}

// phi(x, y, z) in steps of h / 16, up to 2 h; particles at steps of h / 256, so that all distances squared are exact.
// Whether one has escaped is plain but where a bound is nearer than rounding: none comes so near.
struct Noise {
  std::mt19937 random{5};

  int below(int n) { return static_cast<int>(random() % n); }
  Fluid<float> fluid(int nx, int ny, int nz) {
    return fluid_of(nx, ny, nz, [&](double, double, double) { return (below(65) - 32) * double(h) / 16; });
  }
  Particle particle(const Fluid<float>& fluid) {
    const auto along = [&](int n) { return float(below(256 * n + 1)) * h / 256; };
    for (;;) {
      const Particle p = {along(fluid.nx), along(fluid.ny), along(fluid.nz), float(26 + below(103)) * h / 256,
                          below(2) ? 1.f : -1.f};
      if (std::abs(-p.sign * value_at(fluid.phi, {p.x, p.y, p.z}) - p.radius) > 1e-6) return p;
    }
  }
  std::vector<Particle> particles(const Fluid<float>& fluid, int count) {
    std::vector<Particle> list;
    while (static_cast<int>(list.size()) < count) list.push_back(particle(fluid));
    return list;
  }
};

// What phi+ and phi- are, in double, cell by cell.
void expect_asked(const Fluid<float>& fluid, const std::vector<Particle>& list, const Field<float>& after) {
  std::vector<Particle> escaped;
  for (const Particle& p : list)
    if (-p.sign * value_at(fluid.phi, {p.x, p.y, p.z}) > p.radius) escaped.push_back(p);
  int wrong = 0;
  for_each_place(after, [&](int x, int y, int z) {
    double plus = fluid.phi(x, y, z), minus = plus;
    for (const Particle& p : escaped) {
      if (!is_around(fluid, p, x, y, z)) continue;
      const double level = p.sign * (p.radius - distance(p, centre_of(x, y, z)));
      (p.sign > 0 ? plus : minus) = p.sign > 0 ? std::max(plus, level) : std::min(minus, level);
    }
    // Distances are at most sqrt(27) / 2 h: a ball in the corner of the box. So levels are off by less than 6 u h.
    const double rounding = 6 * u * h, found = after(x, y, z);
    const bool is_plus = std::abs(found - plus) <= rounding && std::abs(plus) <= std::abs(minus) + 2 * rounding;
    const bool is_minus = std::abs(found - minus) <= rounding && std::abs(minus) <= std::abs(plus) + 2 * rounding;
    wrong += !is_plus && !is_minus;
  });
  EXPECT_EQ(wrong, 0);
}

// In boxes of all sizes, with few particles and with many.
TEST(ProductionFluidCorrectLevelSet, IsAsAskedAtAnyNumberOfThreads) {
  const int threads_before = omp_get_max_threads();
  Noise noise;
  for (const Vector3<int>& n : {Vector3<int>{1, 1, 1},
                                {1, 7, 2},
                                {2, 1, 9},
                                {3, 2, 1},
                                {15, 3, 5},
                                {16, 9, 4},
                                {17, 4, 11},
                                {33, 7, 13},
                                {49, 6, 3}})
    for (const int count : {0, 1, 15, 16, 17, 300, 4000}) {
      SCOPED_TRACE(testing::Message() << n.x << ' ' << n.y << ' ' << n.z << ' ' << count);
      const Fluid<float> fluid = noise.fluid(n.x, n.y, n.z);
      const std::vector<Particle> list = noise.particles(fluid, count);
      const Particles<float> particles = sorted(fluid, list);
      const Field<float> one = corrected(serial::correct_level_set, fluid, particles);
      expect_asked(fluid, list, one);
      EXPECT_EQ(std::count(one.value.begin(), one.value.end(), poison),
                std::ptrdiff_t(one.value.size()) - n.x * n.y * n.z);
      for (const int threads : {1, 2, 3, 8}) {
        omp_set_num_threads(threads);
        EXPECT_TRUE(same_bits(corrected(openmp::correct_level_set, fluid, particles).value, one.value))
            << threads << " threads";
      }
    }
  omp_set_num_threads(threads_before);
}

// Nor does it matter how often a particle is there.
TEST(ProductionFluidCorrectLevelSet, OrderDoesNotMatter) {
  Noise noise;
  const Fluid<float> fluid = noise.fluid(17, 5, 6);
  std::vector<Particle> list = noise.particles(fluid, 2000);
  for (CorrectLevelSet<float>* correct : corrections) {
    const Field<float> expected = corrected(correct, fluid, sorted(fluid, list));
    for (int trial = 0; trial < 4; ++trial) {
      std::vector<Particle> other = list;
      if (trial >= 2) other.insert(other.end(), list.begin(), list.end());
      std::ranges::shuffle(other, noise.random);
      EXPECT_TRUE(same_bits(corrected(correct, fluid, sorted(fluid, other)).value, expected.value));
    }
  }
}

// --- adjust_radii

Array<float> adjusted(AdjustRadii<float>* adjust, const Fluid<float>& fluid, Particles<float> particles) {
  std::ranges::fill(particles.radius, poison);
  adjust(fluid.phi, particles);
  return particles.radius;
}

// phi is linear, and constant beyond the outermost centres.
TEST(ProductionFluidAdjustRadii, BallsTouchTheSurfaceWithinBounds) {
  const Fluid<float> fluid = fluid_of(5, 16, 6, [](double, double y, double) { return y - 8 * double(h); });
  const float surface = 8 * h, least = .1f * h, most = h / 2;
  for (AdjustRadii<float>* adjust : adjustments)
    for (const float sign : {-1.f, 1.f})
      for (const float x : {0.f, .75f * h, 5 * h}) {
        const auto radius = [&](float phi) {
          return adjusted(adjust, fluid, sorted(fluid, {{x, surface + sign * phi, x, h, sign}}))[0];
        };
        for (const float phi : {h / 8, h / 4, 3 * h / 8, h / 2}) EXPECT_EQ(radius(phi), phi);
        for (const float phi : {h / 2 + h / 1024, 3 * h, 8 * h}) EXPECT_EQ(radius(phi), most);
        for (const float phi : {3 * h / 32, 0.f}) EXPECT_EQ(radius(phi), least);
        for (const float phi : {-h / 16, -h / 4, -3 * h, -8 * h}) EXPECT_EQ(radius(phi), least);  // the wrong side
      }
}

// In any order, and none behind the last.
TEST(ProductionFluidAdjustRadii, IsAsAskedAtAnyNumberOfThreads) {
  const int threads_before = omp_get_max_threads();
  Noise noise;
  for (const Vector3<int>& n : {Vector3<int>{1, 1, 1}, {1, 7, 2}, {3, 2, 1}, {17, 4, 11}, {33, 7, 3}})
    for (const int count : {0, 1, 15, 16, 17, 33, 3001}) {
      SCOPED_TRACE(testing::Message() << n.x << ' ' << n.y << ' ' << n.z << ' ' << count);
      const Fluid<float> fluid = noise.fluid(n.x, n.y, n.z);
      Particles<float> particles = sorted(fluid, noise.particles(fluid, count));
      const Array<float> radius = adjusted(serial::adjust_radii, fluid, particles);
      for (int i = 0; i < count; ++i) {
        const auto& [x, y, z, was, sign] = particle(particles, i);
        // Each of three levels of interpolation rounds by 5 u of the greatest value, 2 h; .1 h rounds, too.
        const double expected = std::clamp(sign * value_at(fluid.phi, {x, y, z}), .1 * h, .5 * h);
        EXPECT_NEAR(radius[i], expected, (3 * 5 * 2 + 1) * u * h);
      }
      for (std::size_t i = count; i < radius.size(); ++i) EXPECT_EQ(radius[i], poison);
      for (const int threads : {1, 2, 3, 8}) {
        omp_set_num_threads(threads);
        EXPECT_TRUE(same_bits(adjusted(openmp::adjust_radii, fluid, particles), radius)) << threads << " threads";
      }
    }
  omp_set_num_threads(threads_before);
}

// What they were before does not matter.
TEST(ProductionFluidAdjustRadii, ChangesRadiiAlone) {
  Noise noise;
  const Fluid<float> fluid = noise.fluid(17, 5, 6);
  const Particles<float> before = sorted(fluid, noise.particles(fluid, 100));
  for (AdjustRadii<float>* adjust : adjustments) {
    Particles<float> after = before;
    adjust(fluid.phi, after);
    const Array<float> radius = adjusted(adjust, fluid, before);
    for (int i = 0; i < before.count; ++i) EXPECT_EQ(after.radius[i], radius[i]);
    EXPECT_EQ(after.first, before.first);
    after.radius = before.radius;
    EXPECT_EQ(list_of(after), list_of(before));
  }
}

}  // namespace
}  // namespace lockstep::production_fluid
