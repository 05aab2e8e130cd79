#include "common/fluid/forces.h"
#include <algorithm>
#include "common/real.h"
#include "common/simd.h"
#include "openmp/fluid/candidates.h"
#include "openmp/fluid/sub_grids.h"
namespace lockstep::fluid::openmp {
namespace {
using namespace lockstep::openmp;
struct Lanes3 {
  floatv x, y, z;
};
Lanes3 pair_acceleration(const Model<Real>& model, floatv rho_i, floatv rho_j, const Lanes3& dp, const Lanes3& dv, floatv r2) {
  const floatv distance = sqrt(max(r2, model.min_distance_2));
  const floatv overlap = max(model.smoothing_length - distance,0.f);
  const floatv scale = overlap / (rho_i * rho_j);
  const floatv pressure = model.pressure_coefficient * scale * overlap / distance * (rho_i + rho_j - model.twice_rest_density);
  const floatv viscosity = model.viscosity_coefficient * scale;
  return {dp.x * pressure + dv.x * viscosity, dp.y * pressure + dv.y * viscosity, dp.z * pressure + dv.z * viscosity};
}
void forces_symmetric(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, std::span<const Real> density,
                      Vectors<Real>& acceleration, const SubGrids& sub_grids) {
  const Real h2 = model.smoothing_length_2;
  const Vectors<Real>&p = particles.position, &v = particles.velocity;
  Vectors<Real>& a = acceleration;
  Locks locks(grid.cells());
#pragma omp parallel
  {
#pragma omp for simd schedule(static)
    for (int i = 0; i < particles.count; ++i) a.x[i] = model.gravity.x, a.y[i] = model.gravity.y, a.z[i] = model.gravity.z;
    std::vector<Lanes3> sum;
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
                  const Lanes3 dv={load(&v.x[j])-v.x[i],load(&v.y[j])-v.y[i],load(&v.z[j])-v.z[i]};
                  Lanes3 f = pair_acceleration(model, density[i], load(&density[j]), {dx, dy, dz}, dv, r2);
                  Lanes3& s = sum[i - own.begin];
                  s.x += select(near, f.x, 0.f), s.y += select(near, f.y, 0.f), s.z += select(near, f.z, 0.f);
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
void forces_cell_locks(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, std::span<const Real> density, Vectors<Real>& acceleration) {
  forces_symmetric(model, grid, particles, density, acceleration, make_cell_locks(grid, omp_get_max_threads()));
}
void forces_sub_grid(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, std::span<const Real> density, Vectors<Real>& acceleration) {
  forces_symmetric(model, grid, particles, density, acceleration, make_sub_grids(grid, omp_get_max_threads()));
}
void forces_owner_gather(const Model<Real>& model, const Grid<Real>& grid, const Particles<Real>& particles, std::span<const Real> density,
                         Vectors<Real>& acceleration) {
  const Vectors<Real>&p = particles.position, &v = particles.velocity;
  const int rows = grid.y.cells * grid.z.cells;
#pragma omp parallel
  {
    Candidates<7> candidates;
    const auto& [cx, cy, cz, cu, cv, cw, rho] = candidates.field;
#pragma omp for schedule(dynamic, 4)
    for (int row = 0; row < rows; ++row)
      for (int x = 0; x < grid.x.cells; ++x) {
        const int y = row % grid.y.cells, z = row / grid.y.cells;
        const Run own = row_run(grid, x, x, y, z);
        if (own.begin == own.end) continue;
        candidates.pack(neighbour_runs(grid, x, y, z), {p.x.data(), p.y.data(), p.z.data(), v.x.data(), v.y.data(), v.z.data(), density.data()}, {far_away, far_away, far_away,0,0,0,1});
        for (int i = own.begin; i < own.end; ++i) {
          Lanes3 sp = {0.f, 0.f, 0.f}, sv = {0.f, 0.f, 0.f};
          for (int j = 0; j < candidates.count; j += lanes) {
            const floatv dx = p.x[i] - load(&cx[j]), dy = p.y[i] - load(&cy[j]), dz = p.z[i] - load(&cz[j]);
            const floatv r2 = dx * dx + dy * dy + dz * dz;
            const floatv rho_j=load(&rho[j]);
            const floatv distance = sqrt(max(r2, model.min_distance_2));
            const floatv overlap = max(model.smoothing_length - distance, 0.f);
            const floatv scale = overlap / (distance * rho_j);
            const floatv pressure = scale * overlap * (density[i] + rho_j - model.twice_rest_density);
            const floatv viscosity = scale * distance;
            sp.x += dx * pressure, sp.y += dy * pressure, sp.z += dz * pressure;
            sv.x += (load(&cu[j]) - v.x[i]) * viscosity, sv.y += (load(&cv[j]) - v.y[i]) * viscosity, sv.z += (load(&cw[j]) - v.z[i]) * viscosity;
          }
          const Real cp=model.pressure_coefficient/density[i],cvv=model.viscosity_coefficient/density[i];
          acceleration.x[i] = model.gravity.x + reduce_add(sp.x*cp+sv.x*cvv);
          acceleration.y[i] = model.gravity.y + reduce_add(sp.y*cp+sv.y*cvv);
          acceleration.z[i] = model.gravity.z + reduce_add(sp.z*cp+sv.z*cvv);
        }
      }
  }
}
}  // namespace lockstep::fluid::openmp
