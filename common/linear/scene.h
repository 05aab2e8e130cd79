// Scenes of linear algebra: a matrix, and how to solve with it. scenes/README.md has every key of the TOML,
// scenes/linear/ examples.
#pragma once

#include <string>

#include "common/linear/conjugate_gradients.h"
#include "common/linear/incomplete_cholesky.h"
#include "common/linear/matrix.h"

namespace lockstep::linear {

struct Scene {
  std::string name;  // the file's, without folder and extension
  std::string path;
  Rows<float> rows;
  BlockRows<float> blocks;  // the same matrix, where it comes in blocks; else of no rows
  bool solvable;            // symmetric, with a positive diagonal: conjugate gradients may be tried
  Array<float> b;           // a right-hand side: random numbers from -1 to 1, the same on every machine
  Stop stop;
  Modification modification;
};

// Reads a TOML scene. Throws InputError in one line, `file:line:column: what was expected`, where the file cannot be
// read, is not what scenes/README.md says, or does not fit the machine's memory, asked before the matrix is made;
// likewise where a Matrix Market file is refused.
Scene load_scene(const std::string& path);

}  // namespace lockstep::linear
