// Fields of elements, laid out for lanes: sixteen elements are a block, and each field of a block is a vector.
#pragma once

#include <cstddef>

#include "common/array.h"
#include "common/simd.h"

namespace lockstep {

// Field f of element e is value[(e / 16 * fields + f) * 16 + e % 16]. Whole blocks, so the last may hold elements that
// fill it up.
template <class T>
struct Blocked {
  int fields = 0;
  Array<T> value;

  Blocked() = default;
  Blocked(int fields, int blocks) : fields(fields), value(static_cast<std::size_t>(blocks) * fields * lanes) {}

  int blocks() const { return static_cast<int>(value.size() / (static_cast<std::size_t>(fields) * lanes)); }
  T* vector(int block, int field) { return &value[(static_cast<std::size_t>(block) * fields + field) * lanes]; }
  const T* vector(int block, int field) const {
    return &value[(static_cast<std::size_t>(block) * fields + field) * lanes];
  }
  T& at(int element, int field) { return vector(element / lanes, field)[element % lanes]; }
  const T& at(int element, int field) const { return vector(element / lanes, field)[element % lanes]; }
};

}  // namespace lockstep
