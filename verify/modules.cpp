#include "verify/modules.h"

#include <omp.h>

#include <string>
#include <utility>

#include "common/production_face/scene.h"
#include "common/production_fluid/scene.h"
#include "verify/held_team.h"
#include "verify/production_cloth/frame.h"
#include "verify/production_face/forms.h"
#include "verify/production_fluid/forms.h"
#include "verify/program.h"

namespace lockstep::verify {

void production_modules(const FigureOptions& options, const Model&, RowsOf& rows) {
  using namespace production_fluid;
  const std::string name = options.quick ? "drop_64" : options.full ? "drop_256" : "drop_128";
  const LiquidForm& form = liquid_forms[0];
  const Scene scene = load_scene("scenes/production_fluid/" + name + ".toml");
  Liquid<float> start;
  start.fluid = scene.fluid;
  StepMemory<float> memory;
  serial::start(scene.model, start, memory);
  form.openmp(scene.model, start, memory);
  const auto frame = [&](const std::string& variant, int threads, Step<float>* step) {
    progress("production_modules: " + name + ", " + variant + ", threads " + std::to_string(threads));
    rows.add({{"scene", name}, {"variant", variant}, {"form", form.name}, {"threads", threads}}, [&] {
      Liquid<float> liquid = start;
      hold_team(threads, [&] { step(scene.model, liquid, memory); });
      Rows row = {{"cells", scene.fluid.nx * scene.fluid.ny * scene.fluid.nz},
                  {"particles", liquid.particles.count},
                  {"substeps", memory.substeps},
                  {"iterations", memory.iterations}};
      for (int k = 0; k < int(Module::count); ++k)
        row["modules"].push_back({{"module", name_of_module[k]}, {"ms", 1e3 * memory.seconds[k]}});
      return row;
    });
  };
  const int most = omp_get_max_threads();
  frame("serial", 1, form.serial);
  for (int threads = 1; threads <= most; threads *= 2) frame("openmp", threads, form.openmp);
  omp_set_num_threads(most);
}

void face_modules(const FigureOptions&, const Model&, RowsOf& rows) {
  using namespace production_face;
  const std::string name = "face_381k";
  const Scene scene = load_scene("scenes/production_face/" + name + ".toml");
  const Face<float> face = make_face(scene.body, scene.flesh);
  const auto target = [&](int frame) { return target_at(scene.body, scene.motion, frame * frame_time); };
  SerialMemory in_rows = serial::make_memory(face);
  OpenmpMemory in_slices = openmp::make_memory(face);
  Pose<float> start = scene.pose;
  openmp::step_newton(face, target(2), scene.tolerance, start, in_slices);
  const auto frame = [&](const std::string& form, const std::string& variant, int threads, auto* step, auto& memory) {
    progress("face_modules: " + form + ", " + variant + ", threads " + std::to_string(threads));
    rows.add({{"scene", name}, {"variant", variant}, {"form", form}, {"threads", threads}}, [&] {
      Pose<float> pose = start;
      hold_team(threads, [&] { step(face, target(3), scene.tolerance, pose, memory); });
      Rows row = {{"tetrahedra", scene.body.tetrahedra},
                  {"steps", memory.frame.steps},
                  {"iterations", memory.frame.iterations}};
      for (int k = 0; k < int(Module::count); ++k)
        row["modules"].push_back({{"module", name_of_module[k]}, {"ms", 1e3 * memory.frame.seconds[k]}});
      return row;
    });
  };
  const int most = omp_get_max_threads();
  for (const FaceForm& form : face_forms) {
    frame(form.name, "serial", 1, form.serial, in_rows);
    for (int threads = 1; threads <= most; threads *= 2) frame(form.name, "openmp", threads, form.openmp, in_slices);
  }
  omp_set_num_threads(most);
}

void cloth_modules(const FigureOptions&, const Model&, RowsOf& rows) {
  rows_of_cloth_frame([&](Rows fields, const auto& measure) { rows.add(std::move(fields), measure); });
}

}  // namespace lockstep::verify
