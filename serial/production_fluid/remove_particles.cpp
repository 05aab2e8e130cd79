// Takes particles away that no longer help the level set; liquid that got away from it becomes spray.
//
// Block by block, each particle is kept, added to the spray, or left out. What is kept stays in its order, so it is
// sorted by block as before, and a block begins behind all that were kept of the blocks before it.
//
// The contract stands in common/production_fluid/remove_particles.h.
#include "common/production_fluid/remove_particles.h"

#include "common/real.h"

namespace lockstep::production_fluid::serial {
namespace {

using Index = std::int32_t;

Vector3<Real> in_cells(const Fluid<Real>& fluid, const Vector3<Real>& position) {
  return (1 / fluid.spacing) * position;
}

Fate<bool> fate_of(const Fluid<Real>& fluid, const Particles<Real>& particles, int i) {
  const Vector3<Real> at = in_cells(fluid, load(particles.position, i));
  const Real sign = particles.sign[i], radius = particles.radius[i];
  const Real phi = sample<Index>(fluid.phi, first_centre, at), solid = sample<Index>(fluid.solid, first_centre, at);
  Fate<bool> fate = production_fluid::fate_of(sign, radius, phi, solid, fluid.spacing);
  if (fate.keep && sign > 0 && reaches_centre<Index>(fluid.phi, at, (1 / fluid.spacing) * radius))
    fate.keep = !is_in_bubble(fluid.phi, at);
  return fate;
}

void move(const Particles<Real>& from, int i, Particles<Real>& to, int k) {
  store(to.position, k, load(from.position, i));
  to.radius[k] = from.radius[i], to.sign[k] = from.sign[i];
}

void move(const Fluid<Real>& fluid, const Particles<Real>& from, int i, Spray<Real>& to, int k) {
  const Vector3<Real> position = load(from.position, i);
  store(to.position, k, position);
  store(to.velocity, k, velocity_at<Index>(fluid.velocity, in_cells(fluid, position)));
  to.radius[k] = from.radius[i];
}

}  // namespace

void remove_particles(const Fluid<Real>& fluid, const Particles<Real>& particles, Particles<Real>& kept,
                      Spray<Real>& spray) {
  const int blocks = static_cast<int>(particles.first.size()) - 1;
  resize(kept, particles.count), kept.first.resize(blocks + 1);
  int count = 0;
  for (int block = 0; block < blocks; ++block) {
    kept.first[block] = count;
    for (int i = particles.first[block]; i < particles.first[block + 1]; ++i) {
      const Fate<bool> fate = fate_of(fluid, particles, i);
      if (fate.keep) move(particles, i, kept, count++);
      if (!fate.spray) continue;
      resize(spray, spray.count + 1);
      move(fluid, particles, i, spray, spray.count - 1);
    }
  }
  kept.first[blocks] = count;
  resize(kept, count);
}

}  // namespace lockstep::production_fluid::serial
