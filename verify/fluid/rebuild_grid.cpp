// The game fluid's sort into cells, as the verifier and the benchmark see it: bitwise with its serial twin.
#include "common/fluid/rebuild_grid.h"

#include <algorithm>
#include <array>

#include "verify/fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::fluid_rebuild_grid {
namespace {

using namespace fluid;
using namespace fluid_inputs;

struct State {
  Grid<float> grid;
  Particles<float> particles, scratch;
};

template <Same<State> S, class F>
void for_each_array(S& state, const F& f) {
  f("cell_begin", state.grid.cell_begin, state.grid.cell_begin.size());
  for_each_array(state.particles, f);
}

Case rebuild_grid_case(const std::string& path, RebuildGrid<float>* openmp) {
  const auto in = inputs(path);
  const double n = in->fluid.particles.count, cells = in->fluid.grid.cells();
  const auto start = std::make_shared<State>(State{in->fluid.grid, in->unsorted, in->unsorted});
  std::ranges::fill(start->grid.cell_begin, -1);
  const auto with = [](RebuildGrid<float>* form) { return [form](State& s) { form(s.grid, s.particles, s.scratch); }; };
  return make_case<State>({
      .start = start,
      .serial = with(serial::rebuild_grid),
      .best_serial = nullptr,
      .openmp = with(openmp),
      .compare = {},
      .work = {n, "particles", 2 * particle_bytes * n + 4 * cells, 9 * n, lanes_in_use(std::array{n})},
  });
}

Form form(const char* name, RebuildGrid<float>* openmp) {
  return {
      .name = name, .make = [openmp](auto& path) { return rebuild_grid_case(path, openmp); }, .scenes = scenes_with()};
}

const Register rebuild_grid{{.name = "fluid/rebuild_grid",
                             .place = 1,
                             .forms = {form("counting_sort", openmp::rebuild_grid_counting_sort),
                                       form("linked_lists", openmp::rebuild_grid_linked_lists)}}};

}  // namespace
}  // namespace lockstep::verify::fluid_rebuild_grid
