// The game fluid's densities, as the verifier and the benchmark see them: bounded by the double truth, and the lists of
// neighbours bitwise. notes/fluid.md derives the bound.
#include "common/fluid/densities.h"

#include <algorithm>
#include <limits>

#include "openmp/fluid/candidates.h"
#include "verify/fluid/inputs.h"
#include "verify/fluid/run.h"
#include "verify/twin.h"

namespace lockstep::verify::fluid_densities {
namespace {

using namespace fluid;
using namespace fluid_inputs;

struct State {
  Neighbours<float> neighbours;
  Array<float> density;
  int count;
};

template <Same<State> S, class F>
void for_each_array(S& state, const F& f) {
  f("density", state.density, state.count);
}

// What a kernel must overwrite before it reads it. Lists keep the room that they grew to, as from frame to frame.
void restore(State& now, const State& start) {
  constexpr float left_over = std::numeric_limits<float>::quiet_NaN();
  now.density = start.density;
  Neighbours<float>& n = now.neighbours;
  std::ranges::fill(n.scratch, left_over), std::ranges::fill(n.end, 0);
  for (auto& list : n.row) std::ranges::fill(list, 0);
  for (auto& list : n.plane) std::ranges::fill(list, 0);
  for (auto& list : n.distance_2) std::ranges::fill(list, left_over);
}

// Asserts of the lists of neighbours that densities leave for the forces: the same ones, in the same order.
void same_lists(Judgement& judgement, const Inputs& in, const Neighbours<float>& openmp,
                const Neighbours<float>& serial) {
  const Grid<float>& grid = in.fluid.grid;
  const int count = in.fluid.particles.count;
  Judgement lists{.verdict = Verdict::bitwise, .worst_at = ""};
  same_bits(lists, std::span(openmp.end.data(), count), std::span(serial.end.data(), count),
            particle_name(in, "end of the list"));
  const auto same = [&](const auto& of_openmp, const auto& of_serial, const Run& run, const std::string& where) {
    if (!lists.passed || of_serial.empty() || run.begin == run.end) return;
    const std::size_t n = serial.end[run.end - 1];
    const ElementName name = [&](std::size_t k) { return "entry " + std::to_string(k) + " of the list of " + where; };
    if (of_openmp.size() < n)
      lists.passed = false, lists.worst_at = "the list of " + where + " is too short";
    else
      same_bits(lists, std::span(of_openmp.data(), n), std::span(of_serial.data(), n), name);
  };
  for (int z = 0; z < grid.z.cells; ++z) {
    for (int y = 0; y < grid.y.cells; ++y) {
      const int row = z * grid.y.cells + y;
      same(openmp.row[row], serial.row[row], row_run(grid, 0, grid.x.cells - 1, y, z), "row " + std::to_string(row));
    }
    same(openmp.plane[z], serial.plane[z], plane_run(grid, z, z), "plane " + std::to_string(z));
    same(openmp.distance_2[z], serial.distance_2[z], plane_run(grid, z, z), "distances in plane " + std::to_string(z));
  }
  if (lists.passed) return;
  judgement.passed = false;
  judgement.worst_at = lists.worst_at;
}

// How many candidates each particle is tested against in vectors of their own; none for the forms that test them where
// they are.
std::vector<int> numbers_of_candidates(const Fluid<float>& fluid, Densities<float>* form) {
  const bool pairs = form == openmp::densities_pair_lists;
  if (!pairs && form != openmp::densities_owner_gather) return {};
  const Grid<float>& grid = fluid.grid;
  const Vectors<float>& position = fluid.particles.position;
  const int block = pairs ? openmp::block_cells : 1;
  openmp::Candidates candidates;
  std::vector<int> numbers;
  for (int z = 0; z < grid.z.cells; ++z)
    for (int y = 0; y < grid.y.cells; ++y)
      for (int x = 0; x < grid.x.cells; x += block) {
        const Run own = row_run(grid, x, x + block - 1, y, z);
        const Runs runs = pairs ? forward_runs(grid, x, x + block - 1, y, z) : neighbour_runs(grid, x, y, z);
        candidates.pack(own, runs, position, fluid.model.smoothing_length_2);
        numbers.insert(numbers.end(), own.end - own.begin, candidates.count);
      }
  return numbers;
}

Case densities_case(const std::string& path, Densities<float>* twin, Densities<float>* openmp) {
  const auto in = inputs(path);
  const Fluid<float>& f = in->fluid;
  const double n = f.particles.count;
  const auto start = std::make_shared<State>(
      State{make_neighbours(f.grid, f.particles.count), Array<float>(padded(f.particles.count)), f.particles.count});
  poison(*start);
  Densities<float>* best = serial::densities_symmetric;
  const auto with = [in](Densities<float>* form) -> std::function<void(State&)> {
    return
        [in, form](State& s) { form(in->fluid.model, in->fluid.grid, in->fluid.particles, s.neighbours, s.density); };
  };
  return make_case<State>({
      .start = start,
      .serial = with(twin),
      .best_serial = twin == best ? nullptr : with(best),
      .openmp = with(openmp),
      .compare =
          [in](const State& openmp, const State& serial) {
            Judgement judgement{.verdict = Verdict::bounded, .worst_at = ""};
            within_bound(judgement, first(openmp.density, openmp.count), first(serial.density, serial.count),
                         in->true_density, in->density_rounding, particle_name(*in, "density"));
            same_lists(judgement, *in, openmp.neighbours, serial.neighbours);
            if (in->scene.holds.lattice_density) check_lattice_density(judgement, in->truth, openmp.density);
            return judgement;
          },
      .work = {n, "particles", 16 * n, 8 * in->tested_pairs + 5 * in->near_pairs,
               lanes_in_use(numbers_of_candidates(f, openmp))},
      .restore = restore,
  });
}

Form form(const char* name, bool order_dependent, Densities<float>* twin, Densities<float>* openmp) {
  return {.name = name,
          .make = [=](auto& path) { return densities_case(path, twin, openmp); },
          .scenes = scenes_with(),
          .order_dependent = order_dependent};
}

const Register densities{
    {.name = "fluid/densities",
     .place = 2,
     .serial_forms = {"symmetric", "owner_gather", "pair_lists"},
     .forms = {form("owner_gather", false, serial::densities_owner_gather, openmp::densities_owner_gather),
               form("pair_lists", false, serial::densities_pair_lists, openmp::densities_pair_lists),
               form("sub_grid", true, serial::densities_symmetric, openmp::densities_sub_grid),
               form("cell_locks", true, serial::densities_symmetric, openmp::densities_cell_locks)}}};

}  // namespace
}  // namespace lockstep::verify::fluid_densities
