// The production fluid: its scenes, which do not run yet.
#include "verify/domain.h"
#include "common/production_fluid/scene.h"
#include "verify/arrays.h"

namespace lockstep::verify {
namespace {

// A scene that is loaded must have finite values.
std::string fault_of_scene(const std::string& path) {
  return first_not_finite(production_fluid::load_scene(path).fluid);
}

const RegisterDomain production_fluid_domain{
    {.name = "production_fluid", .moves = false, .determinism = {"obstacle_48"}, .fault_of_scene = fault_of_scene}};

}  // namespace
}  // namespace lockstep::verify
