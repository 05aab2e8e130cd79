// Sources against facts: which cells, faces and particles a ball takes, how much liquid pours out of it, and that no
// number of threads changes a bit.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "common/production_fluid/add_sources.h"
#include "common/production_fluid/step.h"
#include "tests/production_fluid_particles.h"
#include "tests/production_fluids.h"
#include "verify/arrays.h"

namespace lockstep::production_fluid {
namespace {

constexpr AddSources<float>* versions[] = {serial::add_sources, openmp::add_sources};
constexpr double h = .125;  // of make_air

double distance(const Vector3<double>& a, const Vector3<double>& b) {
  const Vector3<double> away = a - b;
  return std::sqrt(dot(away, away));
}

// A ball of 1.2 cells about the centre of cell (4, 5, 3).
const Source small = {.centre = {4.5 * h, 5.5 * h, 3.5 * h}, .radius = 1.2 * h, .velocity = {1, -2, 3}};

TEST(ProductionFluidAddSources, ASmallBallTakesTheCellsAndFacesAboutItsCentre) {
  for (AddSources<float>* const add_sources : versions) {
    Fluid<float> fluid = make_air(9, 11, 7);
    Particles<float> none;
    add_sources({small}, 0, fluid, none);
    const float u = 4 * std::numeric_limits<float>::epsilon();  // positions are a metre at most
    EXPECT_NEAR(fluid.phi(4, 5, 3), -1.2 * h, u);
    EXPECT_NEAR(fluid.phi(3, 5, 3), -.2 * h, u);
    EXPECT_NEAR(fluid.phi(4, 6, 3), -.2 * h, u);
    EXPECT_NEAR(fluid.phi(4, 5, 4), -.2 * h, u);
    EXPECT_NEAR(fluid.phi(5, 6, 3), (std::sqrt(2.) - 1.2) * h, u);
    EXPECT_NEAR(fluid.phi(4, 9, 3), 2.8 * h, u);
    // Along x, those beside the centre, half a cell away, and those around them, sqrt(5/4) away; not the next, 1.5.
    const Field<float>&x = fluid.velocity.u, &y = fluid.velocity.v, &z = fluid.velocity.w;
    int taken = 0;
    for_each_place(x, [&](int i, int j, int k) { taken += x(i, j, k) != 0; });
    EXPECT_EQ(taken, 2 * (1 + 4));
    for (const int i : {4, 5}) {
      EXPECT_EQ(x(i, 5, 3), 1);
      EXPECT_EQ(x(i, 6, 3), 1);
      EXPECT_EQ(x(i, 5, 2), 1);
    }
    EXPECT_EQ(x(3, 5, 3), 0);
    EXPECT_EQ(y(4, 5, 3), -2);
    EXPECT_EQ(y(4, 6, 3), -2);
    EXPECT_EQ(y(4, 7, 3), 0);
    EXPECT_EQ(z(4, 5, 3), 3);
    EXPECT_EQ(z(5, 5, 4), 3);
    EXPECT_EQ(z(4, 5, 5), 0);
  }
}

// Where phi is at most its band, the box about the ball leaves nothing out.
TEST(ProductionFluidAddSources, TheLevelSetIsThatOfTheUnion) {
  for (AddSources<float>* const add_sources : versions)
    for (const Source& ball :
         {Source{.centre = {1, .7, 1.1}, .radius = .31}, Source{.centre = {-.1, 2.6, 1}, .radius = .5}}) {
      Fluid<float> fluid = make_fluid<float>(
          19, 21, 17, h, [](double x, double y, double) { return std::min(band_of_level_set * h, y - .4 + .1 * x); });
      const Fluid<float> before = fluid;
      Particles<float> none;
      add_sources({ball}, 0, fluid, none);
      for_each_place(fluid.phi, [&](int x, int y, int z) {
        const double away = distance({(x + .5) * h, (y + .5) * h, (z + .5) * h}, ball.centre);
        EXPECT_NEAR(fluid.phi(x, y, z), std::min<double>(before.phi(x, y, z), away - ball.radius), 1e-6);
      });
    }
}

TEST(ProductionFluidAddSources, FacesInTheBallHaveItsVelocity) {
  const Source ball = {.centre = {.1, 1.3, 1}, .radius = .52, .velocity = {1, -2, 3}};
  for (AddSources<float>* const add_sources : versions) {
    Fluid<float> fluid = make_random(19, 17, 18, 1);
    const Faces<float> before = fluid.velocity;
    Particles<float> none;
    add_sources({ball}, 0, fluid, none);
    int inside = 0;
    const auto check = [&](const Field<float>& old, const Field<float>& now, double component, double dx, double dy,
                           double dz) {
      for_each_place(now, [&](int x, int y, int z) {
        const double level = distance({(x + dx) * h, (y + dy) * h, (z + dz) * h}, ball.centre) - ball.radius;
        ASSERT_GT(std::abs(level), 1e-6) << "rounding would decide";
        EXPECT_EQ(now(x, y, z), level < 0 ? float(component) : old(x, y, z)) << x << ' ' << y << ' ' << z;
        inside += level < 0;
      });
    };
    check(before.u, fluid.velocity.u, 1, 0, .5, .5);
    check(before.v, fluid.velocity.v, -2, .5, 0, .5);
    check(before.w, fluid.velocity.w, 3, .5, .5, 0);
    EXPECT_GT(inside, 300);
  }
}

TEST(ProductionFluidAddSources, CellsInObstaclesAreLeftAlone) {
  for (AddSources<float>* const add_sources : versions) {
    Fluid<float> fluid = make_air(9, 11, 7);
    fluid.solid(4, 5, 3) = fluid.solid(3, 5, 3) = -.01f;
    fluid.solid(5, 5, 3) = 0;  // not solid
    Particles<float> none;
    add_sources({small}, 0, fluid, none);
    EXPECT_EQ(fluid.phi(4, 5, 3), 1);
    EXPECT_EQ(fluid.phi(3, 5, 3), 1);
    EXPECT_LT(fluid.phi(5, 5, 3), 0);
  }
}

TEST(ProductionFluidAddSources, ParticlesInTheBallBecomeLiquid) {
  for (AddSources<float>* const add_sources : versions) {
    Fluid<float> fluid = make_air(9, 11, 7);
    std::vector<Particle> list;
    for (int k = 0; k < 33; ++k)
      list.push_back({float(k) / 32, float(5.5 * h), float(3.5 * h), .02f, k % 3 == 0 ? -1.f : 1.f});
    Particles<float> particles = sorted(fluid, list);
    const std::vector<Particle> before = list_of(particles);
    add_sources({small}, 0, fluid, particles);
    ASSERT_EQ(particles.count, 33);
    for (int i = 0; i < 33; ++i) {
      Particle expected = before[i];
      if (std::abs(expected.x - 4.5 * h) < 1.2 * h) expected.sign = -1;
      EXPECT_EQ(particle(particles, i), expected) << expected.x;
    }
  }
}

TEST(ProductionFluidAddSources, CeaseAtTheirTimeAndActInTheirOrder) {
  Source first = small, later = small;
  first.until = 1, later.velocity = {4, 5, 6};
  for (AddSources<float>* const add_sources : versions) {
    const auto at = [&](const std::vector<Source>& sources, double time) {
      Fluid<float> fluid = make_air(9, 11, 7);
      Particles<float> none;
      add_sources(sources, time, fluid, none);
      return fluid.velocity.v(4, 5, 3);
    };
    EXPECT_EQ(at({}, 0), 0);
    EXPECT_EQ(at({first}, std::nextafter(1., 0.)), -2);
    EXPECT_EQ(at({first}, 1), 0);
    EXPECT_EQ(at({first, later}, 0), 5);
    EXPECT_EQ(at({later, first}, 0), -2);
    EXPECT_EQ(at({later, first}, 2), 5);
  }
}

TEST(ProductionFluidAddSources, TheBoxHasTheCellsWithinReachAndAtMostOneMore) {
  for (const int n : {1, 2, 16, 17})
    for (double position = -3; position < n + 3; position += .37)
      for (const double reach : {.1, 1., 4.25}) {
        const Range range = cells_near(position, reach, n);
        ASSERT_LE(0, range.begin);
        ASSERT_LE(range.end, n);
        for (int x = 0; x < n; ++x) {
          const bool inside = range.begin <= x && x < range.end;
          const double away = std::abs(x + .5 - position);
          EXPECT_TRUE(inside || away > reach) << x << ' ' << position << ' ' << reach;
          EXPECT_TRUE(!inside || away <= reach + 1) << x << ' ' << position << ' ' << reach;
        }
      }
  for (const double position : {-1e15, 1e15}) {
    const Range far_away = cells_near(position, 1e9, 7);
    EXPECT_GE(far_away.begin, far_away.end);
  }
}

// Restores the number of threads.
struct Threads {
  const int before = omp_get_max_threads();
  ~Threads() { omp_set_num_threads(before); }
};

TEST(ProductionFluidAddSources, TwinsHaveTheSameBits) {
  const Threads threads;
  const int sizes[][3] = {{1, 1, 1}, {15, 3, 2}, {16, 4, 5}, {17, 16, 3}, {33, 19, 15}, {48, 7, 9}};
  for (const auto& [nx, ny, nz] : sizes) {
    const double x = nx * h, y = ny * h, z = nz * h;
    const std::vector<Source> sources = {
        {.centre = {.4 * x, .5 * y, .6 * z}, .radius = .3, .velocity = {1, 2, 3}},
        {.centre = {x, -.1, .5 * z}, .radius = .7, .velocity = {-1, 0, .5}},
        {.centre = {-.3, 1.1 * y, z + .2}, .radius = 1.1, .velocity = {2, -2, 2}},
        {.centre = {.5 * x, .5 * y, 1e8}, .radius = .5, .velocity = {9, 9, 9}},
        {.centre = {-1e8, 0, 0}, .radius = .5, .velocity = {9, 9, 9}},
        {.centre = {.9 * x, .2 * y, .1 * z}, .radius = .01, .velocity = {0, -0., 0}},
    };
    Fluid<float> start = make_random(nx, ny, nz, nx);
    std::vector<Particle> list;
    for (int k = 0; k < 20 * nx; ++k) {
      const auto share = [k](int n) { return static_cast<float>(k * n % 97) / 97; };
      list.push_back({share(31) * float(x), share(53) * float(y), share(71) * float(z), .02f, k % 2 ? 1.f : -1.f});
    }
    const Particles<float> particles = sorted(start, list);
    Fluid<float> expected = start;
    Particles<float> of_serial = particles;
    serial::add_sources(sources, 0, expected, of_serial);
    for (const int n : {1, 2, 3, 8}) {
      omp_set_num_threads(n);
      Fluid<float> fluid = start;
      Particles<float> of_openmp = particles;
      openmp::add_sources(sources, 0, fluid, of_openmp);
      EXPECT_TRUE(same_bits(fluid.phi.value, expected.phi.value)) << nx;
      EXPECT_TRUE(same_bits(fluid.velocity, expected.velocity)) << nx;
      EXPECT_EQ(list_of(of_openmp), list_of(of_serial)) << nx;
    }
  }
}

// --- In a step

template <class Real>
double volume_of(const Fluid<Real>& fluid) {
  double cells = 0;
  for_each_place(fluid.phi, [&](int x, int y, int z) {
    cells += liquid_share(fluid.phi(x, y, z), fluid.spacing);
  });
  return cells * std::pow(double(fluid.spacing), 3);
}

// What has left the ball is a rod of its radius, since neither gravity nor pressure acts on it. Particles put the
// surface right where it is off by more than the least of their radii. So its radius is known to that, and so is its
// round end, of area 2 pi r^2.
TEST(ProductionFluidAddSources, AJetInTheAirBringsItsCrossSectionTimesItsVelocity) {
  const double pi = std::acos(-1.), side = 1. / 32, r = 5.3 * side, speed = 1, frame = 1. / 24;
  const Fluid<float> air = make_fluid<float>(24, 40, 22, side, [](double, double, double) { return 1; });
  Source source = {.centre = {.37, 1, .35}, .radius = r, .velocity = {0, -speed, 0}};
  source.until = 12.5 * frame;
  for (Step<float>* const step : {serial::step_mic, openmp::step_mic}) {
    const Model model = {.gravity = {0, 0, 0}, .frame = frame, .sources = {source}};
    Liquid<float> liquid;
    StepMemory<float> memory;
    liquid.fluid = air;
    serial::start(model, liquid, memory);
    const double at_start = volume_of(liquid.fluid), off = least_radius * side;
    EXPECT_NEAR(at_start, 4. / 3 * pi * r * r * r, 4 * pi * r * r * off);
    const int particles_at_start = liquid.particles.count;
    for (int k = 0; k < 12; ++k) step(model, liquid, memory);
    const double way = speed * 12 * frame, poured = volume_of(liquid.fluid) - at_start;
    EXPECT_NEAR(poured, pi * r * r * way, 2 * pi * r * off * way + 2 * pi * r * r * off);
    // The rod's surface is 2 pi r way, the ball's 4 pi r^2; half of it would not be far from none for what is new.
    EXPECT_GT(liquid.particles.count, particles_at_start * (1 + .75 * way / (2 * r)));
    // Half a frame later it ceases. A substep begins before its time, so one more may pour.
    step(model, liquid, memory);
    const double ceased = volume_of(liquid.fluid), area = pi * r * r;
    EXPECT_GT(ceased - at_start, poured + area * speed * .5 * frame - 4 * area * off);
    EXPECT_LT(ceased - at_start, poured + area * (speed * .5 * frame + side) + 4 * area * off);
    step(model, liquid, memory);
    EXPECT_NEAR(volume_of(liquid.fluid), ceased, 4 * area * off);
  }
}

// A jet meets a block, its splash flies.
TEST(ProductionFluidAddSources, StepsHaveTheSerialBits) {
  const Threads threads;
  Fluid<float> air = make_fluid<float>(17, 26, 15, 1. / 24, [](double, double, double) { return 1; });
  for_each_place(air.solid, [&](int x, int y, int z) {
    air.solid(x, y, z) = static_cast<float>(distance({(x + .5) / 24, (y + .5) / 24, (z + .5) / 24}, {.3, .4, .3}) - .2);
  });
  const Model model = {.sources = {{.centre = {.36, .9, .3}, .radius = .13, .velocity = {.2, -1.5, 0}, .until = .14},
                                   {.centre = {0, .3, .5}, .radius = .1, .velocity = {1, 1, 0}}}};
  const auto run = [&](Step<float>* step) {
    Liquid<float> liquid;
    StepMemory<float> memory;
    liquid.fluid = air;
    serial::start(model, liquid, memory);
    std::vector<std::uint64_t> hashes = {verify::hash_of(liquid)};
    for (int k = 0; k < 4; ++k) step(model, liquid, memory), hashes.push_back(verify::hash_of(liquid));
    EXPECT_EQ(verify::first_not_finite(liquid), "");
    EXPECT_GT(liquid.particles.count, 1000);
    return hashes;
  };
  const std::vector<std::uint64_t> expected = run(serial::step_mic);
  for (const int n : {1, 2, 3, 8}) {
    omp_set_num_threads(n);
    EXPECT_EQ(run(openmp::step_mic), expected) << n << " threads";
  }
}

}  // namespace
}  // namespace lockstep::production_fluid
