// Forms, thread counts and states that the game fluid's tests share.
#pragma once

#include <gtest/gtest.h>
#include <omp.h>

#include <array>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "common/fluid/densities.h"
#include "common/fluid/forces.h"
#include "common/fluid/rebuild_grid.h"
#include "common/fluid/step.h"
#include "verify/compare.h"

namespace lockstep::fluid {

inline constexpr double u = verify::unit_roundoff;

// --- The forms

struct Form {
  const char* name;
  bool threaded;
  RebuildGrid<float>* rebuild_grid;
  Densities<float>* densities;
  Forces<float>* forces;
  Step<float>* step;
};

inline const Form forms[] = {
    {"serial symmetric", false, serial::rebuild_grid, serial::densities_symmetric, serial::forces_symmetric,
     serial::step_symmetric},
    {"serial owner_gather", false, serial::rebuild_grid, serial::densities_owner_gather, serial::forces_owner_gather,
     serial::step_owner_gather},
    {"serial pair_lists", false, serial::rebuild_grid, serial::densities_pair_lists, serial::forces_pair_lists,
     serial::step_pair_lists},
    {"openmp pair_lists", true, openmp::rebuild_grid_counting_sort, openmp::densities_pair_lists,
     openmp::forces_pair_lists, openmp::step_pair_lists},
    {"openmp cell_locks", true, openmp::rebuild_grid_linked_lists, openmp::densities_cell_locks,
     openmp::forces_cell_locks, openmp::step_cell_locks},
    {"openmp sub_grid", true, openmp::rebuild_grid_linked_lists, openmp::densities_sub_grid, openmp::forces_sub_grid,
     openmp::step_sub_grid},
    {"openmp owner_gather", true, openmp::rebuild_grid_counting_sort, openmp::densities_owner_gather,
     openmp::forces_owner_gather, openmp::step_owner_gather},
};

inline const std::vector<int> thread_counts = {1, 2, 3, 4, 8};

// Runs `work` at each thread count, and leaves OpenMP as it was.
template <class Work>
inline void at_thread_counts(const std::vector<int>& counts, const Work& work) {
  const int before = omp_get_max_threads();
  for (int threads : counts) {
    SCOPED_TRACE(std::to_string(threads) + " threads");
    omp_set_num_threads(threads);
    work(threads);
  }
  omp_set_num_threads(before);
}

template <class Work>
inline void for_each_form(const Work& work, const std::vector<int>& counts = thread_counts) {
  for (const Form& form : forms) {
    SCOPED_TRACE(form.name);
    at_thread_counts(form.threaded ? counts : std::vector{1}, [&](int) { work(form); });
  }
}

inline void find_densities(const Form& form, Fluid<float>& f) {
  form.rebuild_grid(f.grid, f.particles, f.sorted);
  form.densities(f.model, f.grid, f.particles, f.neighbours, f.density);
}

inline void find_forces(const Form& form, Fluid<float>& f) {
  form.forces(f.model, f.grid, f.particles, f.neighbours, f.density, f.acceleration);
}

// --- States

using Vec = std::array<double, 3>;
using Components = std::array<Array<float>*, 3>;

inline Components components(Vectors<float>& v) { return {&v.x, &v.y, &v.z}; }
template <class Real>
inline Vec vec_at(const Vectors<Real>& v, int i) {
  return {v.x[i], v.y[i], v.z[i]};
}
inline Vec vec(const Vector3<float>& v) { return {v.x, v.y, v.z}; }

struct Point {
  Vec position, half_velocity, velocity;
};

inline Particles<float> make_particles(const std::vector<Point>& points) {
  Particles<float> p;
  p.resize(static_cast<int>(points.size()));
  for (int i = 0; i < p.count; ++i) {
    p.id[i] = i;
    for (int k = 0; k < 3; ++k) {
      (*components(p.position)[k])[i] = static_cast<float>(points[i].position[k]);
      (*components(p.half_velocity)[k])[i] = static_cast<float>(points[i].half_velocity[k]);
      (*components(p.velocity)[k])[i] = static_cast<float>(points[i].velocity[k]);
    }
  }
  return p;
}

inline Model<float> model_at(double particles_per_metre) { return convert<float>(make_model(particles_per_metre)); }

inline Fluid<float> fluid_of(double particles_per_metre, const std::vector<Point>& points) {
  return make_fluid(model_at(particles_per_metre), make_particles(points));
}

struct Random {
  std::mt19937 engine;
  explicit Random(unsigned seed) : engine(seed) {}
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
  Vec vec(double size) { return {in(-size, size), in(-size, size), in(-size, size)}; }
};

enum class Cloud { spread, clumped, wild };

// Spread over the domain and beyond its walls; clumped into a few cells; or wild: as spread, with duplicates and points
// so far away that squares of their coordinates overflow, and on the very walls.
inline std::vector<Point> random_cloud(Random& random, const Model<float>& model, int count, Cloud cloud,
                                       double speed) {
  const Vec low = vec(model.domain_min), high = vec(model.domain_max);
  const double h = model.smoothing_length;
  const Vec centre = {random.in(low[0], high[0]), random.in(low[1], high[1]), random.in(low[2], high[2])};
  std::vector<Point> points(count);
  for (int i = 0; i < count; ++i) {
    Point& point = points[i];
    point.half_velocity = random.vec(speed), point.velocity = random.vec(speed);
    for (int k = 0; k < 3; ++k)
      point.position[k] =
          cloud == Cloud::clumped && i % 8 != 0 ? centre[k] + random.in(-h, h) : random.in(low[k] - .02, high[k] + .02);
    if (cloud != Cloud::wild) continue;
    const double far[] = {1e30, -1e30, 3e38, 1e10, -1e10, 1e18, 1e4, 1};
    if (i % 7 == 3) point.position = points[i / 2].position;
    if (i % 11 == 5) point.position[i % 3] = far[i % 8];
    if (i % 13 == 6) point.position = {far[i % 3], far[i % 3], far[i % 3]};
    if (i % 17 == 8) point.position = {low[0], high[1], low[2]};
  }
  return points;
}
// Cells along x, y, z: 1 1 1, 1 2 1, 2 3 2, 3 4 3, 7 10 7, 15 21 15.
inline constexpr double resolutions[] = {5, 20, 30, 40, 100, 204};

// --- Comparison

template <class T>
void expect_same_bits(const Array<T>& a, const Array<T>& b, int count, const char* what) {
  EXPECT_EQ(std::memcmp(a.data(), b.data(), count * sizeof(T)), 0) << what;
}

inline void expect_same_bits(const Particles<float>& a, const Particles<float>& b) {
  ASSERT_EQ(a.count, b.count);
  expect_same_bits(a.id, b.id, a.count, "id");
  for (const auto vectors :
       {&Particles<float>::position, &Particles<float>::half_velocity, &Particles<float>::velocity})
    for (const auto component : {&Vectors<float>::x, &Vectors<float>::y, &Vectors<float>::z})
      expect_same_bits(a.*vectors.*component, b.*vectors.*component, a.count, "position, half velocity or velocity");
}

}  // namespace lockstep::fluid
