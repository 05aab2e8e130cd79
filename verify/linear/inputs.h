// Scenes of linear algebra as the kernels find them.
#pragma once

#include <memory>
#include <string>

#include "common/arrays.h"
#include "common/linear/scene.h"
#include "verify/kernel.h"

namespace lockstep::verify::linear_inputs {

struct Inputs {
  linear::Scene scene;
  Array<float> x;  // of the matrix's columns, for products: random numbers from -1 to 1
  linear::SlicedRows sliced;
  linear::SlicedBlockRows sliced_blocks;
};
std::shared_ptr<const Inputs> inputs(const std::string& path);

// A matrix that can be solved with, its rows numbered by levels, and its factor.
struct Factored {
  linear::Levels levels;
  linear::Rows<float> rows;
  linear::SlicedRows sliced;
  linear::Factor<float> factor;  // by the serial text
  linear::SlicedFactor sliced_factor;
  Array<float> b;
};
std::shared_ptr<const Factored> factored(const std::string& path);

// What kernels change: vectors and numbers.
struct State {
  Array<float> x, y;
  Array<double> number;
};
template <Same<State> S, class F>
void for_each_array(S& state, const F& f) {
  f("x", state.x, state.x.size());
  f("y", state.y, state.y.size());
  f("number", state.number, state.number.size());
}

// Whether the scene can be solved with conjugate gradients; whether it comes in blocks.
bool is_solvable(const std::string& path);
bool has_blocks(const std::string& path);

inline constexpr float unwritten = -1e30f;  // what results hold before a run

}  // namespace lockstep::verify::linear_inputs
