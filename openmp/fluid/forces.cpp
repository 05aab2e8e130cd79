// The acceleration of every particle by pressure and viscosity of its neighbours within h, and by gravity.
//
// Symmetric, under locks: every pair is met once; what it gives to one particle it takes from the other. Sixteen neighbours j
// of one particle i at once; sub-grids and locks are as in densities.cpp, and so is the dependence on timing.
//
// Owner-gather: every particle meets all its neighbours, in the list that the densities left, sixteen at once, and sums for
// itself. List entries are scattered over memory, so what a pair needs of a particle is first put side by side: one access a
// neighbour instead of seven, turned into lanes by shuffles. No lock, and the same bits at every thread count.
//
// Source: [Mueller 2003]; [LRB08] Figure 9. The contract with the equation stands in common/fluid/forces.h.
#include "common/fluid/forces.h"

#include <algorithm>

#include "common/real.h"
#include "common/simd.h"
#include "openmp/fluid/sub_grids.h"

namespace lockstep::fluid::openmp {
namespace {

using namespace lockstep::openmp;

struct Lanes3 {
  floatv x, y, z;
};

// What neighbours j do to particle i, r2 = |p_i - p_j|^2 < h^2 and dv = v_j - v_i.
LOCKSTEP_INLINE Lanes3 pair_acceleration(const Model<Real>& model, Real density_i, floatv density_j, floatv dvx, floatv dvy, floatv dvz,
                                         floatv dx, floatv dy, floatv dz, floatv r2) {
  const floatv distance = sqrt(max(r2, model.min_distance_2));
  const floatv overlap = model.smoothing_length - distance;
  const floatv scale = overlap / (density_i * density_j * distance);  // the one division
  const floatv pressure = model.pressure_coefficient * scale * overlap * (density_i + density_j - model.twice_rest_density);
  const floatv viscosity = model.viscosity_coefficient * scale * distance;
  return {dx * pressure + dvx * viscosity,  //
          dy * pressure + dvy * viscosity,  //
          dz * pressure + dvz * viscosity};
}

void forces_symmetric(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, std::span<const Real> density,
                      Vectors<Real>& acceleration, const SubGrids& sub_grids) {
  const Real h2 = model.smoothing_length_2;
  const Vectors<Real>&p = particles.position, &v = particles.velocity;
  Vectors<Real>& a = acceleration;
  Locks locks(grid.cells());

#pragma omp parallel
  {
    // Every element is one thread's; the loop's barrier ends it before any pair is added.
#pragma omp for simd schedule(static)
    for (int i = 0; i < particles.count; ++i) a.x[i] = model.gravity.x, a.y[i] = model.gravity.y, a.z[i] = model.gravity.z;

    std::vector<Lanes3> sum;
    // Threads share no particle of a private cell; a shared cell's accelerations are read and written under its lock only.
#pragma omp for schedule(static, 1)
    for (const SubGrid& sub_grid : sub_grids.sub_grid)
      for (int z = sub_grid.z.begin; z < sub_grid.z.end; ++z)
        for (int y = sub_grid.y.begin; y < sub_grid.y.end; ++y)
          for (int x = sub_grid.x.begin; x < sub_grid.x.end; ++x) {
            const Run own = row_run(grid, x, x, y, z);
            if (own.begin == own.end) continue;
            sum.assign(own.end - own.begin, {0.f, 0.f, 0.f});
            forward_pieces(grid, sub_grids, x, y, z, [&](const Piece& piece) {
              const Guard guard(locks, piece.lock);
              for (int i = own.begin; i < own.end; ++i)
                for (int j = std::max(piece.run.begin, i + 1); j < piece.run.end; j += lanes) {
                  const maskv inside = first_lanes(piece.run.end - j);
                  const floatv dx = p.x[i] - load(&p.x[j]), dy = p.y[i] - load(&p.y[j]), dz = p.z[i] - load(&p.z[j]);
                  const floatv r2 = dx * dx + dy * dy + dz * dz;
                  const maskv near = inside & (r2 < h2);
                  if (none(near)) continue;
                  const floatv dvx = load(&v.x[j]) - v.x[i], dvy = load(&v.y[j]) - v.y[i], dvz = load(&v.z[j]) - v.z[i];
                  const Lanes3 f = pair_acceleration(model, density[i], load(&density[j]), dvx, dvy, dvz, dx, dy, dz, r2);
                  Lanes3& s = sum[i - own.begin];
                  where(near, s.x) += f.x, where(near, s.y) += f.y, where(near, s.z) += f.z;
                  store(&a.x[j], load(&a.x[j], near) - f.x, near);
                  store(&a.y[j], load(&a.y[j], near) - f.y, near);
                  store(&a.z[j], load(&a.z[j], near) - f.z, near);
                }
            });
            const int cell = grid.cell(x, y, z);
            const Guard guard(locks, sub_grids.shared[cell] ? cell : Piece::no_lock);
            for (int i = own.begin; i < own.end; ++i) {
              const Lanes3& s = sum[i - own.begin];
              a.x[i] += reduce_add(s.x), a.y[i] += reduce_add(s.y), a.z[i] += reduce_add(s.z);
            }
          }
  }
}

}  // namespace

void forces_cell_locks(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, Neighbours<Real>&,
                       std::span<const Real> density, Vectors<Real>& acceleration) {
  forces_symmetric(model, grid, particles, density, acceleration, make_cell_locks(grid, omp_get_max_threads()));
}

void forces_sub_grid(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, Neighbours<Real>&,
                     std::span<const Real> density, Vectors<Real>& acceleration) {
  forces_symmetric(model, grid, particles, density, acceleration, make_sub_grids(grid, omp_get_max_threads()));
}

void forces_owner_gather(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, Neighbours<Real>& neighbours,
                         std::span<const Real> density, Vectors<Real>& acceleration) {
  const Vectors<Real>&p = particles.position, &v = particles.velocity;
  const int rows = grid.y.cells * grid.z.cells;
  const Model<Real> constants = model;  // a copy of our own: stores cannot change it
  Real* const records = neighbours.record.data();

#pragma omp parallel
  {
    // Every record is one thread's; the loop's barrier ends it before any is read.
#pragma omp for schedule(static)
    for (int i = 0; i < particles.count; ++i) {
      Real* r = records + 8 * i;
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
        const floatv x_i = p.x[i], y_i = p.y[i], z_i = p.z[i], vx_i = v.x[i], vy_i = v.y[i], vz_i = v.z[i];
        const Real density_i = density[i];
        const int end = neighbours.end[i];
        Lanes3 sum = {0.f, 0.f, 0.f};
        for (; k < end; k += lanes) {
          // Lanes beyond the end of the list meet some other particle.
          const maskv inside = first_lanes(end - k);
          const auto [x_j, y_j, z_j, density_j, vx_j, vy_j, vz_j, unused] = load_records(records, list + k).field;
          const floatv dx = x_i - x_j, dy = y_i - y_j, dz = z_i - z_j;
          const floatv r2 = dx * dx + dy * dy + dz * dz;
          const Lanes3 a = pair_acceleration(constants, density_i, density_j, vx_j - vx_i, vy_j - vy_i, vz_j - vz_i, dx, dy, dz, r2);
          where(inside, sum.x) += a.x, where(inside, sum.y) += a.y, where(inside, sum.z) += a.z;
        }
        k = end;
        acceleration.x[i] = model.gravity.x + reduce_add(sum.x);
        acceleration.y[i] = model.gravity.y + reduce_add(sum.y);
        acceleration.z[i] = model.gravity.z + reduce_add(sum.z);
      }
    }
  }
}

}  // namespace lockstep::fluid::openmp
