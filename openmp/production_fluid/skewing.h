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

// What lane l of vectors s .. s + 15 of a tile in plane z stands for: sixteen cells of a line; the first stands at `at`
// in bordered arrays, and those from `begin` to `end` - 1 are in the box.
struct Sixteen {
  std::ptrdiff_t at;
  int begin, end;
};
inline Sixteen cells_of(const Bordered& cells, int tile, int z, int s, int l) {
  const int y = tile * lanes + l, x = s - l, begin = std::max(-x, 0);
  const std::ptrdiff_t at = static_cast<std::ptrdiff_t>(cells.index(0, y, z)) + x;
  return {at, begin, y < cells.ny && z < cells.nz ? std::min(cells.nx - x, lanes) : begin};
}

// Calls f(z, s) for each plane of a tile, and each sixteen of its vectors.
template <class F>
void for_each_square(const Stretch& tile, const F& f) {
  for (int z = tile.z; z < tile.z + depth; ++z)
    for (int s = tile.begin; s < tile.end; s += lanes) f(z, s);
}

// Fills a tile with values of its cells: value(i) of the sixteen at i, all loaded from bordered arrays.
template <class Value>
void fill(const Skewed& skewed, const Stretch& tile, std::span<Real> to, const Value& value) {
  for_each_square(tile, [&](int z, int s) {
    floatv square[lanes];
    for (int l = 0; l < lanes; ++l) {
      const auto [at, begin, end] = cells_of(skewed.cells(), tile.tile, z, s, l);
      square[l] = begin < end ? select(first_lanes(end) & ~first_lanes(begin), value(at), 0.f) : floatv(0.f);
    }
    transpose(square);
    for (int k = 0; k < std::min(lanes, tile.end - s); ++k) store(&to[skewed.at(tile.tile, z, s + k)], square[k]);
  });
}

// Adds the values of a tile to those of its cells in a bordered array.
inline void add(const Skewed& skewed, const Stretch& tile, std::span<const Real> from, Array<double>& to) {
  for_each_square(tile, [&](int z, int s) {
    floatv square[lanes];
    for (int k = 0; k < lanes; ++k)
      square[k] = s + k < tile.end ? load(&from[skewed.at(tile.tile, z, s + k)]) : floatv(0.f);
    transpose(square);
    for (int l = 0; l < lanes; ++l) {
      const auto [at, begin, end] = cells_of(skewed.cells(), tile.tile, z, s, l);
      if (end - begin == lanes) {
        store(&to[at], load(&to[at]) + to_double(square[l]));
      } else {  // other threads may write to what stands beside the line
        Real line[lanes];
        store(line, square[l]);
        for (int k = begin; k < end; ++k) to[at + k] += line[k];
      }
    }
  });
}

}  // namespace lockstep::production_fluid::openmp
