// The step of several cloths, as the verifier and the benchmark see it: bitwise for one step and for a whole run, whose
// every step is also asked what verify/cloth/run.h says. Timed is one step.
#include "common/cloth/cloths.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "common/cloth/make.h"
#include "verify/cloth/inputs.h"
#include "verify/cloth/run.h"
#include "verify/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::cloth_cloths {
namespace {

using namespace cloth;
using namespace cloth_inputs;

struct Cloths {
  std::vector<Cloth<float>> all;
};
template <Same<Cloths> C, class F>
void for_each_array(C& cloths, const F& f) {
  for (std::size_t k = 0; k < cloths.all.size(); ++k)
    for_each_array(cloths.all[k], [&](const char* name, auto& array, std::size_t count) {
      f(("cloth " + std::to_string(k) + " " + name).c_str(), array, count);
    });
}

constexpr int settling_steps = 30;

struct Start {
  Scene scene;
  Cloths first, settled;
};

// For the cache.
double bytes_of(const Start& start) {
  double bytes = 0;
  for (const Cloth<float>& cloth : start.first.all)
    bytes += 4 * (2 * lockstep::bytes_of(cloth) + 60. * cloth.constraints.count);  // in float twice, and in double
  return bytes;
}

std::shared_ptr<const Start> start_of(const std::string& path) {
  return verify::inputs<Start>(path + " cloths", [&] {
    Start start = {load_scene(path), {}, {}};
    start.first.all.push_back(convert<float>(start.scene.cloth));
    for (const Cloth<double>& other : start.scene.others) start.first.all.push_back(convert<float>(other));
    start.settled = start.first;
    for (int k = 0; k < settling_steps; ++k)
      settles_by_openmp ? openmp::step_cloths(start.settled.all) : serial::step_cloths(start.settled.all);
    return start;
  });
}

void check_run(Judgement& judgement, const Start& start) {
  Cloths found = start.first, expected = start.first;
  for (int frame = 1; frame <= start.scene.frames; ++frame) {
    openmp::step_cloths(found.all), serial::step_cloths(expected.all);
    for (const Cloth<float>& cloth : found.all) {
      const std::string fault = fault_of(start.scene.bodies, cloth);
      if (fault.empty()) continue;
      judgement.passed = false;
      judgement.worst_at =
          fault + " of cloth " + std::to_string(&cloth - found.all.data()) + " after step " + std::to_string(frame);
      return;
    }
  }
  same_bits(judgement, found, expected, of_element("particle"));
}

Case cloths_case(const std::string& path) {
  const auto start = start_of(path);
  double particles = 0, projected = 0, flops = 0;
  for (const Cloth<float>& cloth : start->first.all) {
    particles += free_particles(cloth);
    projected += cloth.model.substeps * projections(cloth);
    flops += cloth.model.substeps * verlet_flops(cloth);
  }
  return make_case<Cloths>({
      .start = {start, &start->settled},
      .serial = [](Cloths& cloths) { serial::step_cloths(cloths.all); },
      .best_serial = nullptr,
      .openmp = [](Cloths& cloths) { openmp::step_cloths(cloths.all); },
      .compare =
          [start](const Cloths& found, const Cloths& expected) {
            Judgement judgement = bitwise(found, expected, of_element("particle"));
            if (judgement.passed) check_run(judgement, *start);
            return judgement;
          },
      .work = {projected, "projections", 52 * particles, flops + flops_of_projection * projected},
  });
}

const Register cloths{
    {.name = "cloth/cloths",
     .place = 5,
     .forms = {
         {.make = cloths_case,
          .scenes = {.verify = {"washing_line"}, .more = {"flags_64"}, .bench = {"flags_64"}, .tsan = {"washing_line"}},
          .takes = [](const std::string& path) { return !has_one_cloth(path); }}}}};

}  // namespace
}  // namespace lockstep::verify::cloth_cloths
