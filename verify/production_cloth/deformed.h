// A cloth that is stretched, bent and shaken, and moves: what kernels of forces and damping are given.
#pragma once

#include <cmath>
#include <random>

#include "common/production_cloth/elastic.h"
#include "verify/production_cloth/inputs.h"

namespace lockstep::verify::production_cloth_inputs {

// Stretched by 5 % along x, bent by waves along the other axes, and shaken by a hundredth of the waves' height.
inline Vectors<float> deformed_positions(const production_cloth::Scene& scene) {
  Vectors<float> position = rest_positions(scene);
  std::mt19937 random(1);  // whose numbers the standard fixes
  const auto shake = [&] { return 1e-4f * (static_cast<float>(random() >> 8) / (1 << 24) - .5f); };
  for (int i = 0; i < scene.topology.vertices; ++i) {
    const Vector3<float> x = load(position, i);
    const float dx = shake(), dy = shake(), dz = shake();
    store(position, i,
          {1.05f * x.x + dx, x.y + .01f * std::sin(20 * x.x) * std::cos(15 * x.z) + dy,
           x.z + .01f * std::sin(17 * x.x + 11 * x.y) + dz});
  }
  return position;
}

// m/s: waves, and a shake of each vertex.
inline Vectors<float> shaken_velocities(const production_cloth::Scene& scene, unsigned seed = 2) {
  Vectors<float> velocity = rest_positions(scene);
  std::mt19937 random(seed);
  const auto shake = [&] { return .1f * (static_cast<float>(random() >> 8) / (1 << 24) - .5f); };
  for (int i = 0; i < scene.topology.vertices; ++i) {
    const Vector3<float> x = load(velocity, i);
    const float dx = shake(), dy = shake(), dz = shake();
    store(velocity, i, {std::sin(9 * x.y) + dx, std::sin(8 * x.x) - 1 + dy, std::cos(7 * x.z + x.x) + dz});
  }
  return velocity;
}

inline std::shared_ptr<const production_cloth::Elements<float>> elements_of(const production_cloth::Scene& scene) {
  return std::make_shared<const production_cloth::Elements<float>>(
      production_cloth::make_elements<float>(scene.topology, scene.rest, scene.material));
}

// Scenes of all materials.
inline Scenes material_scenes() {
  return {.verify = {"two_triangles", "ball_5k", "tube_5k", "cantilever", "strain_strip", "twisted_strip", "sleeve"},
          .more = {"ball_92k"},
          .bench = {"ball_5k", "ball_92k"},
          .tsan = {"ball_5k", "sleeve", "twisted_strip"}};
}

}  // namespace lockstep::verify::production_cloth_inputs
