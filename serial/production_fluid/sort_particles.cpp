// Puts particles in the order of their blocks, by a counting sort: count those of each block, add the counts up, and
// each particle knows where it goes.
//
// The contract stands in common/production_fluid/sort_particles.h.
#include "common/production_fluid/sort_particles.h"

#include "common/counting_sort.h"
#include "common/real.h"

namespace lockstep::production_fluid::serial {
namespace {

using Index = std::int32_t;

}  // namespace

void sort_particles(const Field<Real>& phi, const Particles<Real>& particles, Particles<Real>& sorted) {
  resize(sorted, particles.count);
  const Real per_spacing = 1 / phi.spacing;
  const auto for_each = [&](const auto& visit) {
    for (int i = 0; i < particles.count; ++i)
      visit(i, block_of<Index>(phi, per_spacing * load(particles.position, i)));
  };
  const auto put = [&](int i, int place) {
    store(sorted.position, place, load(particles.position, i));
    sorted.radius[place] = particles.radius[i], sorted.sign[place] = particles.sign[i];
  };
  stable_counting_sort(phi.nx * phi.ny * phi.nz, for_each, put, sorted.first);
}

}  // namespace lockstep::production_fluid::serial
