// The rows and benchmarks of spheres and capsules: bitwise with the serial twin.
#include "verify/rigid/narrow_inputs.h"

namespace lockstep::verify::rigid_spheres {
namespace {

using namespace rigid;
using namespace rigid_inputs;

Case spheres_case(const std::string& path) {
  return collide_case(path, first_of_spheres, first_of_planes, serial::spheres, openmp::spheres, 60);
}

const Register spheres{{.name = "rigid/spheres",
                        .place = 6,
                        .forms = {{.make = spheres_case,
                                   .scenes = some_scenes({"rounds_20000", "soup_10", "assorted", "degenerate"},
                                                         {"rounds_20000"}, {"rounds_20000"})}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_spheres
