// The game cloth: what `run` and `endure` do with its scenes.
#include <memory>

#include "common/cloth/make.h"
#include "common/cloth/scene.h"
#include "common/cloth/vtk.h"
#include "verify/arrays.h"
#include "verify/cloth/forms.h"
#include "verify/domain.h"

namespace lockstep::verify {
namespace {

using cloth::Cloth;

Simulation simulation(const RunOptions& options) {
  const cloth::Scene scene = cloth::load_scene(options.scene);
  auto state = std::make_shared<Cloth<float>>(cloth::convert<float>(scene.cloth));
  const bool serial = options.variant == "serial", is_sheet = state->sheet.rows > 0;
  const ClothForm& form = find_form(cloth_forms, options.form, [&](const ClothForm& f) {
    return (f.for_meshes || is_sheet) && (serial ? f.serial_step : f.openmp_step);
  });
  cloth::Step<float>* const step = serial ? form.serial_step : form.openmp_step;
  std::vector<Part> parts = {{"frame", true, [state](const std::string& path) { cloth::write_vtk(path, *state); }}};
  const auto& [planes, capsules, boxes, friction] = state->bodies;
  if (!planes.empty() || !capsules.empty() || !boxes.empty())
    parts.push_back({"obstacles", false, [state](const std::string& path) { cloth::write_obstacles(path, *state); }});
  return {
      .name = scene.name,
      .form = form.name,
      .elements = is_sheet ? state->sheet.rows * state->sheet.columns : state->count,
      .unit = "particles",
      .frames = scene.frames,
      .step = [state, step] { step(*state); },
      .time_step = scene.cloth.model.time_step * scene.cloth.model.substeps,
      .parts = parts,
      .write_state = nullptr,
      .state_formats = {},
      .state = keep_all(*state),
      .fault = [state] { return first_not_finite(*state, of_element("particle")); },
      .summary = nullptr,
  };
}

std::string fault_of_scene(const std::string& path) {
  const Cloth<float> cloth = cloth::convert<float>(cloth::load_scene(path).cloth);
  if (const std::string fault = first_not_finite(cloth); !fault.empty()) return fault;
  for (int k = 0; k < cloth.constraints.count; ++k)
    if (!(cloth.constraints.rest_2[k] > 0 && std::isfinite(cloth.constraints.rest_2[k])))
      return "the length of constraint " + std::to_string(k) + " is not in the range of float";
  return "";
}

const RegisterDomain cloth_domain{
    {.name = "cloth", .simulation = simulation, .determinism = {"flag_33"}, .fault_of_scene = fault_of_scene}};

}  // namespace
}  // namespace lockstep::verify
