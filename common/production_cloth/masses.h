// Masses of a cloth's vertices.
#pragma once

#include <cmath>

#include "common/production_cloth/topology.h"

namespace lockstep::production_cloth {

// kg, padded with 0: each triangle gives a third of its mass to each corner. `density` in kg/m^2. The sum over a vertex
// is in the order of triangles.
inline Array<double> lumped_masses(const Topology& topology, const Vectors<double>& rest, double density) {
  Array<double> mass(padded(topology.vertices));
  for (std::size_t t = 0; t < topology.triangles.size(); ++t) {
    const auto corner = topology.corners(t);
    const Vector3<double> a = load(rest, corner[0]);
    const Vector3<double> normal = cross(load(rest, corner[1]) - a, load(rest, corner[2]) - a);
    for (const std::int32_t v : corner) mass[v] += density * .5 * std::sqrt(dot(normal, normal)) / 3;
  }
  return mass;
}

}  // namespace lockstep::production_cloth
