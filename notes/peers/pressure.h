// The linear system of the production fluid's pressure, solved by a library and by ours in turn.
#pragma once

#include <functional>
#include <string>

#include "common/linear/matrix.h"
#include "common/production_fluid/pressure_solve.h"
#include "notes/peers/peer.h"

namespace lockstep::peers {

// The system with its unknowns numbered line by line, as they stand in `system`.
struct Problem {
  const production_fluid::System<float>& system;
  linear::Rows<double> matrix;  // both triangles
  Array<double> right;
  double tolerance;  // of |b - A x| / |b|
};

struct Answer {
  Array<double> x;     // [unknown]
  int iterations = 0;  // 0 of a direct solver
  double setup_s = 0;  // of the whole time: hierarchy, factor
};
// Takes over the matrix in the library's own form, which is not timed, and returns what is: setup and solve.
using MakeSolver = std::function<std::function<Answer()>(const Problem& problem, int threads)>;

// A row for each scene and number of threads, ours by this form of pressure_solve. Quality is the true residual, in
// double, of both. `held`: as in Side, of the library.
void compare_solvers(Json& rows, const Asked& asked, const std::string& form,
                     production_fluid::PressureSolve<float>* ours, const MakeSolver& make,
                     const std::string& not_the_same, bool held = false);

}  // namespace lockstep::peers
