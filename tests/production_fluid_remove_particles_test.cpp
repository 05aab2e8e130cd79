// Particles that are removed: each rule by hand, and what holds of any particles.
#include "common/production_fluid/remove_particles.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/production_fluid_particles.h"
#include "tests/production_fluids.h"

namespace lockstep::production_fluid {
namespace {

RemoveParticles<float>* const removes[] = {serial::remove_particles, openmp::remove_particles};

// Left by an earlier step, to be overwritten.
Particles<float> old() {
  Particles<float> particles;
  resize(particles, 40);
  particles.first.assign(7, -1);
  return particles;
}

enum class Fate { kept, spray, deleted };

// What becomes of a single particle.
Fate fate_of(RemoveParticles<float>* remove, const Fluid<float>& fluid, const Particle& p) {
  Particles<float> kept = old();
  Spray<float> spray;
  remove(fluid, sorted(fluid, {p}), kept, spray);
  EXPECT_LE(kept.count + spray.count, 1);
  EXPECT_EQ(kept.first.back(), kept.count);
  return kept.count == 1 ? Fate::kept : spray.count == 1 ? Fate::spray : Fate::deleted;
}

// Cells of side 1/8 m. phi is linear, so it is exact between the centres; all numbers here have few bits.
constexpr float h = .125f;
Fluid<float> half_full() {
  return make_fluid<float>(20, 16, 18, h, [](double, double y, double) { return y - 8 * double(h); });
}
constexpr float surface = 8 * h;

TEST(ProductionFluidRemoveParticles, LiquidThatGotAwayBecomesSpray) {
  const Fluid<float> fluid = half_full();
  for (RemoveParticles<float>* remove : removes)
    for (const float radius : {h / 8, h / 4, h / 2}) {
      const auto fate = [&](float phi) { return fate_of(remove, fluid, {h, surface + phi, h, radius, -1}); };
      EXPECT_EQ(fate(-radius), Fate::kept);
      EXPECT_EQ(fate(radius), Fate::kept);
      EXPECT_EQ(fate(1.5f * radius), Fate::kept);  // not by more than that
      EXPECT_EQ(fate(1.5f * radius + h / 1024), Fate::spray);
      EXPECT_EQ(fate(5 * h), Fate::spray);  // also where a particle would be too far away
    }
}

TEST(ProductionFluidRemoveParticles, AirLostInTheLiquidIsDeleted) {
  const Fluid<float> fluid = half_full();
  for (RemoveParticles<float>* remove : removes)
    for (const float radius : {h / 8, h / 4, h / 2}) {
      const auto fate = [&](float phi) { return fate_of(remove, fluid, {h, surface + phi, h, radius, 1}); };
      EXPECT_EQ(fate(radius), Fate::kept);
      EXPECT_EQ(fate(-1.5f * radius), Fate::kept);
      EXPECT_EQ(fate(-1.5f * radius - h / 1024), Fate::deleted);
      EXPECT_EQ(fate(-5 * h), Fate::deleted);
    }
}

TEST(ProductionFluidRemoveParticles, ParticlesFarFromTheSurfaceAreDeleted) {
  const Fluid<float> fluid = half_full();
  for (RemoveParticles<float>* remove : removes)
    for (const float sign : {-1.f, 1.f}) {
      const auto fate = [&](float phi) { return fate_of(remove, fluid, {h, surface + sign * phi, h, h / 2, sign}); };
      EXPECT_EQ(fate(4 * h), Fate::kept);
      EXPECT_EQ(fate(4 * h + h / 1024), Fate::deleted);
    }
}

TEST(ProductionFluidRemoveParticles, ParticlesInObstaclesAreDeleted) {
  Fluid<float> fluid = half_full();
  for_each_place(fluid.solid, [&](int x, int y, int z) { fluid.solid(x, y, z) = (float(x) + .5f - 10) * h; });
  for (RemoveParticles<float>* remove : removes)
    for (const float sign : {-1.f, 1.f}) {
      const auto fate = [&](float x, float phi) { return fate_of(remove, fluid, {x, surface + phi, h, h / 4, sign}); };
      EXPECT_EQ(fate(10 * h, 0), Fate::kept);
      EXPECT_EQ(fate(10 * h - h / 1024, 0), Fate::deleted);
      EXPECT_EQ(fate(9 * h, -sign * h), Fate::deleted);  // it is no spray there
      EXPECT_EQ(fate(11 * h, -sign * h), sign < 0 ? Fate::spray : Fate::deleted);
    }
}

// A cell of air, `phi` deep, in the midst of liquid or at a corner of the box; and the particle `away` cells from its
// centre along each axis.
Fate fate_in_bubble(RemoveParticles<float>* remove, const Vector3<int>& cell, float phi, float other, float away,
                    const Particle& like) {
  Fluid<float> fluid = make_fluid<float>(5, 6, 7, h, [](double, double, double) { return -h / 16.; });
  fluid.phi(cell.x, cell.y, cell.z) = phi;
  fluid.phi(cell.x, cell.y, cell.z - (cell.z > 0 ? 1 : -1)) = other;
  const auto along = [&](int n, bool inwards) { return (float(n) + .5f + (inwards ? away : -away)) * h; };
  return fate_of(
      remove, fluid,
      {along(cell.x, cell.x == 0), along(cell.y, cell.y == 0), along(cell.z, cell.z == 0), like.radius, like.sign});
}

TEST(ProductionFluidRemoveParticles, ParticlesThatHoldBubblesOpenAreDeleted) {
  const Particle air = {0, 0, 0, h / 2, 1}, liquid = {0, 0, 0, h / 2, -1};
  const float below = -h / 16;
  for (RemoveParticles<float>* remove : removes)
    for (const Vector3<int>& cell : {Vector3<int>{2, 3, 3}, {0, 0, 0}, {4, 5, 6}, {4, 0, 3}}) {
      const auto fate = [&](float phi, float other, float away, const Particle& like) {
        return fate_in_bubble(remove, cell, phi, other, away, like);
      };
      EXPECT_EQ(fate(h / 2, below, 0, air), Fate::deleted);
      EXPECT_EQ(fate(h / 2, below, .25f, air), Fate::deleted);  // .43 of a cell from the centre
      EXPECT_EQ(fate(h / 2, below, .3125f, air), Fate::kept);   // .54
      EXPECT_EQ(fate(h / 2, below, .125f, {0, 0, 0, h / 8, 1}), Fate::kept);
      EXPECT_EQ(fate(h / 2, below, 0, liquid), Fate::kept);
      EXPECT_EQ(fate(h / 2, h / 2, 0, air), Fate::deleted);    // two cells as high as each other
      EXPECT_EQ(fate(h / 2, .5625f * h, 0, air), Fate::kept);  // the other is the bubble
      EXPECT_EQ(fate(h / 1024, below, 0, air), Fate::deleted);
      EXPECT_EQ(fate(0, below, 0, air), Fate::kept);          // no air
      EXPECT_EQ(fate(h, below, 0, air), Fate::kept);          // it is wide enough
      EXPECT_EQ(fate(below, 2 * below, 0, air), Fate::kept);  // a maximum in the liquid
    }
}

// Any neighbour that is higher makes a cell none.
TEST(ProductionFluidRemoveParticles, BubblesAreHigherThanAllSixNeighbours) {
  for (RemoveParticles<float>* remove : removes)
    for (const auto& [dx, dy, dz] : {Vector3<int>{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}) {
      Fluid<float> fluid = make_fluid<float>(5, 5, 5, h, [](double, double, double) { return -h / 16.; });
      fluid.phi(2, 2, 2) = h / 2, fluid.phi(2 + dx, 2 + dy, 2 + dz) = .75f * h;
      EXPECT_EQ(fate_of(remove, fluid, {2.5f * h, 2.5f * h, 2.5f * h, h / 2, 1}), Fate::kept);
      EXPECT_EQ(fate_of(remove, fluid, {(2.5f + dx) * h, (2.5f + dy) * h, (2.5f + dz) * h, h / 2, 1}), Fate::deleted);
    }
}

// A linear velocity is interpolated without error.
TEST(ProductionFluidRemoveParticles, SprayHasTheGridsVelocity) {
  Fluid<float> fluid = half_full();
  for_each_place(fluid.velocity.u, [&](int x, int y, int z) { fluid.velocity.u(x, y, z) = x + 2 * (y + .5f); });
  for_each_place(fluid.velocity.v, [&](int x, int y, int z) { fluid.velocity.v(x, y, z) = y - 4 * (z + .5f); });
  for_each_place(fluid.velocity.w, [&](int x, int y, int z) { fluid.velocity.w(x, y, z) = .5f * (x + .5f) + z; });
  const Particle away = {3.25f * h, surface + 1.5f * h, 5.75f * h, h / 4, -1};
  for (RemoveParticles<float>* remove : removes) {
    Particles<float> kept = old();
    Spray<float> spray;
    resize(spray, 1);
    spray.radius[0] = 7, store(spray.position, 0, Vector3<float>{1, 2, 3}),
    store(spray.velocity, 0, Vector3<float>{4, 5, 6});
    remove(fluid, sorted(fluid, {away}), kept, spray);
    ASSERT_EQ(spray.count, 2);
    EXPECT_EQ(spray.radius[0], 7);  // what was there stays
    EXPECT_EQ(spray.position.z[0], 3);
    EXPECT_EQ(spray.velocity.x[0], 4);
    EXPECT_EQ(spray.radius[1], away.radius);
    EXPECT_EQ(spray.position.x[1], away.x);
    EXPECT_EQ(spray.position.y[1], away.y);
    EXPECT_EQ(spray.position.z[1], away.z);
    const float x = 3.25f, y = 9.5f, z = 5.75f;
    EXPECT_FLOAT_EQ(spray.velocity.x[1], x + 2 * y);
    EXPECT_FLOAT_EQ(spray.velocity.y[1], y - 4 * z);
    EXPECT_FLOAT_EQ(spray.velocity.z[1], .5f * x + z);
  }
}

// Random particles around a plane surface, with obstacles beyond x = 17 h. What should become of each is plain, but
// where a bound is nearer than rounding: no particle comes so near.
Fate expected_fate(const Particle& p) {
  const double phi = double(p.y) - surface, r = p.radius;
  if (p.x > 17 * h) return Fate::deleted;
  if (-p.sign * phi > 1.5 * r) return p.sign < 0 ? Fate::spray : Fate::deleted;
  return std::abs(phi) > 4 * h ? Fate::deleted : Fate::kept;
}
bool is_plain(const Particle& p) {
  const double phi = double(p.y) - surface, r = p.radius;
  const auto near = [](double a, double b) { return std::abs(a - b) < 1e-5; };
  return !near(p.x, 17 * h) && !near(-p.sign * phi, 1.5 * r) && !near(std::abs(phi), 4 * h);
}

TEST(ProductionFluidRemoveParticles, NothingIsLostAndTheOrderStays) {
  const int threads_before = omp_get_max_threads();
  Fluid<float> fluid = half_full();
  for_each_place(fluid.solid, [&](int x, int y, int z) { fluid.solid(x, y, z) = (17 - (float(x) + .5f)) * h; });
  std::mt19937 random(1);
  const auto any = [&](float least, float most) { return std::uniform_real_distribution(least, most)(random); };
  for (const int count : {0, 1, 15, 16, 17, 1023, 1024, 1025, 20000}) {
    SCOPED_TRACE(count);
    std::vector<Particle> list;
    while (int(list.size()) < count) {
      Particle p = {any(0, 20 * h), surface + any(-5 * h, 5 * h), any(0, 18 * h), any(h / 10, h / 2), 1};
      p.sign = (p.y < surface) == (random() % 8 != 0) ? -1 : 1;  // most are on their own side
      if (is_plain(p)) list.push_back(p);
    }
    const Particles<float> particles = sorted(fluid, list);
    std::vector<Particle> stay, fly;
    for (const Particle& p : list_of(particles)) {
      if (expected_fate(p) == Fate::kept) stay.push_back(p);
      if (expected_fate(p) == Fate::spray) fly.push_back(p);
    }
    const Particles<float> expected = sorted(fluid, stay);
    for (RemoveParticles<float>* remove : removes)
      for (const int threads : {1, 2, 3, 8}) {
        omp_set_num_threads(threads);
        Particles<float> kept = old();
        Spray<float> spray;
        resize(spray, 3);
        remove(fluid, particles, kept, spray);
        EXPECT_EQ(list_of(kept), stay);
        EXPECT_EQ(kept.first, expected.first);
        ASSERT_EQ(spray.count, 3 + int(fly.size()));
        for (std::size_t i = 0; i < fly.size(); ++i) {
          EXPECT_EQ(spray.position.x[3 + i], fly[i].x);
          EXPECT_EQ(spray.radius[3 + i], fly[i].radius);
        }
      }
  }
  omp_set_num_threads(threads_before);
}

TEST(ProductionFluidRemoveParticles, ASingleCellHoldsParticles) {
  const Fluid<float> fluid = make_fluid<float>(1, 1, 1, h, [](double, double, double) { return -h / 8.; });
  for (RemoveParticles<float>* remove : removes) {
    EXPECT_EQ(fate_of(remove, fluid, {0, h / 2, h, h / 8, -1}), Fate::kept);
    EXPECT_EQ(fate_of(remove, fluid, {h, h, 0, h / 8, 1}), Fate::kept);
    EXPECT_EQ(fate_of(remove, fluid, {h, h, 0, h / 16, 1}), Fate::deleted);
  }
}

}  // namespace
}  // namespace lockstep::production_fluid
