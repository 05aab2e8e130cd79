// Spray: flights by their closed form, what stops a drop, and what becomes of it.
#include "common/production_fluid/advance_spray.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <cmath>
#include <random>
#include <vector>

#include "tests/production_fluids.h"

namespace lockstep::production_fluid {
namespace {

AdvanceSpray<float>* const advances[] = {serial::advance_spray, openmp::advance_spray};

constexpr float h = .125f;
constexpr Vector3<float> weightless = {0, 0, 0};

struct Flyer {
  Vector3<float> position, velocity;
  float radius;
};

Spray<float> spray_of(const std::vector<Flyer>& drops) {
  Spray<float> spray;
  resize(spray, drops.size());
  for (std::size_t i = 0; i < drops.size(); ++i) {
    store(spray.position, i, drops[i].position), store(spray.velocity, i, drops[i].velocity);
    spray.radius[i] = drops[i].radius;
  }
  return spray;
}

void expect_equal(const Vector3<float>& a, const Vector3<float>& b) {
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.y, b.y);
  EXPECT_EQ(a.z, b.z);
}

// All numbers have few bits, so that nothing rounds.
TEST(ProductionFluidAdvanceSpray, FliesByTheClosedForm) {
  const Fluid<float> fluid = make_air(64, 64, 64);
  const Vector3<float> x0 = {1, 2, 3}, v0 = {2, 4, -1}, g = {.5f, -8, .25f};
  const float dt = 1 / 64.f;
  for (AdvanceSpray<float>* advance : advances) {
    Spray<float> spray = spray_of({{x0, v0, h / 2}});
    Particles<float> particles;
    for (int k = 1; k <= 40; ++k) {
      advance(fluid, g, dt, spray, particles);
      ASSERT_EQ(spray.count, 1);
      const float t = k * dt, half = k * (k + 1) / 2 * dt * dt;
      expect_equal(load(spray.velocity, 0), v0 + t * g);
      expect_equal(load(spray.position, 0), x0 + t * v0 + half * g);
      EXPECT_EQ(spray.radius[0], h / 2);
    }
    EXPECT_EQ(particles.count, 0);
  }
}

// A surface at 4 h, and a drop that falls onto it.
TEST(ProductionFluidAdvanceSpray, ComesBackWhereItTouchesTheSurface) {
  const Fluid<float> fluid =
      make_fluid<float>(16, 16, 16, h, [](double, double y, double) { return y - 4 * double(h); });
  const float r = h / 4;
  for (AdvanceSpray<float>* advance : advances)
    for (const float phi : {-3 * h, 0.f, r, r + h / 1024, 2 * h}) {
      Spray<float> spray = spray_of({{{h, 4 * h + phi + h, 2 * h}, {0, -1, 0}, r}});
      Particles<float> particles;
      resize(particles, 2);
      particles.radius[1] = 5, particles.sign[1] = 1, particles.first.assign(7, 9);
      advance(fluid, weightless, h, spray, particles);
      EXPECT_EQ(spray.count, phi > r);
      ASSERT_EQ(particles.count, 2 + (phi <= r));
      EXPECT_EQ(particles.radius[1], 5);
      EXPECT_EQ(particles.sign[1], 1);
      EXPECT_EQ(particles.first, Array<std::int32_t>(7, 9));
      if (phi > r) continue;
      expect_equal(load(particles.position, 2), {h, 4 * h + phi, 2 * h});
      EXPECT_EQ(particles.radius[2], r);
      EXPECT_EQ(particles.sign[2], -1);
    }
}

TEST(ProductionFluidAdvanceSpray, StopsAtTheSidesAndSlides) {
  const Fluid<float> fluid = make_air(8, 12, 16);
  const float r = h / 4;
  const Vector3<float> middle = {4 * h, 6 * h, 8 * h}, size = {8 * h, 12 * h, 16 * h};
  for (AdvanceSpray<float>* advance : advances)
    for (int axis = 0; axis < 3; ++axis)
      for (const float side : {-1.f, 1.f}) {
        float Vector3<float>::*const along[] = {&Vector3<float>::x, &Vector3<float>::y, &Vector3<float>::z};
        Vector3<float> velocity = {1, 1, 1};
        velocity.*along[axis] = side * 100;
        Spray<float> spray = spray_of({{middle, velocity, r}});
        Particles<float> particles;
        advance(fluid, weightless, h, spray, particles);
        ASSERT_EQ(spray.count, 1);
        Vector3<float> at = middle + h * velocity, left = velocity;
        at.*along[axis] = side < 0 ? r : size.*along[axis] - r;
        left.*along[axis] = 0;
        expect_equal(load(spray.position, 0), at);
        expect_equal(load(spray.velocity, 0), left);
      }
}

// Within a radius of a side, a drop that flies away from it keeps its velocity.
TEST(ProductionFluidAdvanceSpray, LeavesASide) {
  const Fluid<float> fluid = make_air(8, 8, 8);
  for (AdvanceSpray<float>* advance : advances) {
    Spray<float> spray = spray_of({{{0, 4 * h, 8 * h}, {.0625f, 0, -.0625f}, h / 2}});
    Particles<float> particles;
    advance(fluid, weightless, h, spray, particles);
    expect_equal(load(spray.position, 0), {h / 2, 4 * h, 7.5f * h});
    expect_equal(load(spray.velocity, 0), {.0625f, 0, -.0625f});
  }
}

TEST(ProductionFluidAdvanceSpray, LeavesThroughAnOpenTopAlone) {
  Fluid<float> fluid = make_air(8, 8, 8);
  for (AdvanceSpray<float>* advance : advances)
    for (const bool open : {false, true}) {
      fluid.open_top = open;
      const Vector3<float> middle = {4 * h, 4 * h, 4 * h};
      Spray<float> spray = spray_of({{middle, {0, 5, 0}, h / 4},  // above the top
                                     {middle, {0, 4, 0}, h / 4},  // at the top
                                     {middle, {0, -5, 0}, h / 4}});
      Particles<float> particles;
      advance(fluid, weightless, h, spray, particles);
      EXPECT_EQ(particles.count, 0);
      ASSERT_EQ(spray.count, open ? 2 : 3);
      expect_equal(load(spray.position, open ? 0 : 1), {4 * h, open ? 8 * h : 7.75f * h, 4 * h});
      expect_equal(load(spray.velocity, open ? 0 : 1), {0, open ? 4.f : 0.f, 0});
      expect_equal(load(spray.position, open ? 1 : 2), {4 * h, .25f * h, 4 * h});
      if (!open) expect_equal(load(spray.position, 0), {4 * h, 7.75f * h, 4 * h});
    }
}

// An inclined plane is linear, so its distance has no error but rounding. A drop that comes from above stops at the
// plane, keeps the velocity along it, and then slides down with the part of gravity along it.
TEST(ProductionFluidAdvanceSpray, SlidesDownAnObstacle) {
  Fluid<float> fluid = make_air(32, 32, 8);
  const double slope = std::sqrt(.5);  // of the normal, (slope, slope, 0)
  const auto solid = [&](double x, double y) { return slope * (x + y) - 2; };
  for_each_place(fluid.solid, [&](int x, int y, int z) {
    fluid.solid(x, y, z) = static_cast<float>(solid((x + .5) * h, (y + .5) * h));
  });
  const float r = h / 4;
  for (AdvanceSpray<float>* advance : advances) {
    Spray<float> spray = spray_of({{{1, 2, .5f}, {1, -4, 1}, r}});
    Particles<float> particles;
    advance(fluid, weightless, .125f, spray, particles);
    ASSERT_EQ(spray.count, 1);
    const Vector3<float> x = load(spray.position, 0), v = load(spray.velocity, 0);
    EXPECT_NEAR(solid(x.x, x.y), r, 1e-6);
    EXPECT_NEAR(x.x - x.y, 1.125 - 1.5, 1e-6);  // it has been moved along the normal
    EXPECT_NEAR(v.x, 2.5, 1e-6);
    EXPECT_NEAR(v.y, -2.5, 1e-6);
    EXPECT_EQ(v.z, 1);
    const float dt = 1 / 64.f;
    for (int k = 0; k < 4; ++k) advance(fluid, {0, -8, 0}, dt, spray, particles);
    const Vector3<float> later = load(spray.velocity, 0), at = load(spray.position, 0);
    EXPECT_NEAR(later.x, 2.5 + 4 * dt * 4, 1e-5);  // half of gravity along x and y
    EXPECT_NEAR(later.y, -2.5 - 4 * dt * 4, 1e-5);
    EXPECT_NEAR(solid(at.x, at.y), r, 1e-5);
  }
}

// Where the distance from obstacles has no gradient, a drop flies on.
TEST(ProductionFluidAdvanceSpray, FliesOnWithoutAGradient) {
  const Fluid<float> fluid = make_box(8, 8, 8);
  for (AdvanceSpray<float>* advance : advances) {
    Spray<float> spray = spray_of({{{4 * h, 4 * h, 4 * h}, {1, -1, 2}, h / 2}});
    Particles<float> particles;
    advance(fluid, weightless, h, spray, particles);
    expect_equal(load(spray.position, 0), {5 * h, 3 * h, 6 * h});
    expect_equal(load(spray.velocity, 0), {1, -1, 2});
  }
}

// The sizes of drops number them. Those above the top leave, those at the surface come back, others fly on.
TEST(ProductionFluidAdvanceSpray, NothingIsLostAndTheOrderStays) {
  const int threads_before = omp_get_max_threads();
  Fluid<float> fluid = make_fluid<float>(16, 16, 16, h, [](double, double y, double) { return y - 8 * double(h); });
  fluid.open_top = true;
  std::mt19937 random(1);
  for (const int count : {0, 1, 15, 16, 17, 1023, 1024, 1025, 5000}) {
    SCOPED_TRACE(count);
    std::vector<Flyer> drops;
    std::vector<float> fly, come_back;
    for (int i = 0; i < count; ++i) {
      const float radius = h / 4 + h / 4 * i / count;
      const int which = static_cast<int>(random() % 3);
      drops.push_back({{8 * h, (which == 0 ? 15 : 10) * h, 8 * h}, {0, which == 1 ? -1.f : 2.f, 0}, radius});
      if (which == 1) come_back.push_back(radius);
      if (which == 2) fly.push_back(radius);
    }
    for (AdvanceSpray<float>* advance : advances)
      for (const int threads : {1, 2, 3, 8}) {
        omp_set_num_threads(threads);
        Spray<float> spray = spray_of(drops);
        Particles<float> particles;
        resize(particles, 5);
        advance(fluid, weightless, 2 * h, spray, particles);
        ASSERT_EQ(spray.count, int(fly.size()));
        ASSERT_EQ(particles.count, 5 + int(come_back.size()));
        for (std::size_t i = 0; i < fly.size(); ++i) EXPECT_EQ(spray.radius[i], fly[i]);
        for (std::size_t i = 0; i < come_back.size(); ++i) {
          EXPECT_EQ(particles.radius[5 + i], come_back[i]);
          EXPECT_EQ(particles.sign[5 + i], -1);
          EXPECT_EQ(particles.position.y[5 + i], 8 * h);
        }
      }
  }
  omp_set_num_threads(threads_before);
}

}  // namespace
}  // namespace lockstep::production_fluid
