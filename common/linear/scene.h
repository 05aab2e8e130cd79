// Scenes of linear algebra (scenes/linear/ has examples): a matrix, and how to solve with it.
//
//   kind = "linear"             # required
//   tolerance = 1e-6            # of conjugate gradients: |r| / |b|, 1e-12 .. .1
//   iterations = 2000           # at most, 1 .. 1,000,000
//   tau = 0.97                  # of incomplete Cholesky: the share of dropped fill that the diagonal takes, 0 .. 1
//
//   [poisson]                   # one of the three: the pressure in a tank with a ball in it (common/linear/make.h)
//   cells = 64                  # required, a side, 1 .. 512
//   hole = 0.25                 # the ball's radius in sides of the tank, 0 .. .49
//
//   [elasticity]                # an elastic block, held on one side, in 3x3 blocks (common/linear/make.h)
//   points = 24                 # required, a side, 2 .. 128
//
//   [file]                      # a matrix of your own
//   matrix = "bar.mtx"          # required: Matrix Market, beside the scene (common/linear/matrix_market.h)
//
// Values shown at the top level, and hole, are the defaults.
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
// read, is not what is written above, or does not fit the machine's memory, asked before the matrix is made; likewise
// where a Matrix Market file is refused.
Scene load_scene(const std::string& path);

}  // namespace lockstep::linear
