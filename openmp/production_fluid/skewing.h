// Values of cells, in their own order (system.h), to the order of skewed.h and back.
//
// No serial twin: serial vectors are in the order of the cells.
#pragma once

#include <algorithm>
#include <span>

#include "common/array.h"
#include "common/simd.h"
#include "common/simd_double.h"
#include "openmp/production_fluid/skewed.h"

namespace lockstep::production_fluid::openmp {

// What lane l of vectors s .. s + 15 of a tile stands for: sixteen cells of a plane; the first stands at `at` in
// bordered arrays, and those from `begin` to `end` - 1 are in the plane.
struct Sixteen {
  std::ptrdiff_t at;
  int begin, end;
};
inline Sixteen cells_of(const Bordered& cells, int tile, int s, int l) {
  const int z = tile * lanes + l, cell = s - l, begin = std::max(-cell, 0),
            rest = static_cast<int>(cells.plane()) - cell;
  return {static_cast<std::ptrdiff_t>(cells.index(0, -1, z)) + cell, begin,
          z < cells.nz ? std::min(rest, lanes) : begin};
}

// Fills a part with values of its cells: value(i) of the sixteen at i, all loaded from bordered arrays.
template <class Value>
void fill(const Skewed& skewed, const Stretch& part, std::span<Real> to, const Value& value) {
  for (int s = part.begin; s < part.end; s += lanes) {
    floatv square[lanes];
    for (int l = 0; l < lanes; ++l) {
      const auto [at, begin, end] = cells_of(skewed.cells(), part.tile, s, l);
      square[l] = begin < end ? select(first_lanes(end) & ~first_lanes(begin), value(at), 0.f) : floatv(0.f);
    }
    transpose(square);
    for (int k = 0; k < std::min(lanes, part.end - s); ++k) store(&to[skewed.at(part.tile, s + k)], square[k]);
  }
}

// Adds the values of a part to those of its cells in a bordered array, and leaves 0.
inline void move(const Skewed& skewed, const Stretch& part, std::span<Real> from, Array<double>& to) {
  for (int s = part.begin; s < part.end; s += lanes) {
    const int count = std::min(lanes, part.end - s);
    floatv square[lanes];
    for (int k = 0; k < count; ++k) {
      Real* const at = &from[skewed.at(part.tile, s + k)];
      square[k] = load(at);
      store(at, floatv(0.f));
    }
    for (int k = count; k < lanes; ++k) square[k] = 0.f;
    transpose(square);
    for (int l = 0; l < lanes; ++l) {
      auto [at, begin, end] = cells_of(skewed.cells(), part.tile, s, l);
      end = std::min(end, count);
      if (end - begin == lanes) {
        store(&to[at], load(&to[at]) + to_double(square[l]));
      } else {  // other threads may write to what stands beside
        Real sixteen[lanes];
        store(sixteen, square[l]);
        for (int k = begin; k < end; ++k) to[at + k] += sixteen[k];
      }
    }
  }
}

}  // namespace lockstep::production_fluid::openmp
