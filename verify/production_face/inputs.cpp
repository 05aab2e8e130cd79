#include "verify/production_face/inputs.h"

#include "verify/inputs.h"

namespace lockstep::production_face {

inline double bytes_of(const Scene& scene) { return 500. * scene.body.padded_tetrahedra(); }

}  // namespace lockstep::production_face

namespace lockstep::verify::production_face_inputs {

std::shared_ptr<const production_face::Scene> inputs(const std::string& path) {
  return lockstep::verify::inputs<production_face::Scene>(path, [&] { return production_face::load_scene(path); });
}

Scenes body_scenes() {
  return {.verify = {"bar_shaken", "one_cell", "inside_out"},
          .more = {"block_370k"},
          .bench = {"block_370k"},
          .tsan = {"one_cell", "bar_shaken"}};
}

}  // namespace lockstep::verify::production_face_inputs
