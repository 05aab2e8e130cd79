#include "verify/production_face/inputs.h"

#include <algorithm>
#include <limits>
#include <random>

#include "common/production_face/assemble.h"
#include "common/production_face/update_state.h"
#include "verify/inputs.h"

namespace lockstep::production_face {

inline double bytes_of(const Scene& scene) { return 500. * scene.body.padded_tetrahedra(); }

}  // namespace lockstep::production_face

namespace lockstep::verify::production_face_inputs {

std::shared_ptr<const production_face::Scene> inputs(const std::string& path) {
  return lockstep::verify::inputs<production_face::Scene>(path, [&] { return production_face::load_scene(path); });
}

std::shared_ptr<const production_face::Strained<float>> strained(const std::string& path) {
  return lockstep::verify::inputs<production_face::Strained<float>>(path, [&] {
    const auto in = inputs(path);
    production_face::Strained<float> strained = production_face::make_strained(in->body);
    production_face::serial::update_state(in->body, in->flesh, in->pose, true, strained);
    return strained;
  });
}

namespace {

production_face::Body<float> held_body(const production_face::Body<float>& body) {
  production_face::Body<float> held = body;
  if (held.held.empty())
    for (int n = 0; n < body.nodes; ++n)
      if (body.rest.x[n] == 0) held.held.push_back(n);
  return held;
}

}  // namespace

// For the cache.
double bytes_of(const Problem& p) {
  double coarse = 0;  // numbers
  for (const production_face::CoarseLevel<float>& level : p.coarsening.level) {
    coarse += double(level.of.size() + level.arm.size() + level.member.size() + level.column.size());
    coarse += double(level.i.size() + level.j.size() + level.share.size());
    coarse += double(sizeof level.coupling[0] / sizeof(std::int32_t)) * level.couplings();
  }
  return 4. * (double(p.rows.begin.size() + p.rows.column.size() + p.rows.value.size() + p.b.size()) + coarse) +
         linear::bytes_of(p.sliced);
}

std::shared_ptr<const Problem> problem(const std::string& path) {
  return lockstep::verify::inputs<Problem>(path, [&] {
    const production_face::Body<float> body = held_body(inputs(path)->body);
    const production_face::Pattern pattern = production_face::make_pattern(body);
    Problem p = {production_face::make_block_rows<float>(pattern),
                 {},
                 Array<float>(3 * std::size_t(body.nodes)),
                 0,
                 production_face::make_coarsening(body, pattern)};
    production_face::serial::assemble(body, *strained(path), pattern, p.rows);
    p.sliced = linear::slice(p.rows);
    std::mt19937 random(3);  // whose numbers the standard fixes
    for (int n = 0; n < body.nodes; ++n) {
      if (p.rows.begin[n] == p.rows.begin[n + 1]) continue;
      for (int c = 0; c < 3; ++c)
        p.b[3 * std::size_t(n) + c] = static_cast<float>(static_cast<int>(random() >> 8) - (1 << 23)) / (1 << 23);
      ++p.free_nodes;
    }
    return p;
  });
}

production_face::Waves waves(const production_face::Body<float>& body) {
  return make_waves(body, std::clamp(body.blocks() / 5, 1, 16));
}

std::shared_ptr<Array<float>> poisoned_parts(const production_face::Body<float>& body) {
  const auto parts = std::make_shared<Array<float>>(make_parts(body));
  std::ranges::fill(*parts, std::numeric_limits<float>::quiet_NaN());
  return parts;
}

Scenes body_scenes() {
  return {.verify = {"bar_shaken", "twelve", "inside_out"},
          .more = {"block_370k"},
          .bench = {"block_370k"},
          .tsan = {"bar_shaken", "twelve"}};
}

Scenes moving_scenes() {
  return {.verify = {"bar_pulls", "bar_turns", "crushed", "face_6k"},
          .more = {"face_smile"},
          .bench = {"face_381k"},
          .tsan = {"bar_turns"}};
}

}  // namespace lockstep::verify::production_face_inputs
