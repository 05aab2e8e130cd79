#include "common/fluid/limits.h"

#include <algorithm>
#include <cmath>

#include "common/digits.h"
#include "common/input_error.h"
#include "common/memory.h"

namespace lockstep::fluid {

// make_grid does the same with cells a hundred-thousandth wider, which is more than its numbers may be off by rounding.
double count_cells(const Model<double>& model) {
  const auto fit = [&](double min, double max) {
    return std::max(1.0, std::floor((max - min) / model.smoothing_length));
  };
  return fit(model.domain_min.x, model.domain_max.x) * fit(model.domain_min.y, model.domain_max.y) *
         fit(model.domain_min.z, model.domain_max.z);
}

void require_resolution(double particles_per_metre, const std::string& where) {
  if (!(particles_per_metre >= min_particles_per_metre && particles_per_metre <= max_particles_per_metre))
    throw InputError(where + ": particles per metre is " + digits_of(particles_per_metre) +
                     ", expected a number from " + digits_of(min_particles_per_metre) + " to " +
                     digits_of(max_particles_per_metre));
}

void require_size(const Model<double>& model, double particles, const std::string& where) {
  const double cells = count_cells(model);
  if (particles > max_particles)
    throw InputError(where + ": " + digits_of(particles) + " particles, expected at most " + digits_of(max_particles));
  if (cells > max_cells)
    throw InputError(where + ": " + digits_of(model.particles_per_metre) + " particles per metre cut the domain into " +
                     digits_of(cells) + " cells, expected at most " + digits_of(max_cells));
  // At rest 4/3 pi 1.695^3 = 20.4 neighbours are within h. The lists note each pair once, its number and distance, and
  // have up to twice the room they need. A denser fluid asks for more as it runs (require_lists_fit, neighbours.h).
  const double lists = 2 * 20.4 / 2 * (sizeof(std::int32_t) + sizeof(float)) * particles;
  require_memory(simulation_bytes<float>(particles, cells) + lists,
                 where + ": simulating " + digits_of(particles) + " particles in " + digits_of(cells) + " cells");
}

}  // namespace lockstep::fluid
