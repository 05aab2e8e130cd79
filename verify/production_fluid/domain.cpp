// The production fluid: its scenes, which do not run yet.
#include <cmath>
#include <functional>

#include "common/production_fluid/scene.h"
#include "verify/domain.h"

namespace lockstep::verify {
namespace {

// A scene that is loaded must have finite values.
std::string fault_of_scene(const std::string& path) {
  const production_fluid::Scene scene = production_fluid::load_scene(path);
  std::string fault;
  for_each_array(scene.fluid, [&](const char* name, const Array<float>& array, std::size_t) {
    for (const float value : array)
      if (!std::isfinite(value)) fault = std::string(name) + " is not finite";
  });
  return fault;
}

const RegisterDomain production_fluid_domain{
    {.name = "production_fluid", .moves = false, .determinism = {"obstacle_48"}, .fault_of_scene = fault_of_scene}};

}  // namespace
}  // namespace lockstep::verify
