// The rows and benchmarks of the uniform grid: pairs bitwise with the serial twin's.
#include "common/rigid/broad_phase.h"
#include "verify/rigid/found_pairs.h"

namespace lockstep::verify::rigid_grid {
namespace {

using namespace rigid;
using namespace rigid_inputs;

Case grid_case(const std::string& path) {
  const auto in = inputs(path);
  const auto with = [&](GridPairs<float>* find) {
    return [in, find](Pairs& pairs) { find(in->now.bounds, in->group(), pairs); };
  };
  return pairs_case(*in, with(serial::grid), with(openmp::grid));
}

const Register grid{
    {.name = "rigid/grid", .place = 4, .forms = {{.make = grid_case, .scenes = scenes_of_all(of_many_bodies)}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_grid
