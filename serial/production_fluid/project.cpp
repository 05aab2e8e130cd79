// Takes the divergence out of the liquid's velocity.
//
// The faces go line by line: those along x lie between cells of one line, those along y and z between the cells of two.
//
// The contract stands in common/production_fluid/project.h.
#include "common/production_fluid/project.h"

#include "common/production_fluid/neighbours.h"
#include "common/real.h"

namespace lockstep::production_fluid::serial {
namespace {

// The cells on one side of a line of faces, and q in them.
struct Side {
  Line<Real> line;
  const double* q;
};

void push(const Side& a, const Side& b, int count, Real* velocity) {
  for (int x = 0; x < count; ++x) {
    const Real coefficient = coefficient_between(a.line.phi[x], b.line.phi[x]);
    const Real open = static_cast<Real>(pushed<double>(velocity[x], coefficient, a.q[x], b.q[x]));
    velocity[x] = select(!is_closed(a.line.solid[x], b.line.solid[x]), open, Real(0));
  }
}

}  // namespace

void project(const Fluid<Real>& fluid, const System<Real>& system, const Array<double>& q, Faces<Real>& faces) {
  const Lines<Real> lines(fluid);
  const auto side = [&](int y, int z) { return Side{lines(y, z), &q[system.cells.index(0, y, z)]}; };
  for (int z = 0; z <= fluid.nz; ++z)
    for (int y = 0; y <= fluid.ny; ++y) {
      const Side here = side(y, z), before_x = {{here.line.phi - 1, here.line.solid - 1}, here.q - 1};
      if (y < fluid.ny && z < fluid.nz) push(before_x, here, fluid.nx + 1, &faces.u(0, y, z));
      if (z < fluid.nz) push(side(y - 1, z), here, fluid.nx, &faces.v(0, y, z));
      if (y < fluid.ny) push(side(y, z - 1), here, fluid.nx, &faces.w(0, y, z));
    }
}

}  // namespace lockstep::production_fluid::serial
