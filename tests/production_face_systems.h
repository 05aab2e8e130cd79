// What tests of the face's multigrid share: systems of scenes, with their coarse levels, in float and in double.
#pragma once

#include <algorithm>
#include <string>

#include "common/production_face/assemble.h"
#include "common/production_face/multigrid.h"
#include "common/production_face/scene.h"
#include "common/production_face/update_state.h"
#include "tests/linear_matrices.h"

namespace lockstep::production_face {

// K of a scene's strained body; `held` are held besides those that the scene holds.
struct FaceSystem {
  Body<float> body;
  linear::BlockRows<float> k;
  Coarsening<float> coarsening;
  Coarsening<double> coarsening_in_double;
  linear::BlockRows<double> k_in_double;
};

inline Body<double> in_double_places(const Body<float>& body) {
  Body<double> b;
  b.nodes = body.nodes;
  b.rest = {lockstep::convert<double>(body.rest.x), lockstep::convert<double>(body.rest.y),
            lockstep::convert<double>(body.rest.z)};
  return b;
}

FaceSystem system_of(const std::string& name, bool definite, const auto& is_held) {
  Scene scene = load_scene("scenes/production_face/" + name + ".toml");
  FaceSystem s = {scene.body, {}, {}, {}, {}};
  for (int n = 0; n < s.body.nodes; ++n)
    if (is_held(load(s.body.rest, n))) s.body.held.push_back(n);
  std::ranges::sort(s.body.held);
  Strained<float> strained = make_strained(s.body);
  openmp::update_state(s.body, scene.flesh, scene.pose, definite, strained);
  const Pattern pattern = make_pattern(s.body);
  s.k = make_block_rows<float>(pattern);
  serial::assemble(s.body, strained, pattern, s.k);
  s.coarsening = make_coarsening(s.body, pattern);
  s.coarsening_in_double = make_coarsening(in_double_places(s.body), pattern);
  s.k_in_double = linear::convert<double>(s.k);
  return s;
}
inline constexpr auto at_wall_of_bar = [](const Vector3<float>& place) { return place.x == 0; };
inline constexpr auto no_more = [](const auto&) { return false; };

inline FaceSystem system_of(const std::string& name) {
  const bool has_bones = name.starts_with("face");
  return has_bones ? system_of(name, true, no_more) : system_of(name, true, at_wall_of_bar);
}

template <class Real>
Array<Real> random_load(const linear::BlockRows<Real>& k, int seed) {
  Array<Real> b = linear::random_vector<Real>(3 * std::size_t(k.rows), seed);
  for (int i = 0; i < k.rows; ++i)
    if (k.begin[i] == k.begin[i + 1])
      for (int c = 0; c < 3; ++c) b[3 * std::size_t(i) + c] = 0;
  return b;
}

}  // namespace lockstep::production_face
