// Makes the level set a distance again.
//
// The algorithm and its serial form stand in serial/production_fluid/redistance.cpp. levelset/ has the threads and the
// lanes of distances; the few cells beside the surface are refined one by one. Signs are given to sixteen cells along x
// at once, and threads share the lines.
//
// The contract stands in common/production_fluid/redistance.h.
#include "common/production_fluid/redistance.h"

#include "common/levelset/blocks.h"
#include "common/levelset/fast_marching.h"
#include "common/levelset/fast_sweeping.h"
#include "common/levelset/initialize.h"
#include "common/real.h"
#include "common/simd.h"
#include "openmp/production_fluid/by_fours.h"

namespace lockstep::production_fluid::openmp {
namespace {

using Index = std::int32_t;

void refine(const Field<Real>& phi, Distances<Real>& distances) {
  const Real* const values = &phi(0, 0, 0);
  const int count = static_cast<int>(distances.interface.size());
  // No cell is listed twice, so each is one iteration's; phi does not change.
#pragma omp parallel for schedule(static)
  for (int k = 0; k < count; ++k) {
    const auto& [x, y, z] = distances.interface[k];
    const Real steep = steepness<Index>(phi, x, y, z, [&](Index index) { return values[index]; });
    Real& distance = distances.distance(x, y, z);
    distance = refined_distance(phi(x, y, z), steep, distance);
  }
}

void take_closest_points(const Field<Real>& phi, Real band, Field<Real>& distance) {
  const Real* const values = &phi(0, 0, 0);
  const floatv reach = reach_of_closest_points * phi.spacing;
  // A line changes distances of its own cells, and phi does not change. Lines differ in how many cells are near.
#pragma omp parallel for collapse(2) schedule(dynamic, 16)
  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y)
      for (int x = 0; x < phi.nx; x += lanes) {
        const maskv near = first_lanes(phi.nx - x) & (abs(load(&phi(x, y, z))) < reach);
        if (none(near)) continue;
        const auto closest = closest_point<intv>(
            phi, x + lane_index(), y, z, ByFours{[&](const intv& index) { return gather_fours(values, index); }});
        Real* const at = &distance(x, y, z);
        store(at, closest_distance(closest, load(at), floatv(band), floatv(phi.spacing)), near);
      }
}

void take_distances(const Field<Real>& distance, Real band, Field<Real>& phi) {
  // A line changes its own cells, from distances that none changes.
#pragma omp parallel for collapse(2) schedule(static)
  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y)
      for (int x = 0; x < phi.nx; x += lanes) {
        Real* const at = &phi(x, y, z);
        const floatv before = load(at), after = signed_distance(before, load(&distance(x, y, z)), floatv(band));
        // Far from the surface few cells change, and what is not written need not go back to memory.
        const maskv changed = first_lanes(phi.nx - x) & (bits_of(after) != bits_of(before));
        if (any(changed)) store(at, after, changed);
      }
}

}  // namespace

void redistance_sweeping(Field<Real>& phi, Real band, Distances<Real>& distances) {
  levelset::openmp::initialize(phi, distances);
  refine(phi, distances);
  levelset::openmp::fast_sweeping_sweeps(distances, band, 1);
  take_closest_points(phi, band, distances.distance);
  take_distances(distances.distance, band, phi);
}

void redistance_marching(Field<Real>& phi, Real band, Distances<Real>& distances) {
  levelset::openmp::initialize(phi, distances);
  refine(phi, distances);
  levelset::openmp::fast_marching_blocks(distances, band, levelset::block_size);
  take_closest_points(phi, band, distances.distance);
  take_distances(distances.distance, band, phi);
}

}  // namespace lockstep::production_fluid::openmp
