// What a scene does to its cloth in a step: where bodies are, and held vertices.
#pragma once

#include <cstdint>
#include <vector>

#include "common/production_cloth/bodies.h"
#include "common/production_cloth/scene.h"

namespace lockstep::production_cloth {

template <class Real>
struct Script {
  MovedBodies<Real> bodies;        // at the step's end, larger by the thickness
  std::vector<std::int32_t> held;  // vertices
  Vectors<Real> place;             // m, [k]: where held[k] ends the step
};

// Of the step between two times, s. A vertex is held once: load_scene sees to that.
Script<float> script_of(const Scene& scene, double start, double end);

}  // namespace lockstep::production_cloth
