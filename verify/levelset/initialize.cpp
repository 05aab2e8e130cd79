// The points beside the interface, as the verifier and the benchmark see the kernel that finds them: bitwise with its
// serial twin, distances and list of points.
#include "common/levelset/initialize.h"

#include <memory>

#include "verify/levelset/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::levelset_initialize {
namespace {

using namespace levelset;
using namespace levelset_inputs;

Case initialize_case(const std::string& path) {
  const auto in = inputs(path);
  const Field<float>& phi = in->scene.phi;
  const double points = double(phi.nx) * phi.ny * phi.nz;
  auto before = std::make_shared<Distances<float>>(in->start);  // of the same size, as an earlier call leaves them
  poison(*before);
  return make_case<Distances<float>>({
      .start = before,
      .serial = [in](Distances<float>& d) { serial::initialize(in->scene.phi, d); },
      .best_serial = nullptr,
      .openmp = [in](Distances<float>& d) { openmp::initialize(in->scene.phi, d); },
      .compare = [in](const auto& openmp,
                      const auto& serial) { return bitwise(openmp, serial, point_name(in->start.distance)); },
      .work = {points, "points", 8 * points, 20 * points},
  });
}

const Register initialize{{.name = "levelset/initialize",
                           .place = 1,
                           .forms = {{.make = initialize_case, .scenes = scenes_of_all({"spheres_and_box_256"})}}}};

}  // namespace
}  // namespace lockstep::verify::levelset_initialize
