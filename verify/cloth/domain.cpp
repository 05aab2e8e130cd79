// The game cloth: what `run` and `endure` do with its scenes.
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/cloth/cloths.h"
#include "common/cloth/make.h"
#include "common/cloth/scene.h"
#include "common/cloth/vtk.h"
#include "verify/arrays.h"
#include "verify/cloth/forms.h"
#include "verify/domain.h"

namespace lockstep::verify {
namespace {

using cloth::Cloth;

// The cloths of a scene in float.
std::vector<Cloth<float>> cloths_of(const cloth::Scene& scene) {
  std::vector<Cloth<float>> cloths = {cloth::convert<float>(scene.cloth)};
  for (const Cloth<double>& other : scene.others) cloths.push_back(cloth::convert<float>(other));
  return cloths;
}

struct Stepped {
  std::string form;
  std::function<void(std::vector<Cloth<float>>&)> step;
};
Stepped stepped(const RunOptions& options, const std::vector<Cloth<float>>& cloths) {
  const bool serial = options.variant == "serial", is_sheet = cloths[0].sheet.rows > 0;
  if (cloths.size() == 1) {
    const ClothForm& form = find_form(cloth_forms, options.form, [&](const ClothForm& f) {
      return (f.for_meshes || is_sheet) && (serial ? f.serial_step : f.openmp_step);
    });
    const auto step = serial ? form.serial_step : form.openmp_step;
    return {form.name, [step](std::vector<Cloth<float>>& all) { step(all[0]); }};
  }
  const struct { std::string name; } forms[] = {{"cloths"}};
  cloth::StepCloths<float>* step = cloth::openmp::step_cloths;
  if (serial) step = cloth::serial::step_cloths;
  return {find_form(forms, options.form, [](const auto&) { return true; }).name,
          [step](std::vector<Cloth<float>>& all) { step(all); }};
}

Simulation simulation(const RunOptions& options) {
  const cloth::Scene scene = cloth::load_scene(options.scene);
  const auto state = std::make_shared<std::vector<Cloth<float>>>(cloths_of(scene));
  const Stepped run = stepped(options, *state);
  std::vector<Part> parts = {{"frame", true, [state](const std::string& path) { cloth::write_vtk(path, *state); }}};
  const auto& [planes, capsules, boxes, friction] = scene.bodies;
  if (!planes.empty() || !capsules.empty() || !boxes.empty())
    parts.push_back({"obstacles", false, [state](const std::string& path) { cloth::write_obstacles(path, *state); }});
  int particles = 0;
  std::vector<Kept> kept;
  for (Cloth<float>& one : *state) {
    particles += one.sheet.rows > 0 ? one.sheet.rows * one.sheet.columns : one.count;
    const std::vector<Kept> of_one = keep_all(one);
    kept.insert(kept.end(), of_one.begin(), of_one.end());
  }
  return {
      .name = scene.name,
      .form = run.form,
      .elements = particles,
      .unit = "particles",
      .frames = scene.frames,
      .step = [state, step = run.step] { step(*state); },
      .time_step = scene.cloth.model.time_step * scene.cloth.model.substeps,
      .parts = parts,
      .write_state = nullptr,
      .state_formats = {},
      .state = kept,
      .fault =
          [state] {
            for (const Cloth<float>& one : *state)
              if (const std::string fault = first_not_finite(one, of_element("particle")); !fault.empty()) return fault;
            return std::string();
          },
      .summary = nullptr,
  };
}

std::string fault_of_scene(const std::string& path) {
  for (const Cloth<float>& one : cloths_of(cloth::load_scene(path))) {
    if (const std::string fault = first_not_finite(one); !fault.empty()) return fault;
    for (int k = 0; k < one.constraints.count; ++k)
      if (!(one.constraints.rest_2[k] > 0 && std::isfinite(one.constraints.rest_2[k])))
        return "the length of constraint " + std::to_string(k) + " is not in the range of float";
  }
  return "";
}

const RegisterDomain cloth_domain{
    {.name = "cloth", .simulation = simulation, .determinism = {"flag_33"}, .fault_of_scene = fault_of_scene}};

}  // namespace
}  // namespace lockstep::verify
