// The length of a time step, as the verifier and the benchmark see it: bitwise with the serial twin.
#include "common/production_fluid/time_step.h"

#include <algorithm>

#include "verify/production_fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_time_step {

// What the kernel returns.
struct Longest {
  Array<float> time_step;
};
template <Same<Longest> L, class F>
void for_each_array(L& longest, const F& f) {
  f("time_step", longest.time_step, longest.time_step.size());
}

namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

// The scene's velocity, so much faster towards the far sides that a cell's far face is always the faster one: otherwise
// a kernel that leaves that face out might find the same cell.
Faces<float> faster_far_away(const Inputs& in) {
  Faces<float> faces = velocity(in);
  const auto add = [](Field<float>& component, const auto& share) {
    for (int z = 0; z < component.nz; ++z)
      for (int y = 0; y < component.ny; ++y)
        for (int x = 0; x < component.nx; ++x) component(x, y, z) -= 40 * share(x, y, z);
  };
  const Fluid<float>& fluid = in.scene.fluid;
  add(faces.u, [&](int x, int, int) { return float(x) / fluid.nx; });
  add(faces.v, [&](int, int y, int) { return float(y) / fluid.ny; });
  add(faces.w, [&](int, int, int z) { return float(z) / fluid.nz; });
  // Padding is faster still.
  for (Field<float>* field : {&faces.u, &faces.v, &faces.w})
    for (int line = 0; line < field->ny * field->nz; ++line) {
      float* const end = &field->value[field->index(0, 0, 0) + std::size_t(line) * field->pitch + field->nx];
      std::fill_n(end, field->pitch - field->nx, 1e3f);
    }
  return faces;
}

Case make(const std::string& path) {
  const auto in = inputs(path);
  const auto faces = std::make_shared<const Faces<float>>(faster_far_away(*in));
  const auto with = [faces](TimeStep<float>* time_step) {
    return [faces, time_step](Longest& longest) { longest.time_step[0] = time_step(*faces, 9.81f, .9f); };
  };
  Longest start{Array<float>(1)};
  poison(start);
  const double cells = cells_of(*in);
  return make_case<Longest>({
      .start = std::make_shared<const Longest>(std::move(start)),
      .serial = with(serial::time_step),
      .best_serial = nullptr,
      .openmp = with(openmp::time_step),
      .compare = nullptr,
      // Three components read; two sums. Comparisons do not count.
      .work = {cells, "cells", 12 * cells, 2 * cells},
  });
}

const Register time_step{
    {.name = "production_fluid/time_step", .place = 9, .forms = {{.make = make, .scenes = pressure_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_time_step
