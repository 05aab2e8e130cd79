// Zeros, written by all threads.
#pragma once

#include <cstddef>

#include "common/array.h"
#include "common/linear/dot.h"
#include "common/production_fluid/pressure_memory.h"

namespace lockstep::production_fluid::openmp {

// Threads share arrays of at least this many blocks of a dot product. On smaller arrays the barrier would cost more.
inline constexpr std::ptrdiff_t blocks_to_share = 16;

template <class T>
void fill_with_zeros(Array<T>& array) {
  const std::ptrdiff_t n = std::ssize(array);
  T* const to = array.data();
  // An iteration writes its own element.
#pragma omp parallel for simd schedule(static) if (n >= blocks_to_share * linear::dot_block)
  for (std::ptrdiff_t i = 0; i < n; ++i) to[i] = 0;
}

// Room for n zeros.
inline Array<float> take_zeros(PressureMemory<float>& memory, std::size_t n) {
  return memory.take_zeros(n, fill_with_zeros<float>);
}

}  // namespace lockstep::production_fluid::openmp
