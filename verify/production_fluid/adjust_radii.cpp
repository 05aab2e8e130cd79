// The particles' radii, as the verifier and the benchmark see them: bitwise with the serial twin.
#include "common/production_fluid/adjust_radii.h"

#include "verify/production_fluid/advection.h"
#include "verify/production_fluid/inputs.h"
#include "verify/production_fluid/particles.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_adjust_radii {
namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

Case make(const std::string& path) {
  const auto in = inputs(path);
  auto start = std::make_shared<Particles<float>>(*particles(path));
  start->radius.assign(start->radius.size(), 0);
  const auto with = [in](AdjustRadii<float>* adjust_radii) {
    return [in, adjust_radii](Particles<float>& p) { adjust_radii(in->scene.fluid.phi, p); };
  };
  const double n = start->count;
  return make_case<Particles<float>>({
      .start = start,
      .serial = with(serial::adjust_radii),
      .best_serial = nullptr,
      .openmp = with(openmp::adjust_radii),
      .compare = nullptr,
      // Position and sign read, radius written; three into cells, three fractions, seven interpolations of 3.
      .work = {n, "particles", 20 * n, (3 + 3 + 21 + 1) * n},
      .restore = [](Particles<float>& now, const Particles<float>& start) { now.radius = start.radius; },
  });
}

const Register adjust_radii{
    {.name = "production_fluid/adjust_radii", .place = 13, .forms = {{.make = make, .scenes = advection_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_adjust_radii
