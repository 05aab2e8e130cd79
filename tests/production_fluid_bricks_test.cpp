// Bricks that advection does not trace: what they get is what a trace gives, to the bit.
#include <cmath>
#include <cstdint>

#include "common/math.h"
#include "tests/production_fluid_advection.h"

namespace lockstep::production_fluid {
namespace {

constexpr int nx = 52, ny = 23, nz = 19;

// Slow enough everywhere, so most bricks keep the band's value. Then one face in a corner is fast, so none does.
TEST(ProductionFluidBricks, KeepWhatATraceGives) {
  const Field<float> phi = level_set<float>(nx, ny, nz, 1, [](double x, double y, double z) {
    return std::fmin(std::fmax(std::hypot(x - 14, y - 11, z - 9) - 5, -4), 4);
  });
  const Faces<float> slow = random_faces(nx, ny, nz, 1.f, .999);
  Faces<float> fast = slow;
  fast.u(nx, ny - 1, nz - 1) = 3;
  for (LevelSet* advect : level_sets)
    for (const float dt : {1.f, -.5f}) {
      const Field<float> kept = advected(advect, phi, slow, dt), traced = advected(advect, phi, fast, dt);
      for_each_point(kept, [&](int x, int y, int z, float v) {
        if (x < nx - 8) {
          EXPECT_EQ(bits_of(v), bits_of(traced(x, y, z))) << x << ' ' << y << ' ' << z;
        }
      });
      expect_padding_is_poison(kept);
    }
}

// Zeros of both signs, but for one face, whose neighbours within a cell may change. All others become +0.
TEST(ProductionFluidBricks, StandStillWhereNothingMoves) {
  Numbers number;
  const auto zero = [&](double, double, double) { return number() < 0 ? -0. : 0.; };
  Faces<float> faces = faces_of<float>(nx, ny, nz, 1, zero, zero, zero);
  faces.u(16, 8, 8) = .75f;
  for (Velocity* advect : velocities) {
    const Faces<float> result = advected(advect, faces, 1);
    expect_padding_is_poison(result);
    EXPECT_NE(result.u(16, 8, 8), 0);
    for_each_component(faces, result, [&](const Field<float>&, const Field<float>& after) {
      for_each_point(after, [&](int x, int y, int z, float v) {
        const bool is_far = std::abs(x - 16) > 2 || std::abs(y - 8) > 2 || std::abs(z - 8) > 2;
        if (is_far) {
          EXPECT_EQ(bits_of(v), 0) << x << ' ' << y << ' ' << z;
        }
      });
    });
  }
}

// The velocity is (speed, speed, 0) but in one brick, which stands still. At two corners of it, u has a mean v of half
// the speed, since two of the four faces of v are outside; there the foot of dt = 1 lies beside faces of u that move.
// What semi-Lagrangian advection brings is worked out by hand.
TEST(ProductionFluidBricks, AreTracedBesideAirThatMoves) {
  const auto expect_at_corner = [](float speed, int x, int y, int z, float expected) {
    const auto flow = [speed](double x, double y, double z) {
      return x >= 16 && x < 32 && y >= 8 && y < 12 && z >= 8 && z < 12 ? 0 : speed;
    };
    const Faces<float> faces = faces_of<float>(nx, ny, nz, 1, flow, flow, [](double, double, double) { return 0; });
    for (Velocity* advect : velocities) EXPECT_GT(advected(advect, faces, 1).u(x, y, z) * speed, 0);
    for (Velocity* advect : {velocities[0], velocities[1]}) EXPECT_EQ(advected(advect, faces, 1).u(x, y, z), expected);
  };
  expect_at_corner(1, 16, 8, 8, .625f);
  expect_at_corner(-1, 31, 11, 11, -.8125f);
}

}  // namespace
}  // namespace lockstep::production_fluid
