// Verlet's update of the game cloth, as the verifier and the benchmark see it: bitwise with its serial twin.
#include "common/cloth/verlet.h"

#include "verify/cloth/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::cloth_verlet {
namespace {

using namespace cloth;
using namespace cloth_inputs;

Case verlet_case(const std::string& path) {
  const auto in = inputs(path);
  const auto start = in->before_verlet;
  const double n = free_particles(*start);
  return make_case<Cloth<float>>({
      .start = start,
      .serial = [](Cloth<float>& cloth) { serial::verlet(cloth); },
      .best_serial = nullptr,
      .openmp = [](Cloth<float>& cloth) { openmp::verlet(cloth); },
      .compare = [start](const auto& openmp,
                         const auto& serial) { return bitwise(openmp, serial, particle_name(*start)); },
      // Bytes: both positions and the mass read, both positions written.
      .work = {n, "particles", 52 * n, verlet_flops(*start)},
  });
}

const Register verlet{
    {.name = "cloth/verlet",
     .place = 1,
     .forms = {{.make = verlet_case, .scenes = scenes_of_all({"flag_128", "garment"}), .takes = has_one_cloth}}}};

}  // namespace
}  // namespace lockstep::verify::cloth_verlet
