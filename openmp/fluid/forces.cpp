// The acceleration of every particle by pressure and viscosity of its neighbours within h, and by gravity.
//
// Symmetric, under locks: every pair is met once; what it gives to one particle it takes from the other. Sixteen neighbours j
// of one particle i at once; sub-grids and locks are as in densities.cpp, and so is the dependence on timing.
//
// Owner-gather: every particle meets all its neighbours, in the list that the densities left, sixteen at once, and sums for
// itself. List entries are scattered over memory, so what a pair needs of a particle is first put side by side: one access a
// neighbour instead of seven, turned into lanes by shuffles. No lock, and the same bits at every thread count.
//
// Pair lists: every pair is met once, without locks. The pairs of the particles of plane z of cells with what follows them in
// cell order reach planes z and z + 1 and no others, and the particles of both stand side by side. Whoever works on a plane adds up in
// scratch of its own for these two; what came out for plane z goes to one array, what came out for plane z + 1 to another, `reaction`:
//
//     plane z - 1    own z - 1   reaction z                   So every element of both arrays is written once,
//     plane z                    own z       reaction z + 1   and a particle's total is own + reaction.
//
// A pair has two steps: what is arithmetic on numbers alone runs in full vectors over the pairs of a row; then, pair by
// pair, all components of a term are computed at once and go to both particles.
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

// Of pairs k < n: by what factors the differences of two particles' positions and velocities go into their accelerations.
void pair_factors(const Model<Real>& model, const Real* density, const std::int32_t* list, const Real* density_i, const Real* distance_2,
                  int n, Real* factors) {
  const floatv min_distance_2 = model.min_distance_2, smoothing_length = model.smoothing_length;
  const floatv twice_rest_density = model.twice_rest_density;
  const floatv pressure_coefficient = model.pressure_coefficient, viscosity_coefficient = model.viscosity_coefficient;
  for (int k = 0; k < n; k += lanes) {
    const floatv rho_i = load(density_i + k), rho_j = gather(density, load(list + k));
    const floatv distance = sqrt(max(load(distance_2 + k), min_distance_2));
    const floatv overlap = smoothing_length - distance;
    const floatv scale = overlap / (rho_i * rho_j * distance);  // the one division
    const floatv pressure = pressure_coefficient * scale * overlap * (rho_i + rho_j - twice_rest_density);
    const floatv viscosity = viscosity_coefficient * scale * distance;
    store_pairs(factors + 2 * k, pressure, -viscosity);
  }
}

// What the forces need of a particle, in one cache line: position and velocity, x of both first, then y, then z; and in the
// same places what its pairs have added up to so far, by pressure and by viscosity.
struct alignas(64) Body {
  Real state[8], sum[8];
};

// Adds the terms of the pairs of particles `own` to both. body is indexed as particles are.
void add_pairs(const Run own, int k, const std::int32_t* end, const std::int32_t* list, const Real* factors, Body* body) {
  for (int i = own.begin; i < own.end; ++i) {
    const recordv state_i = load_record(body[i].state);
    recordv sum = 0.f;
    for (const int end_i = end[i]; k < end_i; ++k) {
      Body& other = body[list[k]];
      const recordv term = (state_i - load_record(other.state)) * repeat_pair(factors + 2 * k);
      sum = sum + term;
      store_record(other.sum, load_record(other.sum) - term);
    }
    store_record(body[i].sum, load_record(body[i].sum) + sum);
  }
}

// Which records the states (which = 0) or sums (which = 1) of bodies i .. i + 15 are, counted from body[0].
struct BodyRecords {
  alignas(array_alignment) std::int32_t index[lanes];
  LOCKSTEP_INLINE BodyRecords(int i, int which) { store(index, (lane_index() + i) * 2 + which); }
};

// Sixteen at once, and so up to fifteen more than asked for.
void make_bodies(const Run run, const Particles<Real>& particles, Body* body) {
  const Vectors<Real>&p = particles.position, &v = particles.velocity;
  for (int i = run.begin; i < run.end; i += lanes) {
    const Records state = {{load(&p.x[i]), load(&v.x[i]), load(&p.y[i]), load(&v.y[i]), load(&p.z[i]), load(&v.z[i]), 0.f, 0.f}};
    store_records(body->state, BodyRecords(i, 0).index, state);
    for (int l = 0; l < lanes; ++l) store_record(body[i + l].sum, 0.f);
  }
}

void write_sums(const Run run, const Body* body, Real* x, Real* y, Real* z) {
  for (int i = run.begin; i < run.end; i += lanes) {
    const maskv inside = first_lanes(run.end - i);
    const auto [px, vx, py, vy, pz, vz, unused, unused_too] = load_records(body->state, BodyRecords(i, 1).index).field;
    store(x + i, px + vx, inside), store(y + i, py + vy, inside), store(z + i, pz + vz, inside);
  }
}

// For every pair, the density of the particle whose list it stands in.
void repeat_densities(const Run own, int k, const std::int32_t* end, const Real* density, Real* density_i) {
  for (int i = own.begin; i < own.end; ++i) {
    const int end_i = end[i];
    const floatv rho = density[i];
    for (; k < end_i; k += lanes) store(density_i + k, rho);  // what is written beyond the list, the next one overwrites
    k = end_i;
  }
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

void forces_pair_lists(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, Neighbours<Real>& neighbours,
                       std::span<const Real> density, Vectors<Real>& acceleration) {
  const int padded_count = static_cast<int>(padded(particles.count));
  Real* const reaction = neighbours.record.data();  // x of all particles, then y, then z

#pragma omp parallel
  {
    Array<Body> bodies;
    Array<Real> density_i, factors;
    // A plane writes the accelerations of its own particles and the reaction of the next plane's, and no other does.
#pragma omp for schedule(dynamic)
    for (int z = 0; z < grid.z.cells; ++z) {
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
        if (density_i.size() < padded(pairs)) {
          density_i.resize(2 * padded(pairs));
          factors.resize(4 * padded(pairs));
        }
        repeat_densities(own, first, end, density.data(), density_i.data() - first);
        pair_factors(model, density.data(), list + first, density_i.data(), distance_2 + first, pairs, factors.data());
        add_pairs(own, first, end, list, factors.data() - 2 * first, body);
        first += pairs;
      }
      write_sums({plane.begin, plane.end}, body, acceleration.x.data(), acceleration.y.data(), acceleration.z.data());
      write_sums({plane.end, both.end}, body, reaction, reaction + padded_count, reaction + 2 * padded_count);
      if (z == 0)
        for (int k = 0; k < 3; ++k) std::fill_n(reaction + k * padded_count, plane.end, 0.f);
    }

    // Every element is one thread's.
#pragma omp for simd schedule(static)
    for (int i = 0; i < particles.count; ++i) {
      acceleration.x[i] = model.gravity.x + (acceleration.x[i] + reaction[i]);
      acceleration.y[i] = model.gravity.y + (acceleration.y[i] + reaction[i + padded_count]);
      acceleration.z[i] = model.gravity.z + (acceleration.z[i] + reaction[i + 2 * padded_count]);
    }
  }
}

}  // namespace lockstep::fluid::openmp
