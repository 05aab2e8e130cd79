// The game cloth's collisions, as the verifier and the benchmark see them: bitwise with their serial twin.
#include "common/cloth/collide.h"

#include "verify/cloth/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::cloth_collide {
namespace {

using namespace cloth;
using namespace cloth_inputs;

Case collide_case(const std::string& path) {
  const auto in = inputs(path);
  const auto start = in->before_collide;
  const Bodies<float>& bodies = start->bodies;
  const double n = free_particles(*start);
  const double flops = 6. * bodies.planes.size() + 30. * bodies.capsules.size() + 27. * bodies.boxes.size();
  return make_case<Cloth<float>>({
      .start = start,
      .serial = [](Cloth<float>& cloth) { serial::collide(cloth); },
      .best_serial = nullptr,
      .openmp = [](Cloth<float>& cloth) { openmp::collide(cloth); },
      .compare = [start](const auto& openmp,
                         const auto& serial) { return bitwise(openmp, serial, particle_name(*start)); },
      .work = {n, "particles", 40 * n, flops * n},  // bytes: both positions and the mass read, one position written
  });
}

Scenes scenes() {
  Scenes all = scenes_of_all({"sheet_over_box_and_capsule", "garment"});
  all.tsan = {"sheet_on_sphere", "garment"};  // the flag meets nothing
  return all;
}

const Register collide{{.name = "cloth/collide",
                        .place = 3,
                        .forms = {{.make = collide_case, .scenes = scenes(), .takes = has_one_cloth}}}};

}  // namespace
}  // namespace lockstep::verify::cloth_collide
