// The game cloth's whole step, as the verifier and the benchmark see it: bitwise for one step and for a whole run,
// whose every step is also asked what verify/cloth/run.h says. Timed is one step.
#include "common/cloth/step.h"

#include "verify/cloth/forms.h"
#include "verify/cloth/inputs.h"
#include "verify/cloth/run.h"
#include "verify/twin.h"

namespace lockstep::verify::cloth_step {
namespace {

using namespace cloth;
using namespace cloth_inputs;

Case step_case(const std::string& path, const ClothForm& form) {
  const auto in = inputs(path);
  const auto start = in->before_verlet;
  const double n = free_particles(*start), substeps = start->model.substeps;
  return make_case<Cloth<float>>({
      .start = start,
      .serial = form.serial_step,
      .best_serial = [](Cloth<float>& cloth) { serial::step_original(cloth); },
      .openmp = form.openmp_step,
      .compare =
          [in, form](const auto& openmp, const auto& serial) {
            Judgement judgement = bitwise(openmp, serial, particle_name(serial));
            check_run(judgement, in->scene, *serial_run(in->scene, form.name, form.serial_step), form.openmp_step);
            return judgement;
          },
      .work = {substeps * projections(*start), "projections", 52 * n,
               substeps * (verlet_flops(*start) + flops_of_projection * projections(*start))},
  });
}

std::vector<Form> forms() {
  std::vector<Form> all;
  for (const ClothForm& form : cloth_forms)
    if (form.openmp_step)
      all.push_back(
          {.name = form.name,
           .make = [form](const std::string& path) { return step_case(path, form); },
           .scenes = form.for_meshes ? scenes_of_all({"garment"}) : scenes_of_sheets({"flag_128", "flag_128_substeps"}),
           .takes = form.for_meshes ? has_one_cloth : is_sheet});
  return all;
}

const Register step{{.name = "cloth/step", .place = 4, .serial_forms = serial_cloth_forms, .forms = forms()}};

}  // namespace
}  // namespace lockstep::verify::cloth_step
