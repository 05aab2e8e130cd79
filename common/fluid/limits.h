// How big and how fine a simulation of the game fluid may be.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>

#include "common/fluid/model.h"

namespace lockstep::fluid {

// Particles and cells are counted in int32. Half of its range leaves room for padding and for the sums kernels form of
// two counts.
inline constexpr double max_particles = 1 << 30;
inline constexpr double max_cells = 0x7fffffff - 1;

// Beyond these the model's constants, which go with h^6 and 1 / h^6, leave the range of float.
inline constexpr double min_particles_per_metre = 1e-6;
inline constexpr double max_particles_per_metre = 1e6;

// At least as many cells as make_grid cuts the model's domain into, before it has to count them in int.
double count_cells(const Model<double>& model);

// How many ints rebuild_grid may use for its histograms, whatever the number of threads: four a particle, but at least
// one for each cell.
inline double histogram_entries(double particles, double cells) { return std::max(4 * particles, cells); }

// Bytes that a Fluid<Real> of so many particles and cells takes, the particles themselves included.
template <class Real>
double simulation_bytes(double particles, double cells) {
  constexpr double particle = sizeof(std::int32_t) + 9 * sizeof(Real);  // id, position, two velocities
  // Without the lists (require_lists_fit, neighbours.h).
  constexpr double neighbours = sizeof(std::int32_t) + 8 * sizeof(Real);
  // Particles and sorted, density, acceleration.
  constexpr double per_particle = 2 * particle + (1 + 3) * sizeof(Real) + neighbours;
  constexpr double per_cell = sizeof(std::int32_t);  // cell_begin
  constexpr double padding = 32;                     // padded() adds no more
  const double histograms = sizeof(std::int32_t) * histogram_entries(particles, cells);
  return per_particle * (particles + padding) + per_cell * (cells + 1) + histograms;
}

// Throws InputError unless `particles_per_metre` is within the limits above (NaN is not).
void require_resolution(double particles_per_metre, const std::string& where);

// Throws InputError unless the numbers of particles and cells are within the limits above and a simulation in float
// fits this machine's memory. Call it before anything is allocated. `where` opens the message: the file at fault.
void require_size(const Model<double>& model, double particles, const std::string& where);

}  // namespace lockstep::fluid
