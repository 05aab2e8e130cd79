// The acceleration of every particle by pressure and viscosity of its neighbours within h, and by gravity.
//
// Symmetric, under locks: every pair is met once; its term is added to one particle and subtracted from the other.
// Sixteen neighbours j of one particle i at once; sub-grids and locks are as in densities.cpp, and so is the dependence
// on timing.
//
// Owner-gather: every particle sums over its own list of neighbours, which the densities left, sixteen at once.
// Neighbours are scattered over memory, so each particle's numbers are first packed into a record: one access a
// neighbour instead of seven, turned into lanes by shuffles. No lock, and the same bits at every thread count.
//
// Pair lists: every pair is met once, without locks. The pairs of the particles of plane z of cells with what follows
// them in cell order reach planes z and z + 1 only, and the particles of both stand side by side. The thread of plane z
// sums in its own scratch for these two planes. The sums of plane z go to one array, those of plane z + 1 to another,
// `reaction`:
//
//     plane z - 1    own z - 1   reaction z                   So every element of both arrays is written once,
//     plane z                    own z       reaction z + 1   and a particle's total is own + reaction.
//
// The particles of the scratch are bodies (bodies.h).
//
// Source: [Mueller 2003]; [LRB08] Figure 9. The contract with the equation stands in common/fluid/forces.h.
#include "common/fluid/forces.h"

#include <algorithm>
#include <cstddef>

#include "common/fluid/pair.h"
#include "common/real.h"
#include "common/simd.h"
#include "openmp/failure.h"
#include "openmp/fluid/bodies.h"
#include "openmp/fluid/lanes.h"
#include "openmp/fluid/sub_grids.h"
#include "openmp/vector_lanes.h"

namespace lockstep::fluid::openmp {
namespace {

using namespace lockstep::openmp;

// Adds the terms of the pairs (i, j), i < j, of the particles `own` and `run`: i's to sum[i], j's to its acceleration.
// Model and pointers are passed by value: stores could change what a reference refers to, so the compiler would load it
// again after each.
void add_terms(Model<Real> model, Run own, Run run, Vector3<const float*> p, Vector3<const float*> v,
               const Real* density, Vector3<float*> acceleration, Vector3<floatv>* sum);

void forces_symmetric(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                      std::span<const Real> density, Vectors<Real>& acceleration, const SubGrids& sub_grids) {
  const Vectors<Real>&p = particles.position, &v = particles.velocity;
  Locks locks(grid.cells());
  Failure failure;

#pragma omp parallel
  {
    // Every element is one thread's; the loop's barrier ends it before any pair is added.
#pragma omp for simd schedule(static)
    for (int i = 0; i < particles.count; ++i) put(acceleration, i, model.gravity);

    std::vector<Vector3<floatv>> sum;
    // Threads share no particle of a private cell; a shared cell's accelerations are read and written under its lock
    // only.
#pragma omp for schedule(static, 1)
    for (const SubGrid& sub_grid : sub_grids.sub_grid)
      failure.guard([&] {
        for (int z = sub_grid.z.begin; z < sub_grid.z.end; ++z)
          for (int y = sub_grid.y.begin; y < sub_grid.y.end; ++y)
            for (int x = sub_grid.x.begin; x < sub_grid.x.end; ++x) {
              const Run own = row_run(grid, x, x, y, z);
              if (own.begin == own.end) continue;
              sum.assign(own.end - own.begin, {0.f, 0.f, 0.f});
              forward_pieces(grid, sub_grids, x, y, z, [&](const Piece& piece) {
                const Guard guard(locks, piece.lock);
                add_terms(model, own, piece.run, pointers(p), pointers(v), density.data(), pointers(acceleration),
                          sum.data() - own.begin);
              });
              const int cell = grid.cell(x, y, z);
              const Guard guard(locks, sub_grids.shared[cell] ? cell : Piece::no_lock);
              for (int i = own.begin; i < own.end; ++i)
                put(acceleration, i, at(acceleration, i) + reduce_add(sum[i - own.begin]));
            }
      });
  }
  failure.rethrow();
}

void add_terms(Model<Real> model, Run own, Run run, Vector3<const float*> p, Vector3<const float*> v,
               const Real* density, Vector3<float*> acceleration, Vector3<floatv>* sum) {
  const Real h2 = model.smoothing_length_2;
  for (int i = own.begin; i < own.end; ++i) {
    const Vector3<floatv> p_i = repeat_at(p, i), v_i = repeat_at(v, i);
    for (int j = std::max(run.begin, i + 1); j < run.end; j += lanes) {
      const maskv inside = first_lanes(run.end - j);
      const Vector3<floatv> dp = p_i - load(p, j);
      const floatv r2 = dot(dp, dp);
      const maskv near = inside & (r2 < h2);
      if (none(near)) continue;
      const Vector3<floatv> a =
          pair_acceleration(model, floatv(density[i]), load(&density[j]), dp, load(v, j) - v_i, r2);
      sum[i] = select(near, sum[i] + a, sum[i]);
      store(acceleration, j, load(acceleration, j, near) - a, near);
    }
  }
}

}  // namespace

void forces_cell_locks(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                       Neighbours<Real>&, std::span<const Real> density, Vectors<Real>& acceleration) {
  forces_symmetric(model, grid, particles, density, acceleration, make_cell_locks(grid, omp_get_max_threads()));
}

void forces_sub_grid(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                     Neighbours<Real>&, std::span<const Real> density, Vectors<Real>& acceleration) {
  forces_symmetric(model, grid, particles, density, acceleration, make_sub_grids(grid, omp_get_max_threads()));
}

void forces_owner_gather(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                         Neighbours<Real>& neighbours, std::span<const Real> density, Vectors<Real>& acceleration) {
  const Vectors<Real>&p = particles.position, &v = particles.velocity;
  const int rows = grid.y.cells * grid.z.cells;
  const Model<Real> constants = model;              // a copy of our own: stores cannot change it
  Real* const records = neighbours.scratch.data();  // of particle i, from 8 i on: position, density, velocity, 0

#pragma omp parallel
  {
    // Every record is one thread's; the loop's barrier ends it before any is read.
#pragma omp for schedule(static)
    for (int i = 0; i < particles.count; ++i) {
      Real* const r = records + 8 * std::ptrdiff_t(i);
      r[0] = p.x[i], r[1] = p.y[i], r[2] = p.z[i], r[3] = density[i];
      r[4] = v.x[i], r[5] = v.y[i], r[6] = v.z[i], r[7] = 0;
    }

    // A row of cells writes the accelerations of its own particles alone. Rows differ in work, hence dynamic.
#pragma omp for schedule(dynamic, 4)
    for (int row = 0; row < rows; ++row) {
      const Run own = row_run(grid, 0, grid.x.cells - 1, row % grid.y.cells, row / grid.y.cells);
      const std::int32_t* const list = neighbours.row[row].data();
      int k = 0;
      for (int i = own.begin; i < own.end; ++i) {
        // Held in registers: to the compiler, the stores below could change what the arrays point to.
        const Vector3<floatv> p_i = repeat_at(p, i), v_i = repeat_at(v, i);
        const floatv density_i = density[i];
        const int end = neighbours.end[i];
        Vector3<floatv> sum = {0, 0, 0};
        for (; k < end; k += lanes) {
          // Lanes beyond the end of the list meet some other particle.
          const maskv inside = first_lanes(end - k);
          const auto [px, py, pz, density_j, vx, vy, vz, unused] = load_records(records, list + k).field;
          const Vector3<floatv> p_j = {px, py, pz}, v_j = {vx, vy, vz};
          const Vector3<floatv> dp = p_i - p_j;
          const Vector3<floatv> a = pair_acceleration(constants, density_i, density_j, dp, v_j - v_i, dot(dp, dp));
          sum = select(inside, sum + a, sum);
        }
        k = end;
        put(acceleration, i, constants.gravity + reduce_add(sum));
      }
    }
  }
}

void forces_pair_lists(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles,
                       Neighbours<Real>& neighbours, std::span<const Real> density, Vectors<Real>& acceleration) {
  const std::size_t padded_count = padded(particles.count);
  Real* const reaction_x = neighbours.scratch.data();
  Real* const reaction_y = reaction_x + padded_count;
  Real* const reaction_z = reaction_y + padded_count;

  Failure failure;
#pragma omp parallel
  {
    Array<Body> bodies;
    Array<Real> density_i, factors;
    // A plane writes the accelerations of its own particles and the reaction of the next plane's, and no other does.
#pragma omp for schedule(dynamic)
    for (int z = 0; z < grid.z.cells; ++z)
      failure.guard([&] {
        const Run plane = plane_run(grid, z, z), both = plane_run(grid, z, z + 1);
        bodies.resize(std::max<std::size_t>(bodies.size(), padded(both.end - both.begin)));
        Body* const body = bodies.data() - both.begin;
        make_bodies(both, particles, body);
        const std::int32_t *const list = neighbours.plane[z].data(), *const end = neighbours.end.data();
        const Real* const distance_2 = neighbours.distance_2[z].data();
        int first = 0;
        for (int y = 0; y < grid.y.cells; ++y) {
          const Run own = row_run(grid, 0, grid.x.cells - 1, y, z);
          if (own.begin == own.end) continue;
          const int pairs = end[own.end - 1] - first;
          if (factors.size() < 2 * padded(pairs)) {
            density_i.resize(2 * padded(pairs));
            factors.resize(4 * padded(pairs));
          }
          repeat_densities(own, first, end, density.data(), density_i.data() - first);
          find_factors(model, density.data(), list + first, density_i.data(), distance_2 + first, pairs,
                       factors.data());
          add_pairs(own, first, end, list, factors.data() - 2 * std::ptrdiff_t(first), body);
          first += pairs;
        }
        write_sums({plane.begin, plane.end}, body, acceleration.x.data(), acceleration.y.data(), acceleration.z.data());
        write_sums({plane.end, both.end}, body, reaction_x, reaction_y, reaction_z);
        if (z == 0)
          for (Real* reaction : {reaction_x, reaction_y, reaction_z}) std::fill_n(reaction, plane.end, 0.f);
      });

    // Every element is one thread's.
#pragma omp for simd schedule(static)
    for (int i = 0; i < particles.count; ++i) {
      const Vector3<Real> reaction = {reaction_x[i], reaction_y[i], reaction_z[i]};
      put(acceleration, i, model.gravity + (at(acceleration, i) + reaction));
    }
  }
  failure.rethrow();
}

}  // namespace lockstep::fluid::openmp
