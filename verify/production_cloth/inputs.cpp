#include "verify/production_cloth/inputs.h"

#include "common/convert.h"
#include "common/production_cloth/masses.h"
#include "verify/inputs.h"

namespace lockstep::production_cloth {

// For the cache.
inline double bytes_of(const Scene& scene) { return 100. * static_cast<double>(scene.topology.triangles.size()); }

}  // namespace lockstep::production_cloth

namespace lockstep::verify::production_cloth_inputs {

using namespace production_cloth;

std::shared_ptr<const Scene> inputs(const std::string& path) {
  return lockstep::verify::inputs<Scene>(path, [&] { return load_scene(path); });
}

Array<float> inverse_masses(const Scene& scene) {
  const Array<double> mass = lumped_masses(scene.topology, scene.rest, scene.material.density);
  Array<float> inverse(mass.size());
  for (int i = 0; i < scene.topology.vertices; ++i) inverse[i] = static_cast<float>(1 / mass[i]);
  for (const Hold& hold : scene.holds)
    for (const std::int32_t v : hold.vertices) inverse[v] = 0;
  return inverse;
}

Vectors<float> rest_positions(const Scene& scene) { return convert<float>(scene.rest); }

Scenes all_scenes() {
  return {.verify = {"two_triangles", "ball_and_walls", "knot_turns", "ball_5k", "tube_5k"},
          .more = {"ball_92k"},
          .bench = {"ball_5k", "ball_92k"},
          .tsan = {"ball_5k"}};
}

}  // namespace lockstep::verify::production_cloth_inputs
