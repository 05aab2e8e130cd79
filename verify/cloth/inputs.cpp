#include "verify/cloth/inputs.h"

#include <algorithm>

#include "common/cloth/make.h"
#include "common/cloth/verlet.h"
#include "verify/cloth/forms.h"
#include "verify/inputs.h"

namespace lockstep::verify::cloth_inputs {

using namespace cloth;

namespace {

constexpr int settling_steps = 30;

Inputs make(const std::string& path) {
  Inputs in{load_scene(path), {}, {}, {}, {}};
  Cloth<float> cloth = convert<float>(in.scene.cloth);
  const ClothForm& form = first_form(cloth);
  const auto keep = [&] { return std::make_shared<const Cloth<float>>(cloth); };
  in.start = keep();
  Step<float>* const step = settles_by_openmp ? form.openmp_step : form.serial_step;
  for (int k = 0; k < settling_steps; ++k) step(cloth);
  in.before_verlet = keep();
  serial::verlet(cloth);
  in.before_relax = keep();
  form.serial_relax(cloth, cloth.model.iterations);
  in.before_collide = keep();
  return in;
}

}  // namespace

// For the cache.
double bytes_of(const Inputs& in) {
  const double lists = 60. * in.start->constraints.count;  // constraints twice, triangles, corners
  return 4 * (3 * lockstep::bytes_of(*in.start) + lists);
}

std::shared_ptr<const Inputs> inputs(const std::string& path) {
  return verify::inputs<Inputs>(path, [&] { return make(path); });
}

ValueName particle_name(const Cloth<float>& cloth) {
  return [sheet = cloth.sheet](const std::string& array, std::size_t i, const std::string& field) {
    const std::string what = array + '.' + field + " of ";
    if (sheet.rows == 0) return what + "point " + std::to_string(i);
    return what + "particle (" + std::to_string(i / sheet.pitch) + ", " + std::to_string(i % sheet.pitch) + ")";
  };
}

double free_particles(const Cloth<float>& cloth) {
  return std::count_if(cloth.inverse_mass.begin(), cloth.inverse_mass.begin() + cloth.count,
                       [](float w) { return w > 0; });
}
double projections(const Cloth<float>& c) { return double(c.constraints.count) * c.model.iterations; }
double verlet_flops(const Cloth<float>& c) {
  return 24 * free_particles(c) + (c.model.drag > 0 ? 65. : 0.) * c.triangles.size();
}

Scenes scenes_of_sheets(std::vector<std::string> bench) {
  return {.verify = {"flag_33", "curtain", "sheet_on_sphere", "pulled_edge", "rope", "tiny",
                     "sheet_over_box_and_capsule", "flag_128"},
          .more = {"flag_128_substeps", "flag_256", "flag_1024"},
          .bench = std::move(bench),
          .tsan = {"flag_128", "sheet_on_sphere"}};
}

Scenes scenes_of_all(std::vector<std::string> bench) {
  Scenes scenes = scenes_of_sheets(std::move(bench));
  scenes.verify.insert(scenes.verify.end(), {"garment", "napkin"});
  scenes.tsan.push_back("garment");
  return scenes;
}

bool has_one_cloth(const std::string& path) { return load_scene(path).others.empty(); }
bool is_sheet(const std::string& path) { return has_one_cloth(path) && inputs(path)->start->sheet.rows > 0; }

}  // namespace lockstep::verify::cloth_inputs
