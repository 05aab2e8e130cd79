// The rows and benchmarks of the integration of bodies' motion: bitwise with the serial twin.
#include "common/rigid/integrate.h"

#include "verify/rigid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::rigid_integrate {
namespace {

using namespace rigid;
using namespace rigid_inputs;

Case integrate_case(const std::string& path) {
  const auto in = inputs(path);
  const auto with = [in](Integrate<float>* integrate) {
    return [in, integrate](Bodies<float>& bodies) {
      integrate(in->now.moving, static_cast<float>(in->settings.solver.time_step), bodies);
    };
  };
  const double n = in->world.bodies.count;
  return make_case<Bodies<float>>({
      .start = std::make_shared<const Bodies<float>>(in->world.bodies),
      .serial = with(serial::integrate),
      .best_serial = nullptr,
      .openmp = with(openmp::integrate),
      .compare = nullptr,
      .work = {n, "bodies", n * 6 * bytes_of_pose, n * 350},
  });
}

const Register integrate{{.name = "rigid/integrate",
                          .place = 17,
                          .forms = {{.make = integrate_case, .scenes = scenes_of_all(of_many_bodies)}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_integrate
