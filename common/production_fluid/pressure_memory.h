// Scratch of pressure_solve: arrays that a solve leaves to the next one. On grids as large as a frame's, memory that is
// new to the process costs a page fault every 4 KB.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

#include "common/array.h"

namespace lockstep::production_fluid {

template <class Real>
class PressureMemory {
 public:
  // An array of n elements, of any values: an earlier solve may have left it.
  Array<Real> take(std::size_t n) {
    std::optional<Array<Real>> spare = take_from(spare_, n);
    return spare ? *std::move(spare) : Array<Real>(n);
  }

  // The same, filled with 0.
  Array<Real> take_zeros(std::size_t n) {
    return take_zeros(n, [](Array<Real>& array) { std::ranges::fill(array, Real(0)); });
  }
  // The same; fill(array) sets an array to 0.
  template <class Fill>
  Array<Real> take_zeros(std::size_t n, const Fill& fill) {
    if (std::optional<Array<Real>> zeros = take_from(zeros_, n)) return *std::move(zeros);
    Array<Real> array = take(n);
    fill(array);
    return array;
  }

  void give_back(Array<Real>& array) {
    if (!array.empty()) spare_.push_back(std::move(array));
  }
  // The same for an array whose elements are all 0.
  void give_back_zeros(Array<Real>& array) {
    if (!array.empty()) zeros_.push_back(std::move(array));
  }

  Array<double> before;  // the q that a guess is made of

 private:
  using Arrays = std::vector<Array<Real>>;

  static std::optional<Array<Real>> take_from(Arrays& arrays, std::size_t n) {
    const auto left = std::ranges::find(arrays, n, [](const Array<Real>& array) { return array.size(); });
    if (left == arrays.end()) return std::nullopt;
    std::swap(*left, arrays.back());
    std::optional<Array<Real>> array = std::move(arrays.back());
    arrays.pop_back();
    return array;
  }

  Arrays spare_, zeros_;  // of any values; of zeros
};

}  // namespace lockstep::production_fluid
