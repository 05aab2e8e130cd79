// The candidates of a cell, packed: what may lie within h of its particles, copied from up to nine runs into one. No serial
// twin: a serial loop reads the runs where they are.
//
// The runs of a cell hold about 15 particles each, so lanes that walked them one by one would end nine times in a part-filled
// vector. Packed once, the candidates serve all particles of the cell as full vectors, from the first-level cache.
#pragma once




#include <array>

#include "common/fluid/grid.h"
#include "common/simd.h"

namespace lockstep::fluid::openmp {

// The position of padding: farther from any particle than h, and its square still finite.
inline constexpr float far_away = 1e10f;

// `fields` arrays side by side; room grows as needed and is kept from cell to cell. One a thread.
template <int fields>
struct Candidates {
  std::array<Array<float>, fields> field;
  int count = 0;

  // Copies the runs of each source array. What fills up the last vector is `padding[f]`.
  void pack(const Runs& runs, const std::array<const float*, fields>& source, const std::array<float, fields>& padding) {
    count = 0;
    for (const Run& run : runs) count += run.end - run.begin;
    for (Array<float>& f : field)
      if (f.size() < padded(count)) f.resize(2 * padded(count));
    int k = 0;
    for (const Run& run : runs) {
      // Whole vectors: what is written beyond a run is overwritten by the next one.
      for (int j = run.begin; j < run.end; j += lanes)
        for (int f = 0; f < fields; ++f) store(&field[f][k + j - run.begin], load(source[f] + j));
      k += run.end - run.begin;
    }
    for (int f = 0; f < fields; ++f) store(&field[f][count], floatv(padding[f]));
  }
};

}  // namespace lockstep::fluid::openmp
