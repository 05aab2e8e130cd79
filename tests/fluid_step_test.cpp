// Whole steps and runs of the game fluid: motion as the leapfrog says, walls, conservation laws, and what a fluid comes
// to in the end. Every serial and every openmp form, the latter at several thread counts.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "common/fluid/convert.h"
#include "common/fluid/scene.h"
#include "tests/fluid_states.h"
#include "tests/fluid_truth.h"
#include "verify/arrays.h"
#include "verify/fluid/run.h"

namespace lockstep::fluid {
namespace {

// --- One particle

TEST(FluidAlone, FeelsItselfAndGravity) {
  for (const double particles_per_metre : {5., 204., 500.}) {
    const Fluid<float> start = fluid_of(particles_per_metre, {{{.01, .02, .03}, {0, 0, 0}, {1, 2, 3}}});
    const double h2 = start.model.smoothing_length_2;
    for_each_form([&](const Form& form) {
      Fluid<float> f = start;
      find_densities(form, f);
      EXPECT_NEAR(f.density[0] / (start.model.density_coefficient * h2 * h2 * h2), 1, 4 * u);
      find_forces(form, f);
      EXPECT_EQ(vec_at(f.acceleration, 0), vec(start.model.gravity));
    });
  }
}

TEST(FluidAlone, NoParticleAtAll) {
  for_each_form([](const Form& form) {
    Fluid<float> f = fluid_of(204, {});
    for (int frame = 0; frame < 3; ++frame) form.step(f);
    EXPECT_EQ(f.particles.count, 0);
    EXPECT_TRUE(std::ranges::all_of(f.grid.cell_begin, [](int begin) { return begin == 0; }));
  });
}

// hv_k = hv_0 + k g dt, p_k = p_0 + k dt hv_0 + g dt^2 k (k + 1) / 2, v_k = hv_k - g dt / 2.
TEST(FluidAlone, FallsAsTheLeapfrogSays) {
  constexpr int steps = 100;
  const Point start{{.01, .03, -.02}, {.2, .1, -.1}, {.2, .1, -.1}};
  for_each_form(
      [&](const Form& form) {
        Fluid<float> f = fluid_of(204, {start});
        const double dt = f.model.time_step;
        const Vec g = vec(f.model.gravity), p0 = vec_at(f.particles.position, 0),
                  hv0 = vec_at(f.particles.half_velocity, 0);
        for (int step = 1; step <= steps; ++step) {
          form.step(f);
          for (int k = 0; k < 3; ++k) {
            const double speed = std::abs(hv0[k]) + step * dt * std::abs(g[k]);
            const double hv_bound = 2 * u * step * speed, p_bound = step * (2 * u * .13 + dt * hv_bound);
            ASSERT_NEAR(vec_at(f.particles.half_velocity, 0)[k], hv0[k] + step * g[k] * dt, hv_bound);
            ASSERT_NEAR(vec_at(f.particles.velocity, 0)[k], hv0[k] + (step - .5) * g[k] * dt, hv_bound + 2 * u * speed);
            ASSERT_NEAR(vec_at(f.particles.position, 0)[k],
                        p0[k] + step * dt * hv0[k] + g[k] * dt * dt * step * (step + 1) / 2, p_bound);
          }
        }
      },
      {1, 3});
}

// One step of one particle at each of the six walls: out of reach, pushed softly, pushed and thrown back, begun
// outside, and too fast for the wall's cells to notice.
TEST(FluidAlone, MeetsWallsAsTheFormulaSays) {
  struct Meeting {
    const char* name;
    double gap, half_velocity, velocity;  // from the wall inwards, m and m/s
    bool at_wall, thrown_back;
  };
  const Meeting meetings[] = {
      {"out of reach", .001, -.1, -.1, true, false},
      {"pushed", .0001, -.05, -.02, true, false},
      {"leaving", .0001, .05, .04, true, false},
      {"thrown back", .001, -8, -8, true, true},
      {"begun outside", -.0005, -.1, -.1, true, true},
      {"far outside", -.05, 0, 0, true, true},
      {"out before the wall notices", .03, -40, -40, false, false},
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const bool at_max : {false, true})
      for (const Meeting& meeting : meetings) {
        SCOPED_TRACE(std::string(meeting.name) + (at_max ? ", high " : ", low ") + "xyz"[axis]);
        const Model<float> model = model_at(204);
        const double wall = vec(at_max ? model.domain_max : model.domain_min)[axis], inwards = at_max ? -1 : 1,
                     dt = model.time_step;
        Point point{{.001, .002, .003}, {0, 0, 0}, {0, 0, 0}};
        point.position[axis] = wall + inwards * meeting.gap;
        point.half_velocity[axis] = inwards * meeting.half_velocity;
        point.velocity[axis] = inwards * meeting.velocity;
        const Fluid<float> start = fluid_of(204, {point});

        // All as distances and speeds inwards.
        const double gap = inwards * (vec_at(start.particles.position, 0)[axis] - wall),
                     hv = inwards * vec_at(start.particles.half_velocity, 0)[axis];
        const double v = inwards * vec_at(start.particles.velocity, 0)[axis];
        const double depth = model.wall_reach - (gap + hv * dt);
        const bool pushed = meeting.at_wall && depth > model.wall_min_depth;
        const double push = pushed ? model.wall_stiffness * depth - model.wall_damping * v : 0;
        const double hv_after = hv + (inwards * vec(model.gravity)[axis] + push) * dt, gap_after = gap + hv_after * dt;
        const bool thrown_back = meeting.at_wall && gap_after < 0;
        ASSERT_EQ(thrown_back, meeting.thrown_back);
        const double sign = thrown_back ? -1 : 1;

        // The depth is off by the rounding of coordinates, and the spring's stiffness multiplies that.
        const double p_error = 4 * u * (std::abs(wall) + std::abs(gap) + std::abs(hv) * dt);
        const double hv_error =
            dt * (model.wall_stiffness * p_error + 4 * u * (model.wall_damping * std::abs(v) + std::abs(push))) +
            4 * u * std::abs(hv);
        for_each_form(
            [&](const Form& form) {
              Fluid<float> f = start;
              form.step(f);
              EXPECT_NEAR(inwards * (vec_at(f.particles.position, 0)[axis] - wall), sign * gap_after,
                          p_error + dt * hv_error);
              EXPECT_NEAR(inwards * vec_at(f.particles.half_velocity, 0)[axis], sign * hv_after, hv_error);
              EXPECT_NEAR(inwards * vec_at(f.particles.velocity, 0)[axis], sign * (hv + hv_after) / 2, hv_error);
            },
            {1, 3});
      }
}

// --- Many particles

TEST(FluidMomentum, IsConservedToRoundingWithoutWallsAndGravity) {
  Random random(3);
  std::vector<Point> points;
  for (int i = 0; i < 700; ++i) {
    const Vec v = random.vec(.5);
    points.push_back({random.vec(.025), v, v});
  }
  Fluid<float> start = fluid_of(204, points);
  start.model.gravity = {0, 0, 0};
  start.model.walls = false;
  for_each_form(
      [&](const Form& form) {
        Fluid<float> f = start;
        Vector3<double> before = verify::momentum(f);
        for (int step = 0; step < 50; ++step) {
          form.step(f);
          ASSERT_TRUE(verify::first_not_finite(f).empty());
          const Vector3<double> after = verify::momentum(f);
          const double bound = verify::momentum_rounding(f);
          ASSERT_NEAR(after.x, before.x, bound) << "step " << step;
          ASSERT_NEAR(after.y, before.y, bound) << "step " << step;
          ASSERT_NEAR(after.z, before.z, bound) << "step " << step;
          before = after;
        }
      },
      {1, 2, 3});
}

TEST(FluidRuns, OwnerGatherLeavesTheSameBitsAtEveryThreadCount) {
  const Scene scene = load_scene("scenes/fluid/splash.toml");
  std::optional<Particles<float>> first;
  at_thread_counts(thread_counts, [&](int) {
    Fluid<float> f = make_fluid(convert<float>(scene.model), scene.particles);
    for (int frame = 0; frame < 20; ++frame) openmp::step_owner_gather(f);
    if (!first) first = f.particles;
    expect_same_bits(f.particles, *first);
  });
}

TEST(FluidRuns, DamBreakStaysFiniteInsideAndLosesEnergy) {
  constexpr int frames = 2000, window = 200;
  const Scene scene = load_scene("scenes/fluid/dam_break_5k.toml");
  ASSERT_TRUE(scene.holds.energy_falls_after);
  const int splash = *scene.holds.energy_falls_after;
  Fluid<float> f = make_fluid(convert<float>(scene.model), scene.particles);
  std::vector<double> peaks;
  at_thread_counts({1}, [&](int) {  // the same bits as at any other count
    for (int frame = 0; frame < frames; ++frame) {
      openmp::step_owner_gather(f);
      ASSERT_TRUE(verify::first_not_finite(f).empty()) << "frame " << frame;
      ASSERT_TRUE(verify::inside_domain(f)) << "frame " << frame;
      if (frame < splash) continue;
      if ((frame - splash) % window == 0) peaks.push_back(0);
      peaks.back() = std::max(peaks.back(), verify::energy(f));
    }
  });
  for (std::size_t k = 1; k < peaks.size(); ++k)
    EXPECT_LT(peaks[k], peaks[k - 1]) << "from frame " << splash + k * window;
  if (!peaks.empty())
    std::printf("  energy: peak %.4g J after the splash, %.4g J in the last %d frames\n", peaks.front(), peaks.back(),
                window);
}

// Pressure is none where every density is the rest density, and viscosity takes the motion away, so that is where a
// blob that nothing holds comes to rest: at 470 particles a metre within six hundred steps, for the time step is within
// its limit (notes/fluid.md).
//
// What remains is rounding: that of the densities that the forces see, and that of positions. A particle that would
// move by less than half an ulp stays, so distances, which are more than half of the lattice's spacing, are off by an
// ulp or so, and densities by three times as much, being about as the inverse cube.
TEST(FluidRuns, ABlobSettlesAtTheRestDensity) {
  constexpr double particles_per_metre = 470, spacing = 1 / particles_per_metre;
  Random random(8);
  std::vector<Point> points;
  for (int z = 0; z < 8; ++z)
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 8; ++x) {
        const Vec jitter = random.vec(.05);
        points.push_back(
            {{(x - 3.5 + jitter[0]) * spacing, (y - 3.5 + jitter[1]) * spacing, (z - 3.5 + jitter[2]) * spacing},
             {},
             {}});
      }
  Fluid<float> start = fluid_of(particles_per_metre, points);
  start.model.gravity = {0, 0, 0};
  start.model.walls = false;
  for_each_form(
      [&](const Form& form) {
        Fluid<float> f = start;
        for (int step = 0; step < 600; ++step) form.step(f);
        const TrueDensities densities = true_densities(f.model, f.particles);
        const double rest_density = f.model.twice_rest_density / 2, ulp = 2 * u * 4 * spacing;  // of a coordinate
        for (int i = 0; i < f.particles.count; ++i)
          ASSERT_NEAR(densities.value[i], rest_density, densities.bound[i] + rest_density * 3 * ulp / (spacing / 2))
              << "particle " << f.particles.id[i];
      },
      {1, 3});
}

}  // namespace
}  // namespace lockstep::fluid
