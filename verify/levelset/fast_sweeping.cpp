// The Fast Sweeping Method, as the verifier and the benchmark see it: each form is bitwise with its serial twin, after
// the scene's rounds and when nothing changes any more. Whether sweeping until nothing changes finds the distances of
// marching, and blocks those of the undivided grid, is asked in forms of their own, `sweeps_for_heap` and
// `blocks_for_sweeps`.
#include "common/levelset/fast_sweeping.h"

#include <utility>

#include "common/levelset/blocks.h"
#include "common/levelset/fast_marching.h"
#include "verify/levelset/inputs.h"

namespace lockstep::verify::levelset_fast_sweeping {
namespace {

using namespace levelset;
using namespace levelset_inputs;

constexpr int until_nothing_changes = 1000;

using Rounds = std::function<int(Distances<float>&)>;

// A sweeping kernel that must also know when nothing changes any more: after as many rounds as its twin, with the same
// distances.
Case until_nothing_changes_case(std::shared_ptr<const Inputs> in, Case kernel, Rounds twin, Rounds openmp) {
  struct Expected {
    Distances<float> distances;
    int rounds = 0;
  };
  const auto expected = std::make_shared<Expected>();
  kernel.judge = [in, twin, openmp, expected, judge = kernel.judge] {
    Judgement judgement = judge();
    if (expected->rounds == 0) {
      expected->distances = in->start;
      expected->rounds = twin(expected->distances);
    }
    Distances<float> d = in->start;
    const int rounds = openmp(d);
    same_bits(judgement, d, expected->distances, point_name(d.distance));
    if (rounds != expected->rounds) {
      judgement.passed = false;
      judgement.worst_at = both_values("rounds until nothing changes", rounds, expected->rounds);
    }
    return judgement;
  };
  return kernel;
}

// A sweeping kernel for a scene's band and a number of rounds.
Rounds sweeps(FastSweeping<float>* sweeping, const Inputs& in, int rounds) {
  return [sweeping, band = in.band, rounds](Distances<float>& d) { return sweeping(d, band, rounds); };
}
Rounds in_blocks(FastSweepingInBlocks<float>* sweeping, const Inputs& in, int rounds) {
  return [sweeping, band = in.band, rounds](Distances<float>& d) { return sweeping(d, band, rounds, block_size); };
}

Case sweeps_case(const std::string& path) {
  const auto in = inputs(path);
  const int rounds = in->scene.rounds;
  const Case kernel = bitwise_case(in, sweeps(serial::fast_sweeping_sweeps, *in, rounds), nullptr,
                                   sweeps(openmp::fast_sweeping_sweeps, *in, rounds), 8 * flops_of_upwind);
  return until_nothing_changes_case(in, kernel, sweeps(serial::fast_sweeping_sweeps, *in, until_nothing_changes),
                                    sweeps(openmp::fast_sweeping_sweeps, *in, until_nothing_changes));
}

Case sweeps_for_heap_case(const std::string& path) {
  const auto in = inputs(path);
  const Rounds sweep = sweeps(openmp::fast_sweeping_sweeps, *in, until_nothing_changes);
  Distances<float> d = in->start;
  const int rounds = sweep(d);
  return same_distances_case(
      in, [band = in->band](Distances<float>& d) { serial::fast_marching_heap(d, band); }, sweep,
      std::to_string(rounds) + " rounds until nothing changed");
}

Case blocks_case(const std::string& path) {
  const auto in = inputs(path);
  const int rounds = in->scene.rounds;
  const Case kernel = bitwise_case(in, in_blocks(serial::fast_sweeping_blocks, *in, rounds),
                                   sweeps(serial::fast_sweeping_sweeps, *in, rounds),
                                   in_blocks(openmp::fast_sweeping_blocks, *in, rounds), 8 * flops_of_upwind);
  return until_nothing_changes_case(in, kernel, in_blocks(serial::fast_sweeping_blocks, *in, until_nothing_changes),
                                    in_blocks(openmp::fast_sweeping_blocks, *in, until_nothing_changes));
}

Case blocks_for_sweeps_case(const std::string& path) {
  const auto in = inputs(path);
  return same_distances_case(in, sweeps(serial::fast_sweeping_sweeps, *in, until_nothing_changes),
                             in_blocks(openmp::fast_sweeping_blocks, *in, until_nothing_changes), overlap(*in));
}

const Register fast_sweeping{
    {.name = "levelset/fast_sweeping",
     .place = 3,
     .serial_forms = {"sweeps", "blocks"},
     .forms = {{.name = "sweeps",
                .make = sweeps_case,
                .scenes = scenes_of_all({"spheres_and_box_256", "spheres_and_box_256_full"})},
               {.name = "sweeps_for_heap",
                .make = sweeps_for_heap_case,
                .scenes = without_tsan(scenes_of_all({})),
                .covered_by = "sweeps"},
               {.name = "blocks", .make = blocks_case, .scenes = scenes_in_bands({"spheres_and_box_256"})},
               {.name = "blocks_for_sweeps",
                .make = blocks_for_sweeps_case,
                .scenes = without_tsan(scenes_in_bands({})),
                .covered_by = "blocks"}}}};

}  // namespace
}  // namespace lockstep::verify::levelset_fast_sweeping
