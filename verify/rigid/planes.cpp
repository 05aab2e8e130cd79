// The rows and benchmarks of planes against convex shapes: bitwise with the serial twin.
#include "verify/rigid/narrow_inputs.h"

namespace lockstep::verify::rigid_planes {
namespace {

using namespace rigid;
using namespace rigid_inputs;

Case planes_case(const std::string& path) {
  return collide_case(path, first_of_planes, first_of_box_box, serial::planes, openmp::planes, 150);
}

const Register planes{{.name = "rigid/planes",
                       .place = 7,
                       .forms = {{.make = planes_case, .scenes = scenes_of_all({"box_pit_4000"}, {"box_pit_4000"})}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_planes
