// Contract: particles in the order of their blocks, so that neighbours in memory read the same eight values of phi.
//
// Stable: particles of one block keep their order.
//
// In:      phi, for the grid alone; particles, inside the box, in any order.
// Out:     sorted: all of them, and where those of each block begin. It must be another object than `particles`.
// Errors:  std::bad_alloc.
// Source:  [ITJ07] "Production Fluid" keeps particles with their cells.
#pragma once

#include "common/production_fluid/particles.h"

namespace lockstep::production_fluid {

template <class Real>
using SortParticles = void(const Field<Real>& phi, const Particles<Real>& particles, Particles<Real>& sorted);

namespace serial {
SortParticles<float> sort_particles;
SortParticles<double> sort_particles;
}  // namespace serial

namespace openmp {
SortParticles<float> sort_particles;
}  // namespace openmp

}  // namespace lockstep::production_fluid
