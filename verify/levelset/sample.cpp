// Trilinear samples, as the verifier and the benchmark see them: of a scene's phi, at positions as semi-Lagrangian
// advection asks for them, up to two spacings from where a point is, some of them outside the grid. Bitwise with the
// serial twin.
#include "common/levelset/sample.h"

#include <array>
#include <cstdint>

#include "common/levelset/scene.h"
#include "verify/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::levelset_sample {

// What the kernel changes.
struct Samples {
  int count = 0;
  Array<float> value;
};
template <Same<Samples> S, class F>
void for_each_array(S& samples, const F& f) {
  f("value", samples.value, samples.count);
}

namespace {

using namespace levelset;

struct Question {
  Field<float> phi;
  int count = 0;
  Vectors<float> position;
};
template <Same<Question> Q, class F>
void for_each_array(Q& question, const F& f) {
  f("phi", question.phi.value, question.phi.value.size());
  f("position", question.position, question.count);
}

constexpr int most_positions = 1 << 20;

Question make_question(const std::string& path) {
  Question question{.phi = load_scene(path).phi, .count = 0, .position = {}};
  const Field<float>& phi = question.phi;
  const std::int64_t points = std::int64_t(phi.nx) * phi.ny * phi.nz,
                     stride = (points + most_positions - 1) / most_positions;
  question.count = static_cast<int>((points + stride - 1) / stride);
  question.position.resize(question.count);
  std::uint32_t state = 1;
  const auto away = [&] {  // -2 .. 2 spacings
    state = state * 1664525u + 1013904223u;
    return static_cast<float>(state >> 8) * 0x1p-22f - 2;
  };
  for (int i = 0; i < question.count; ++i) {
    const std::int64_t point = i * stride;
    question.position.x[i] = phi.spacing * (static_cast<float>(point % phi.nx) + away());
    question.position.y[i] = phi.spacing * (static_cast<float>(point / phi.nx % phi.ny) + away());
    question.position.z[i] = phi.spacing * (static_cast<float>(point / phi.nx / phi.ny) + away());
  }
  return question;
}

Case sample_case(const std::string& path) {
  const auto in = inputs<Question>(path, [&] { return make_question(path); });
  Samples start{in->count, Array<float>(padded(in->count))};
  poison(start);
  const auto with = [in](Sample<float>* sample) {
    return [in, sample](Samples& s) { sample(in->phi, in->count, in->position, s.value); };
  };
  const double n = in->count;
  return make_case<Samples>({
      .start = std::make_shared<const Samples>(start),
      .serial = with(serial::sample),
      .best_serial = nullptr,
      .openmp = with(openmp::sample),
      .compare = nullptr,
      .work = {n, "samples", 16 * n + 4 * double(in->phi.nx) * in->phi.ny * in->phi.nz, 33 * n,
               lanes_in_use(std::array{n})},
  });
}

const Register sample{{.name = "levelset/sample",
                       .place = 4,
                       .forms = {{.make = sample_case,
                                  .scenes = {.verify = {"slab_33", "spheres_and_box_64", "mesh_96", "torus_128"},
                                             .more = {"spheres_and_box_128", "spheres_and_box_256"},
                                             .bench = {"torus_128"},
                                             .tsan = {"slab_33"}}}}}};

}  // namespace
}  // namespace lockstep::verify::levelset_sample
