// Scratch of pressure_solve: arrays that a solve leaves to the next one. On grids as large as a frame's, memory that is
// new to the process costs a page fault every 4 KB.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "common/array.h"

namespace lockstep::production_fluid {

template <class Real>
class PressureMemory {
 public:
  // An array of n elements, of any values: an earlier solve may have left it.
  Array<Real> take(std::size_t n) {
    const auto left = std::ranges::find(spare_, n, [](const Array<Real>& array) { return array.size(); });
    if (left == spare_.end()) return Array<Real>(n);
    std::swap(*left, spare_.back());
    Array<Real> array = std::move(spare_.back());
    spare_.pop_back();
    return array;
  }

  // The same, filled with 0.
  Array<Real> take_zeros(std::size_t n) {
    Array<Real> array = take(n);
    std::ranges::fill(array, Real(0));
    return array;
  }

  void give_back(Array<Real>& array) {
    if (!array.empty()) spare_.push_back(std::move(array));
  }

  Array<double> before;  // the q that a guess is made of

 private:
  std::vector<Array<Real>> spare_;
};

}  // namespace lockstep::production_fluid
