// What a pose makes of each tetrahedron, as the verifier and the benchmark see it: bitwise with the serial twin, with
// the derivative made definite and as it is.
#include "common/production_face/update_state.h"

#include "verify/production_face/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_face_update_state {
namespace {

using namespace production_face;
using namespace production_face_inputs;

// A tetrahedron reads its corners, nine gradients and four nodes, and writes 40 numbers. Six sweeps of three rotations
// take about 900 operations, everything else about as many.
Case make(const std::string& path, bool definite) {
  const auto in = inputs(path);
  Strained<float> start = make_strained(in->body);
  poison(start);
  const double n = in->body.tetrahedra;
  return make_case<Strained<float>>({
      .start = std::make_shared<const Strained<float>>(start),
      .serial = [in,
                 definite](Strained<float>& s) { serial::update_state(in->body, in->flesh, in->pose, definite, s); },
      .best_serial = nullptr,
      .openmp = [in,
                 definite](Strained<float>& s) { openmp::update_state(in->body, in->flesh, in->pose, definite, s); },
      .compare = nullptr,
      .work = {n, "tetrahedra", n * (4 * (4 + 9 + 40) + 12), 1800 * n, n / in->body.padded_tetrahedra()},
  });
}

// A face as its scene begins: at rest, where numbers could become denormal, and slow.
Scenes scenes_of_state() {
  Scenes scenes = body_scenes();
  scenes.bench.push_back("face_381k");
  return scenes;
}

const Register update_state{{.name = "production_face/update_state",
                             .place = 1,
                             .forms = {{.name = "definite",
                                        .make = [](const std::string& path) { return make(path, true); },
                                        .scenes = scenes_of_state()},
                                       {.name = "exact",
                                        .make = [](const std::string& path) { return make(path, false); },
                                        .scenes = scenes_of_state()}}}};

}  // namespace
}  // namespace lockstep::verify::production_face_update_state
