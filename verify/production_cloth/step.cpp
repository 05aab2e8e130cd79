// A step of the production cloth, as the verifier and the benchmark see it: bitwise with the serial twin, in the motion
// and in what the step took. Besides, no triangle may pass through another: an exact test counts.
#include "common/production_cloth/step.h"

#include "common/production_cloth/intersections.h"
#include "verify/production_cloth/forms.h"
#include "verify/production_cloth/inputs.h"
#include "verify/production_cloth/moving.h"
#include "verify/twin.h"

namespace lockstep::production_cloth {

// A motion, the room of both versions, and what the step took.
struct Moving {
  Motion<float> motion;
  StepMemory<float> of_serial, of_openmp;
  Array<Took> took;
};

template <Same<Moving> M, class F>
void for_each_array(M& moving, const F& f) {
  for_each_array(moving.motion, f);
  f("what the step took", moving.took, moving.took.size());
}

}  // namespace lockstep::production_cloth

namespace lockstep::verify::production_cloth_step {
namespace {

using namespace production_cloth;
using namespace production_cloth_inputs;

Judgement judge(const Moving& openmp, const Moving& serial, const Topology& topology) {
  Judgement judgement = bitwise(openmp, serial);
  if (!judgement.passed) return judgement;
  const Took& took = openmp.took[0];
  const std::size_t intersections = count_intersections(topology, openmp.motion.position);
  judgement.passed = intersections == 0;
  judgement.worst_at = std::to_string(took.iterations) + " iterations, " + std::to_string(took.near) + " near pairs, " +
                       std::to_string(took.collided.impacts) + " impacts, " +
                       std::to_string(took.collided.zone_vertices) + " vertices in zones, " +
                       std::to_string(intersections) + " intersections";
  return judgement;
}

Case make(const std::string& path, const ProductionClothForm& form) {
  const auto in = moving_inputs(path);
  Moving start = {in->motion, serial::make_memory(in->cloth), openmp::make_memory(in->cloth), Array<Took>(1)};
  start.took[0].searches = -1;
  const auto with = [in](Step<float>* step, StepMemory<float> Moving::*memory) {
    return [in, step, memory](Moving& m) {
      step(in->cloth, in->script, m.motion, m.*memory);
      m.took[0] = (m.*memory).took;
    };
  };
  const double vertices = in->cloth.topology.vertices;
  return make_case<Moving>({
      .start = std::make_shared<const Moving>(std::move(start)),
      .serial = with(form.serial, &Moving::of_serial),
      .best_serial = with(serial::step_original, &Moving::of_serial),
      .openmp = with(form.openmp, &Moving::of_openmp),
      .compare = [in](const Moving& openmp, const Moving& serial) { return judge(openmp, serial, in->cloth.topology); },
      // The motion, read and written. Pairs and iterations decide on the rest.
      .work = {double(in->cloth.topology.triangles.size()), "triangles", 48 * vertices, 0},
      .restore =
          [](Moving& now, const Moving& start) {
            if (now.took.empty()) now = start;
            now.motion = start.motion, now.took = start.took;
          },
  });
}

std::vector<Form> forms() {
  std::vector<Form> all;
  for (const ProductionClothForm& form : production_cloth_forms)
    if (form.openmp)
      all.push_back({.name = form.name,
                     .make = [&form](const std::string& path) { return make(path, form); },
                     .scenes = moving_scenes()});
  return all;
}

const Register step{{.name = "production_cloth/step",
                     .place = 10,
                     .serial_forms = {"original", "jacobi", "batches"},
                     .forms = forms()}};

}  // namespace
}  // namespace lockstep::verify::production_cloth_step
