// The guess that a solve for the pressure begins with.
//
// Threads share the lines, and lanes take cells that stand side by side. The serial form is
// serial/production_fluid/guess.h.
//
// The contract stands in common/production_fluid/pressure_solve.h.
#pragma once

#include <functional>
#include <utility>

#include "common/production_fluid/pressure_solve.h"
#include "openmp/production_fluid/zeros.h"

namespace lockstep::production_fluid::openmp {

inline void make_guess(const System<float>& system, double factor, const Array<double>& before, Array<double>& q) {
  const std::ptrdiff_t along_y = system.cells.line(), along_z = system.cells.plane();
  // A line writes its own cells of q, and reads arrays that none changes.
#pragma omp parallel for collapse(2) schedule(static) if (system.cells.size() >= blocks_to_share * linear::dot_block)
  for (int z = 0; z < system.cells.nz; ++z)
    for (int y = 0; y < system.cells.ny; ++y)
      for_each_run_of_line(system, y, z, [&](std::size_t first, int count, int) {
        const float *const diagonal = &system.diagonal[first], *const right = &system.right[first];
        const double* const from = &before[first];
        double* const to = &q[first];
        // An iteration writes its own element.
#pragma omp simd
        for (int k = 0; k < count; ++k)
          to[k] = guess_of_row(diagonal + k, right + k, from + k, factor, along_y, along_z);
      });
}

// What sets q to the guess or to 0 (System::start in common/linear/conjugate_gradients.h); empty where there is no
// guess. q becomes 0.
inline std::function<void(bool)> start_of(const System<float>& system, double factor, PressureMemory<float>& memory,
                                          Array<double>& q) {
  const std::size_t size = system.cells.size();
  const bool is_guess = factor != 0 && q.size() == size;
  std::swap(q, memory.before);
  q.resize(size), fill_with_zeros(q);
  if (!is_guess) return nullptr;
  return [&system, factor, &memory, &q](bool to_guess) {
    if (to_guess)
      make_guess(system, factor, memory.before, q);
    else
      fill_with_zeros(q);
  };
}

}  // namespace lockstep::production_fluid::openmp
