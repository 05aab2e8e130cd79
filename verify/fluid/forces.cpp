// The game fluid's forces, as the verifier and the benchmark see them: bounded by the double truth. notes/fluid.md
// derives the bound.
#include "common/fluid/forces.h"

#include <algorithm>
#include <limits>

#include "common/fluid/densities.h"
#include "verify/fluid/bounds.h"
#include "verify/fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::fluid_forces {
namespace {

using namespace fluid;
using namespace fluid_inputs;

struct State {
  Neighbours<float> neighbours;  // those of the serial densities; a copy, for the scratch in it
  Vectors<float> acceleration;
  int count;
};

template <Same<State> S, class F>
void for_each_array(S& state, const F& f) {
  f("acceleration", state.acceleration, state.count);
}

// How long the lists are that start in a vector of their own: a particle's of the owner-gather lists, a row's of the
// pair lists.
std::vector<int> lengths_of_lists(const Grid<float>& grid, const Neighbours<float>& neighbours) {
  std::vector<int> lengths;
  for (int z = 0; z < grid.z.cells; ++z)
    for (int y = 0, of_plane = 0; y < grid.y.cells; ++y) {
      const Run row = row_run(grid, 0, grid.x.cells - 1, y, z);
      if (row.begin == row.end) continue;
      if (!neighbours.plane[z].empty()) {
        lengths.push_back(neighbours.end[row.end - 1] - of_plane);
        of_plane = neighbours.end[row.end - 1];
      } else {
        for (int i = row.begin, begin = 0; i < row.end; begin = neighbours.end[i++])
          lengths.push_back(neighbours.end[i] - begin);
      }
    }
  return lengths;
}

Case forces_case(const std::string& path, Densities<float>* lists, Forces<float>* twin, Forces<float>* openmp) {
  const auto in = inputs(path);
  const Fluid<float>& f = in->fluid;
  const int count = f.particles.count;
  const double n = count;
  const auto start = std::make_shared<State>(State{make_neighbours(f.grid, count), {}, count});
  start->acceleration.resize(count);
  Array<float> density = f.density;
  if (lists) lists(f.model, f.grid, f.particles, start->neighbours, density);
  std::ranges::fill(start->neighbours.scratch, std::numeric_limits<float>::quiet_NaN());
  poison(*start);

  struct Truth {
    Vectors<double> acceleration, rounding;
  };
  const auto truth = std::make_shared<Truth>();
  Fluid<double> fluid = in->truth;
  truth->acceleration.resize(count);
  serial::forces_symmetric(fluid.model, fluid.grid, fluid.particles, fluid.neighbours, fluid.density,
                           truth->acceleration);
  truth->rounding = force_rounding(fluid, fluid.density, std::vector<double>(count, 0));

  Forces<float>* best = serial::forces_symmetric;
  const auto with = [in](Forces<float>* form) -> std::function<void(State&)> {
    return [in, form](State& s) {
      form(in->fluid.model, in->fluid.grid, in->fluid.particles, s.neighbours, in->fluid.density, s.acceleration);
    };
  };
  return make_case<State>({
      .start = start,
      .serial = with(twin),
      .best_serial = twin == best ? nullptr : with(best),
      .openmp = with(openmp),
      .compare =
          [in, truth, count](const State& openmp, const State& serial) {
            Judgement judgement{.verdict = Verdict::bounded, .worst_at = ""};
            const auto axis = [&](const char* what, Array<float> Vectors<float>::*k,
                                  Array<double> Vectors<double>::*of_truth) {
              within_bound(judgement, first(openmp.acceleration.*k, count), first(serial.acceleration.*k, count),
                           first(truth->acceleration.*of_truth, count), first(truth->rounding.*of_truth, count),
                           particle_name(*in, what));
            };
            axis("x acceleration", &Vectors<float>::x, &Vectors<double>::x);
            axis("y acceleration", &Vectors<float>::y, &Vectors<double>::y);
            axis("z acceleration", &Vectors<float>::z, &Vectors<double>::z);
            return judgement;
          },
      .work = {n, "particles", 40 * n, 8 * in->tested_pairs + 33 * in->near_pairs,
               lists ? lanes_in_use(lengths_of_lists(f.grid, start->neighbours)) : 0},
      .restore =
          [](State& now, const State& start) {
            now.acceleration = start.acceleration;
            now.neighbours.scratch = start.neighbours.scratch;
          },
  });
}

Form form(const char* name, bool order_dependent, Densities<float>* lists, Forces<float>* twin, Forces<float>* openmp) {
  return {.name = name,
          .make = [=](auto& path) { return forces_case(path, lists, twin, openmp); },
          .scenes = scenes_with(),
          .order_dependent = order_dependent};
}

const Register forces{
    {.name = "fluid/forces",
     .place = 3,
     .serial_forms = {"symmetric", "owner_gather", "pair_lists"},
     .forms = {
         form("owner_gather", false, serial::densities_owner_gather, serial::forces_owner_gather,
              openmp::forces_owner_gather),
         form("pair_lists", false, serial::densities_pair_lists, serial::forces_pair_lists, openmp::forces_pair_lists),
         form("sub_grid", true, nullptr, serial::forces_symmetric, openmp::forces_sub_grid),
         form("cell_locks", true, nullptr, serial::forces_symmetric, openmp::forces_cell_locks)}}};

}  // namespace
}  // namespace lockstep::verify::fluid_forces
