// What tests of the production fluid's particles share: particles by hand, and the level set where they are.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "common/production_fluid/particles.h"
#include "tests/production_fluids.h"

namespace lockstep::production_fluid {

struct Particle {
  float x, y, z, radius, sign;
  bool operator==(const Particle&) const = default;
};

inline int block_of(const Fluid<float>& fluid, const Particle& p) {
  const float per_cell = 1 / fluid.spacing;
  return block_of<std::int32_t>(fluid.phi, per_cell * Vector3<float>{p.x, p.y, p.z});
}

// Sorted by block; of one block, in the order given.
inline Particles<float> sorted(const Fluid<float>& fluid, std::vector<Particle> list) {
  std::ranges::stable_sort(list, {}, [&](const Particle& p) { return block_of(fluid, p); });
  Particles<float> particles;
  resize(particles, list.size());
  particles.first.assign(fluid.nx * fluid.ny * fluid.nz + 1, 0);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto& [x, y, z, radius, sign] = list[i];
    store(particles.position, i, Vector3<float>{x, y, z});
    particles.radius[i] = radius, particles.sign[i] = sign;
    ++particles.first[block_of(fluid, list[i]) + 1];
  }
  for (std::size_t b = 1; b < particles.first.size(); ++b) particles.first[b] += particles.first[b - 1];
  return particles;
}

inline Particle particle(const Particles<float>& from, int i) {
  return {from.position.x[i], from.position.y[i], from.position.z[i], from.radius[i], from.sign[i]};
}
inline std::vector<Particle> list_of(const Particles<float>& particles) {
  std::vector<Particle> list;
  for (int i = 0; i < particles.count; ++i) list.push_back(particle(particles, i));
  return list;
}

// A field at a position in m, in double: its eight values, weighted by how near they are. An oracle.
inline double value_at(const Field<float>& field, const Vector3<double>& position) {
  struct Axis {
    int first;
    double weight[2];
  };
  const auto along = [&](double position, int n) {
    const double at = std::clamp(position / field.spacing - .5, 0., n - 1.);
    const int first = std::max(std::min(static_cast<int>(at), n - 2), 0);
    return Axis{first, {1 - (at - first), at - first}};
  };
  const Axis x = along(position.x, field.nx), y = along(position.y, field.ny), z = along(position.z, field.nz);
  double value = 0;
  for (int k = 0; k < 8; ++k) {
    const int dx = k % 2, dy = k / 2 % 2, dz = k / 4;
    const double weight = x.weight[dx] * y.weight[dy] * z.weight[dz];
    if (weight != 0) value += weight * field(x.first + dx, y.first + dy, z.first + dz);
  }
  return value;
}

}  // namespace lockstep::production_fluid
