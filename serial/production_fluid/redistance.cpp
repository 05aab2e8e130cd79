// Makes the level set a distance again.
//
// Advection keeps the surface but not the distances about it: their gradient drifts away from 1, and where it becomes
// steep or flat, surface and particles suffer. The distances come from levelset/ and, where the surface is smooth, from
// its closest points; what is left here is the distances beside the surface, and the sign.
//
// The contract stands in common/production_fluid/redistance.h.
#include "common/production_fluid/redistance.h"

#include "common/levelset/blocks.h"
#include "common/levelset/fast_marching.h"
#include "common/levelset/fast_sweeping.h"
#include "common/levelset/initialize.h"
#include "common/real.h"

namespace lockstep::production_fluid::serial {
namespace {

using Index = std::int32_t;

void refine(const Field<Real>& phi, Distances<Real>& distances) {
  const Real* const values = &phi(0, 0, 0);
  for (const auto& [x, y, z] : distances.interface) {
    const Real steep = steepness<Index>(phi, x, y, z, [&](Index index) { return values[index]; });
    Real& distance = distances.distance(x, y, z);
    distance = refined_distance(phi(x, y, z), steep, distance);
  }
}

void take_closest_points(const Field<Real>& phi, Real band, Field<Real>& distance) {
  const Real* const values = &phi(0, 0, 0);
  const Real reach = reach_of_closest_points * phi.spacing;
  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y)
      for (int x = 0; x < phi.nx; ++x) {
        const bool near = abs(phi(x, y, z)) < reach;
        if (none(near)) continue;
        const auto closest = closest_point<Index>(phi, x, y, z, [&](const Index& index) { return values[index]; });
        Real* const at = &distance(x, y, z);
        *at = closest_distance(closest, *at, band, phi.spacing);
      }
}

void take_distances(const Field<Real>& distance, Real band, Field<Real>& phi) {
  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y)
      for (int x = 0; x < phi.nx; ++x) phi(x, y, z) = signed_distance(phi(x, y, z), distance(x, y, z), band);
}

}  // namespace

void redistance_sweeping(Field<Real>& phi, Real band, Distances<Real>& distances) {
  levelset::serial::initialize(phi, distances);
  refine(phi, distances);
  levelset::serial::fast_sweeping_sweeps(distances, band, 1);
  take_closest_points(phi, band, distances.distance);
  take_distances(distances.distance, band, phi);
}

void redistance_marching(Field<Real>& phi, Real band, Distances<Real>& distances) {
  levelset::serial::initialize(phi, distances);
  refine(phi, distances);
  levelset::serial::fast_marching_blocks(distances, band, levelset::block_size);
  take_closest_points(phi, band, distances.distance);
  take_distances(distances.distance, band, phi);
}

}  // namespace lockstep::production_fluid::serial
