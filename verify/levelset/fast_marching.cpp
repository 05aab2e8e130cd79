// The Fast Marching Method, as the verifier and the benchmark see it: blocks are bitwise with their serial twin.
// Whether they find the distances of the undivided grid is asked in a form of its own, `blocks_for_heap`.
#include "common/levelset/fast_marching.h"

#include "common/levelset/blocks.h"
#include "verify/levelset/inputs.h"

namespace lockstep::verify::levelset_fast_marching {
namespace {

using namespace levelset;
using namespace levelset_inputs;

Change heap(const Inputs& in) {
  return [band = in.band](Distances<float>& d) { serial::fast_marching_heap(d, band); };
}
Change in_blocks(FastMarchingInBlocks<float>* marching, const Inputs& in) {
  return [marching, band = in.band](Distances<float>& d) { marching(d, band, block_size); };
}

Case blocks_case(const std::string& path) {
  const auto in = inputs(path);
  return bitwise_case(in, in_blocks(serial::fast_marching_blocks, *in), heap(*in),
                      in_blocks(openmp::fast_marching_blocks, *in), 3 * flops_of_upwind);
}

Case blocks_for_heap_case(const std::string& path) {
  const auto in = inputs(path);
  return same_distances_case(in, heap(*in), in_blocks(openmp::fast_marching_blocks, *in), overlap(*in));
}

const Register fast_marching{
    {.name = "levelset/fast_marching",
     .place = 2,
     .serial_forms = {"heap", "blocks"},
     .forms = {{.name = "blocks", .make = blocks_case, .scenes = scenes_in_bands({"spheres_and_box_256"})},
               {.name = "blocks_for_heap",
                .make = blocks_for_heap_case,
                .scenes = without_tsan(scenes_in_bands({})),
                .covered_by = "blocks"}}}};

}  // namespace
}  // namespace lockstep::verify::levelset_fast_marching
