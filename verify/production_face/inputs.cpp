#include "verify/production_face/inputs.h"

#include "common/production_face/update_state.h"
#include "verify/inputs.h"

namespace lockstep::production_face {

inline double bytes_of(const Scene& scene) { return 500. * scene.body.padded_tetrahedra(); }

}  // namespace lockstep::production_face

namespace lockstep::verify::production_face_inputs {

std::shared_ptr<const production_face::Scene> inputs(const std::string& path) {
  return lockstep::verify::inputs<production_face::Scene>(path, [&] { return production_face::load_scene(path); });
}

std::shared_ptr<const production_face::Strained<float>> strained(const std::string& path) {
  return lockstep::verify::inputs<production_face::Strained<float>>(path, [&] {
    const auto in = inputs(path);
    production_face::Strained<float> strained = production_face::make_strained(in->body);
    production_face::serial::update_state(in->body, in->flesh, in->pose, true, strained);
    return strained;
  });
}

Scenes body_scenes() {
  return {.verify = {"bar_shaken", "one_cell", "inside_out"},
          .more = {"block_370k"},
          .bench = {"block_370k"},
          .tsan = {"one_cell", "bar_shaken"}};
}

}  // namespace lockstep::verify::production_face_inputs
