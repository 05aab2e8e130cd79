// The guess that a solve for the pressure begins with.
//
// The contract stands in common/production_fluid/pressure_solve.h.
#pragma once

#include <algorithm>
#include <functional>
#include <utility>

#include "common/production_fluid/pressure_solve.h"

namespace lockstep::production_fluid::serial {

template <class Real>
void make_guess(const System<Real>& system, double factor, const Array<double>& before, Array<double>& q) {
  for_each_run(system, [&](std::size_t first, int count, int) {
    for (std::size_t i = first; i < first + count; ++i)
      q[i] = guess_of_row(&system.diagonal[i], &system.right[i], &before[i], factor, system.cells.line(),
                          system.cells.plane());
  });
}

// What sets q to the guess or to 0 (System::start in common/linear/conjugate_gradients.h); empty where there is no
// guess. q becomes 0.
template <class Real>
std::function<void(bool)> start_of(const System<Real>& system, double factor, PressureMemory<Real>& memory,
                                   Array<double>& q) {
  const std::size_t size = system.cells.size();
  const bool is_guess = factor != 0 && q.size() == size;
  std::swap(q, memory.before);
  q.assign(size, 0);
  if (!is_guess) return nullptr;
  return [&system, factor, &memory, &q](bool to_guess) {
    if (to_guess)
      make_guess(system, factor, memory.before, q);
    else
      std::ranges::fill(q, 0);
  };
}

}  // namespace lockstep::production_fluid::serial
