// Adds gravity to the velocity.
//
// The algorithm and its serial form stand in serial/production_fluid/apply_forces.cpp. Sixteen faces along x at once;
// threads share the lines. Memory decides how long it takes.
//
// The contract stands in common/production_fluid/apply_forces.h.
#include "common/production_fluid/apply_forces.h"

#include "common/real.h"
#include "common/simd.h"
#include "openmp/whole_vectors.h"

namespace lockstep::production_fluid::openmp {
namespace {

using lockstep::openmp::with_first_lanes;

void add(Real change, Field<Real>& component) {
  if (change == 0) return;
    // A line changes its own faces.
#pragma omp parallel for collapse(2) schedule(static)
  for (int z = 0; z < component.nz; ++z)
    for (int y = 0; y < component.ny; ++y)
      for (int x = 0; x < component.nx; x += lanes) {
        Real* const at = &component(x, y, z);
        with_first_lanes(component.nx - x, [&](auto faces) { store(at, load(at, faces) + change, faces); });
      }
}

}  // namespace

void apply_forces(const Vector3<Real>& gravity, Real dt, Faces<Real>& faces) {
  add(dt * gravity.x, faces.u);
  add(dt * gravity.y, faces.v);
  add(dt * gravity.z, faces.w);
}

}  // namespace lockstep::production_fluid::openmp
