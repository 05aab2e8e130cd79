// The game fluid's densities and forces against closed formulas and against sums over all pairs in double. Every serial
// and every openmp form, the latter at several thread counts.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "common/fluid/convert.h"
#include "common/fluid/id_order.h"
#include "common/fluid/scene.h"
#include "tests/fluid_states.h"
#include "tests/fluid_truth.h"
#include "verify/arrays.h"
#include "verify/fluid/bounds.h"

namespace lockstep::fluid {
namespace {

// --- Few particles, closed formulas

TEST(FluidPair, HasTheDensityAndForceOfTheFormula) {
  const Model<float> model = model_at(204);
  const double h = model.smoothing_length, h2 = model.smoothing_length_2;
  const Vec direction = {2. / 7, -3. / 7, 6. / 7}, centre = {.0101, .0123, -.0087};
  for (const double fraction : {.001, .1, .5, .9, .99, 1.01, 1.9}) {
    SCOPED_TRACE("at " + std::to_string(fraction) + " h");
    Point a{centre, {0, 0, 0}, {.3, -.2, .1}}, b{centre, {0, 0, 0}, {-.1, .4, .2}};
    for (int k = 0; k < 3; ++k) b.position[k] += fraction * h * direction[k];
    const Fluid<float> start = fluid_of(204, {a, b});
    const Vec pa = vec_at(start.particles.position, 0), pb = vec_at(start.particles.position, 1);
    const Vec va = vec_at(start.particles.velocity, 0), vb = vec_at(start.particles.velocity, 1);
    const double r = std::hypot(pa[0] - pb[0], pa[1] - pb[1], pa[2] - pb[2]);
    const double rho = model.density_coefficient * (h2 * h2 * h2 + (r < h ? std::pow(h2 - r * r, 3) : 0));
    const double overlap = std::max(h - r, 0.);

    for_each_form([&](const Form& form) {
      Fluid<float> f = start;
      find_densities(form, f);
      const double rho_bound = true_densities(f.model, f.particles).bound[0];
      for (int i = 0; i < 2; ++i) EXPECT_NEAR(f.density[i], rho, rho_bound);

      find_forces(form, f);
      const Accelerations truth = true_accelerations(f.model, f.particles, f.density);
      const std::vector<int> place = id_order(f.particles);
      for (int k = 0; k < 3; ++k) {
        const double rho2 = double(f.density[0]) * f.density[1],
                     excess = double(f.density[0]) + f.density[1] - model.twice_rest_density;
        const double pair = ((pa[k] - pb[k]) * model.pressure_coefficient * overlap * overlap / r * excess +
                             (vb[k] - va[k]) * model.viscosity_coefficient * overlap) /
                            rho2;
        const double g = vec(model.gravity)[k];
        EXPECT_NEAR(vec_at(f.acceleration, place[0])[k], g + pair, truth.bound[place[0]][k]);
        EXPECT_NEAR(vec_at(f.acceleration, place[1])[k], g - pair, truth.bound[place[1]][k]);
      }
    });
  }
}

TEST(FluidPair, CoincidentStaysFiniteAndGainsNoMomentum) {
  for (const bool moving : {false, true}) {
    Point a{{.01, .02, .03}, {0, 0, 0}, {0, 0, 0}}, b = a;
    if (moving) a.velocity = {1, 2, -3}, b.velocity = {-2, 1, 1};
    Fluid<float> start = fluid_of(204, {a, b});
    start.model.gravity = {0, 0, 0};
    for_each_form([&](const Form& form) {
      Fluid<float> f = start;
      find_densities(form, f);
      EXPECT_EQ(f.density[0], f.density[1]);
      find_forces(form, f);
      for (int k = 0; k < 3; ++k) {
        EXPECT_TRUE(std::isfinite(vec_at(f.acceleration, 0)[k]));
        EXPECT_EQ(vec_at(f.acceleration, 0)[k] + vec_at(f.acceleration, 1)[k], 0);
        EXPECT_EQ(vec_at(f.acceleration, 0)[k] != 0, moving);
      }
      form.step(f);
      EXPECT_TRUE(verify::first_not_finite(f).empty());
    });
  }
}

// --- Many particles

TEST(FluidLattice, HasTheAnalyticDensityInside) {
  const Scene scene = load_scene("scenes/fluid/lattice_5k.toml");
  const double spacing = 1 / scene.model.particles_per_metre, h = scene.model.smoothing_length;
  const Fluid<float> start = make_fluid(convert<float>(scene.model), scene.particles);
  const double expected = verify::lattice_density(convert<double>(start.model), spacing);
  const double bound = verify::lattice_density_rounding(convert<double>(start.model), spacing, .06);
  EXPECT_LT(bound, 1e-4 * expected);
  const auto inside = [&](const Vec& p) {
    return std::abs(p[0]) < .05 - spacing - h && std::abs(p[1] - .01) < .05 - spacing - h &&
           std::abs(p[2]) < .05 - spacing - h;
  };
  for_each_form([&](const Form& form) {
    Fluid<float> f = start;
    find_densities(form, f);
    int count = 0;
    for (int i = 0; i < f.particles.count; ++i) {
      if (!inside(vec_at(f.particles.position, i))) continue;
      ASSERT_NEAR(f.density[i], expected, bound) << "particle " << f.particles.id[i];
      ++count;
    }
    EXPECT_GE(count, 11 * 11 * 11);
  });
}

TEST(FluidClouds, GridsAreAsSmallAsMeant) {
  const auto cells = [](double particles_per_metre) {
    const Grid<float> grid = make_grid(model_at(particles_per_metre));
    return std::array{grid.x.cells, grid.y.cells, grid.z.cells};
  };
  EXPECT_EQ(cells(5), (std::array{1, 1, 1}));
  EXPECT_EQ(cells(20), (std::array{1, 2, 1}));
  EXPECT_EQ(cells(30), (std::array{2, 3, 2}));
  EXPECT_EQ(cells(40), (std::array{3, 4, 3}));
}

// At 60 m/s a particle moves up to 6 cm a step, seven of the finest cells.
TEST(FluidClouds, DensitiesAndForcesAreThoseOfAllPairs) {
  Worst worst;
  Random random(5);
  for (const double particles_per_metre : resolutions)
    for (const int count : {0, 1, 2, 15, 16, 17, 100, 400})
      for (const Cloud cloud : {Cloud::spread, Cloud::clumped, Cloud::wild}) {
        if (count == 400 && cloud == Cloud::spread) continue;
        SCOPED_TRACE(std::to_string(count) + " particles, " + std::to_string(particles_per_metre) + " a metre, cloud " +
                     std::to_string(static_cast<int>(cloud)));
        Fluid<float> state =
            fluid_of(particles_per_metre, random_cloud(random, model_at(particles_per_metre), count, cloud, 60));
        // What walls do to the wildest leaves the range of float.
        const int frames = cloud == Cloud::wild || count > 100 ? 1 : 2;
        for (int frame = 0; frame < frames; ++frame) {
          for_each_form([&](const Form& form) { check_kernels(form, state, worst); },
                        count == 100 ? thread_counts : std::vector{1, 3});
          if (testing::Test::HasFatalFailure()) return;
          serial::step_symmetric(state);
        }
      }
  std::printf("  worst part of the rounding bound used: densities %.3f, accelerations %.3f\n", worst.density,
              worst.acceleration);
}

// Kernels that fill vectors up with a position of their own choice must not take it for a neighbour.
TEST(FluidClouds, NoneIsSoFarAwayThatItMeetsPadding) {
  Worst worst;
  for (const double far : {1e2, 1e6, 1e9, 1e10, 1e15, 1e18, 1e19, 1e20, 1e30, 3e38}) {
    SCOPED_TRACE("at " + std::to_string(far) + " m");
    std::vector<Point> points;
    for (const double x : {0., far, -far}) points.push_back({{x, x, x}, {0, 0, 0}, {1, 2, 3}});
    const Fluid<float> state = fluid_of(204, points);
    for_each_form([&](const Form& form) { check_kernels(form, state, worst); }, {1});
  }
}

}  // namespace
}  // namespace lockstep::fluid
