#include "verify/production_fluid/inputs.h"

#include <algorithm>

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

Faces<float> velocity(const Inputs& in) {
  const Faces<float>& from = in.scene.fluid.velocity;
  const auto marked = [](const Field<float>& field) {
    Field<float> copy = levelset::make_field<float>(field.nx, field.ny, field.nz, field.spacing, 7);
    for (int z = 0; z < field.nz; ++z)
      for (int y = 0; y < field.ny; ++y) std::copy_n(&field(0, y, z), field.nx, &copy(0, y, z));
    return copy;
  };
  return {marked(from.u), marked(from.v), marked(from.w)};
}

// Wrapped, so that the cache knows how large it is.
struct Solved {
  Array<double> q;
};
double bytes_of(const Solved& solved) { return 8. * solved.q.size(); }

std::shared_ptr<const Array<double>> pressure(const std::string& path) {
  const auto solved = verify::inputs<Solved>(path, [&] {
    Solved made;
    PressureMemory<float> memory;
    serial::pressure_solve_mic(inputs(path)->system, pressure_settings, memory, made.q);
    return made;
  });
  return std::shared_ptr<const Array<double>>(solved, &solved->q);
}

double cells_of(const Inputs& in) {
  const Fluid<float>& fluid = in.scene.fluid;
  return double(fluid.nx) * fluid.ny * fluid.nz;
}

double faces_of(const Inputs& in) {
  const Fluid<float>& fluid = in.scene.fluid;
  const double nx = fluid.nx, ny = fluid.ny, nz = fluid.nz;
  return (nx + 1) * ny * nz + nx * (ny + 1) * nz + nx * ny * (nz + 1);
}

double liquid_cells_of(const Inputs& in) {
  double cells = 0;
  for (const Run& run : in.system.runs) cells += run.end - run.begin;
  return cells;
}

Scenes pressure_scenes() {
  return {.verify = {"drop_64", "obstacle_48", "one_cell", "full_box", "two_pockets", "open_top"},
          .more = {"drop_128", "drop_256"},
          .bench = {"drop_128"},
          .tsan = {"obstacle_48"}};
}

}  // namespace lockstep::verify::production_fluid_inputs
