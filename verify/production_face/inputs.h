// Scenes of the production face as the kernels find them.
#pragma once

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <string>

#include "common/linear/matrix.h"
#include "common/linear/sliced.h"
#include "common/production_face/coarsening.h"
#include "common/production_face/scene.h"
#include "common/production_face/waves.h"
#include "verify/arrays.h"
#include "verify/kernel.h"

namespace lockstep::verify::production_face_inputs {

std::shared_ptr<const production_face::Scene> inputs(const std::string& path);

// What the scene's pose makes of its body, by the serial update_state, made definite.
std::shared_ptr<const production_face::Strained<float>> strained(const std::string& path);

// K x = b, as in a step of Newton's method: K of the strained body, as both versions hold it, and b 0 at held nodes. A
// body that no bone holds is held by its nodes at x = 0; else K would let it move freely.
struct Problem {
  linear::BlockRows<float> rows;
  linear::SlicedBlockRows sliced;
  Array<float> b;  // random numbers from -1 to 1
  int free_nodes = 0;
  production_face::Coarsening<float> coarsening;  // of the body
};
std::shared_ptr<const Problem> problem(const std::string& path);

// Waves as openmp takes them; of a small body smaller ones: at least five, if it has five blocks.
production_face::Waves waves(const production_face::Body<float>& body);

// Scratch for parts, full of NaN. No reset copies it: its 24 MB, for a large body, would push a run's data out of the
// caches.
std::shared_ptr<Array<float>> poisoned_parts(const production_face::Body<float>& body);

// Compares bit by bit, and fills the parts with NaN again: the next run must not find what this one has stored.
template <class State>
std::function<Judgement(const State&, const State&)> bitwise_and_poison(std::shared_ptr<Array<float>> parts) {
  return [parts](const State& openmp, const State& serial) {
    std::ranges::fill(*parts, std::numeric_limits<float>::quiet_NaN());
    return bitwise(openmp, serial);
  };
}

// Those that all kernels take.
Scenes body_scenes();

// Those whose bones and muscles move.
Scenes moving_scenes();

}  // namespace lockstep::verify::production_face_inputs
