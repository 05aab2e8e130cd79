// Collisions of a cloth with itself within a step: rounds of impulses, then of inelastic zones where they are wanted,
// then rigid zones until nothing meets. Both versions run this code with kernels of their own.
//
//   up to 3 times: find impacts; impulses change velocities; what was hit ends at start + dt v
//   then, if wanted, up to `most_inelastic_rounds` times: find impacts; move inelastic zones
//   then: find impacts; move rigid zones; until none are found, `most_zone_rounds` times at most
//
// A zone that turns is not rigid on its way, and held vertices may not let a zone be rigid (zones.h): so zones may go
// on meeting. Then `free` is false, and the caller must not keep the step.
#pragma once

#include "common/production_cloth/cloth.h"
#include "common/production_cloth/inelastic_zones.h"
#include "common/production_cloth/zones.h"

namespace lockstep::production_cloth {

inline constexpr int most_impulse_rounds = 3, most_zone_rounds = 100;
inline constexpr int most_inelastic_rounds = 30;

// What collisions took. `impacts` are those of the first search.
struct Collided {
  int rounds = 0, impacts = 0, inelastic_rounds = 0, zone_rounds = 0, zone_vertices = 0;
  bool free = false;
};

// Scratch, which keeps its room from step to step.
template <class Real>
struct CollideMemory {
  Contacts<Real> impacts;
  Zones zones;
  InelasticZones<Real> inelastic;
};

// The zones of a version, and which are wanted. Inelastic ones come before rigid ones.
template <class Real>
struct ZoneKernels {
  MoveZones<Real>* rigid;
  MoveInelasticZones<Real>* inelastic;
  ZoneForm wanted;
};

// find_impacts(start, end, impacts): continuous collision detection between the two. impulses(impacts, velocity): one
// round. start, m, free of intersections; inverse_mass, 1/kg, 0 of held vertices, which end where `position` has them.
// position, m, at the end of the step, and velocity, m/s, change where free vertices meet.
template <class Real, class FindImpacts, class RoundOfImpulses>
Collided collide(const FindImpacts& find_impacts, const RoundOfImpulses& impulses, const ZoneKernels<Real>& kernels,
                 const Array<Real>& inverse_mass, Real time_step, const Vectors<Real>& start, Vectors<Real>& position,
                 Vectors<Real>& velocity, CollideMemory<Real>& memory) {
  Collided collided;
  Contacts<Real>& impacts = memory.impacts;
  for (; collided.rounds < most_impulse_rounds; ++collided.rounds) {
    find_impacts(start, position, impacts);
    if (collided.rounds == 0) collided.impacts = static_cast<int>(impacts.count);
    if (impacts.count == 0) return collided.free = true, collided;
    impulses(impacts, velocity);
    for (std::size_t s = 0; s < 4 * impacts.count; ++s) {
      const std::int32_t v = impacts.corner[s];
      if (inverse_mass[v] > 0) store(position, v, load(start, v) + time_step * load(velocity, v));
    }
  }
  bool is_clear = false;
  const int most_inelastic = kernels.wanted == ZoneForm::inelastic ? most_inelastic_rounds : 0;
  for (; collided.inelastic_rounds < most_inelastic; ++collided.inelastic_rounds) {
    find_impacts(start, position, impacts);
    if (impacts.count == 0) return collided.free = true, collided;
    if (!is_clear) clear(static_cast<int>(inverse_mass.size()), memory.inelastic), is_clear = true;
    kernels.inelastic(impacts, inverse_mass, time_step, start, memory.inelastic, position, velocity);
    collided.zone_vertices = static_cast<int>(memory.inelastic.zones.vertex.size());
  }
  is_clear = false;
  for (; collided.zone_rounds < most_zone_rounds; ++collided.zone_rounds) {
    find_impacts(start, position, impacts);
    if (impacts.count == 0) break;
    if (!is_clear) clear(static_cast<int>(inverse_mass.size()), memory.zones), is_clear = true;
    kernels.rigid(impacts, inverse_mass, time_step, start, memory.zones, position, velocity);
    collided.zone_vertices = static_cast<int>(memory.zones.vertex.size());
  }
  if (collided.zone_rounds == most_zone_rounds) find_impacts(start, position, impacts);
  collided.free = impacts.count == 0;
  return collided;
}

}  // namespace lockstep::production_cloth
