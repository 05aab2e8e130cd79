// Makes the system of the pressure.
//
// Every liquid cell asks that as much flows out of it as into it. Through each of its six faces the pressure of the
// cell beyond pushes back: an unknown if that cell is liquid, zero at the surface if it is air, nothing if the face is
// closed. Then cells are gathered into runs along x, which the solver goes through, and liquid that air cannot reach
// gets a right-hand side that has a solution.
//
// The contract stands in common/production_fluid/make_system.h.
#include "common/production_fluid/make_system.h"

#include <vector>

#include "common/production_fluid/neighbours.h"
#include "common/production_fluid/pockets.h"
#include "common/real.h"

namespace lockstep::production_fluid::serial {
namespace {

void make_rows(const Fluid<Real>& fluid, System<Real>& system) {
  const Lines<Real> lines(fluid);
  const auto& [u, v, w] = fluid.velocity;
  for (int z = 0; z < fluid.nz; ++z)
    for (int y = 0; y < fluid.ny; ++y) {
      const std::size_t first = system.cells.index(0, y, z);
      std::uint8_t* const air = &system.air[first];
      const Line<Real> here = lines(y, z), low_y = lines(y - 1, z), high_y = lines(y + 1, z), low_z = lines(y, z - 1),
                       high_z = lines(y, z + 1);
      for (int x = 0; x < fluid.nx; ++x) {
        air[x] = is_air(here.phi[x], here.solid[x]);
        const Real phi = here.phi[x];
        if (!is_liquid(phi, here.solid[x])) continue;
        Row<Real> row;
        add_face(phi, here.phi[x - 1], here.solid[x - 1], u(x, y, z), row);
        add_face(phi, here.phi[x + 1], here.solid[x + 1], -u(x + 1, y, z), row);
        add_face(phi, low_y.phi[x], low_y.solid[x], v(x, y, z), row);
        add_face(phi, high_y.phi[x], high_y.solid[x], -v(x, y + 1, z), row);
        add_face(phi, low_z.phi[x], low_z.solid[x], w(x, y, z), row);
        add_face(phi, high_z.phi[x], high_z.solid[x], -w(x, y, z + 1), row);
        system.diagonal[first + x] = row.diagonal;
        system.right[first + x] = row.right;
      }
    }
}

void find_runs(System<Real>& system) {
  system.first_run.assign(1, 0), system.runs.clear();
  for (int z = 0; z < system.cells.nz; ++z)
    for (int y = 0; y < system.cells.ny; ++y) {
      const Real* const diagonal = &system.diagonal[system.cells.index(0, y, z)];
      for (int x = 0; x < system.cells.nx; ++x)
        if (diagonal[x] > 0) {
          const int begin = x;
          while (diagonal[x] > 0) ++x;  // the border ends it
          system.runs.push_back({begin, x});
        }
      system.first_run.push_back(static_cast<std::int32_t>(system.runs.size()));
    }
}

RunSum sum_run(const System<Real>& system, std::size_t first, int count) {
  const std::ptrdiff_t line = system.cells.line(), plane = system.cells.plane();
  RunSum sum = {false, 0};
  for (int k = 0; k < count; ++k) {
    const Real* const at = &system.diagonal[first + k];
    sum.open |= has_air_beside(at[0], {at[-1], at[1], at[-line], at[line], at[-plane], at[plane]});
    sum.right += system.right[first + k];
  }
  return sum;
}

void balance_pockets(System<Real>& system) {
  std::vector<RunSum> sums(system.runs.size());
  for_each_run(system, [&](std::size_t first, int count, int run) { sums[run] = sum_run(system, first, count); });
  const Array<Real> means = means_of_pockets(system, sums);
  if (means.empty()) return;
  for_each_run(system, [&](std::size_t first, int count, int run) {
    for (int k = 0; k < count; ++k) system.right[first + k] -= means[run];
  });
}

}  // namespace

void make_system(const Fluid<Real>& fluid, System<Real>& system) {
  system.cells = {fluid.nx, fluid.ny, fluid.nz};
  system.open_top = fluid.open_top;
  system.diagonal.assign(system.cells.size(), 0), system.right.assign(system.cells.size(), 0);
  system.air.assign(system.cells.size(), 0);
  make_rows(fluid, system);
  find_runs(system);
  balance_pockets(system);
}

}  // namespace lockstep::production_fluid::serial
