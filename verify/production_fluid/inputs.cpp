#include "verify/production_fluid/inputs.h"

#include "common/production_fluid/make_system.h"
#include "verify/inputs.h"

namespace lockstep::verify::production_fluid_inputs {

using namespace production_fluid;

// For the cache.
double bytes_of(const Inputs& in) { return lockstep::bytes_of(in.scene.fluid) + lockstep::bytes_of(in.system); }

std::shared_ptr<const Inputs> inputs(const std::string& path) {
  return verify::inputs<Inputs>(path, [&] {
    Inputs in{.scene = load_scene(path), .system = {}};
    serial::make_system(in.scene.fluid, in.system);
    return in;
  });
}

double cells_of(const Inputs& in) {
  const Fluid<float>& fluid = in.scene.fluid;
  return double(fluid.nx) * fluid.ny * fluid.nz;
}

double liquid_cells_of(const Inputs& in) {
  double cells = 0;
  for (const Run& run : in.system.runs) cells += run.end - run.begin;
  return cells;
}

Scenes pressure_scenes() {
  return {.verify = {"drop_64", "obstacle_48", "one_cell", "full_box", "two_pockets", "open_top"},
          .more = {"drop_128"},
          .bench = {"drop_128"},
          .tsan = {"obstacle_48"}};
}

}  // namespace lockstep::verify::production_fluid_inputs
