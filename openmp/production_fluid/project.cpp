// Takes the divergence out of the liquid's velocity.
//
// The algorithm and its serial form stand in serial/production_fluid/project.cpp. Sixteen faces along x at once;
// threads share the lines.
//
// The contract stands in common/production_fluid/project.h.
#include "common/production_fluid/project.h"

#include "common/production_fluid/neighbours.h"
#include "common/real.h"
#include "common/simd.h"
#include "common/simd_double.h"

namespace lockstep::production_fluid::openmp {
namespace {

// The cells on one side of a line of faces, and q in them.
struct Side {
  Line<Real> line;
  const double* q;
};

void push(const Side& a, const Side& b, int count, Real* velocity) {
  for (int x = 0; x < count; x += lanes) {
    const floatv coefficient = coefficient_between(load(&a.line.phi[x]), load(&b.line.phi[x]));
    const floatv open =
        to_float(pushed(to_double(load(&velocity[x])), to_double(coefficient), load(&a.q[x]), load(&b.q[x])));
    const floatv found = select(!is_closed(load(&a.line.solid[x]), load(&b.line.solid[x])), open, 0.f);
    store(&velocity[x], found, first_lanes(count - x));
  }
}

}  // namespace

void project(const Fluid<Real>& fluid, const System<Real>& system, const Array<double>& q, Faces<Real>& faces) {
  const Lines<Real> lines(fluid);
  const auto side = [&](int y, int z) { return Side{lines(y, z), &q[system.cells.index(0, y, z)]}; };
  // A line changes its own faces, and reads what no line changes.
#pragma omp parallel for collapse(2) schedule(static)
  for (int z = 0; z <= fluid.nz; ++z)
    for (int y = 0; y <= fluid.ny; ++y) {
      const Side here = side(y, z), before_x = {{here.line.phi - 1, here.line.solid - 1}, here.q - 1};
      if (y < fluid.ny && z < fluid.nz) push(before_x, here, fluid.nx + 1, &faces.u(0, y, z));
      if (z < fluid.nz) push(side(y - 1, z), here, fluid.nx, &faces.v(0, y, z));
      if (y < fluid.ny) push(side(y, z - 1), here, fluid.nx, &faces.w(0, y, z));
    }
}

}  // namespace lockstep::production_fluid::openmp
