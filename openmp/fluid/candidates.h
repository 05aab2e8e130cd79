// The candidates of a cell, packed: what may lie within h of its particles, copied from up to nine runs into one. No serial
// twin: a serial loop reads the runs where they are.
//
// The runs of a cell hold about 15 particles each, so lanes that walked them one by one would end nine times in a part-filled
// vector. Packed once, the candidates serve all particles of the cell as full vectors, from the first-level cache.
#pragma once

#include <cstdint>
#include <limits>

#include "common/fluid/grid.h"
#include "common/simd.h"

namespace lockstep::fluid::openmp {

// One a thread; its arrays grow as needed and are kept from cell to cell.
struct Candidates {
  Array<float> x, y, z;
  Array<std::int32_t> index;
  int count = 0;

  // What fills up the last vector: no comparison with it is true, so it is within h of no particle, wherever that is.
  static constexpr float nowhere = std::numeric_limits<float>::quiet_NaN();

  struct Pointers {
    const float *x, *y, *z;
    const std::int32_t* index;
    int count;
  };
  Pointers pointers() const { return {x.data(), y.data(), z.data(), index.data(), count}; }

  void pack(const Runs& runs, const Vectors<float>& position) {
    count = 0;
    for (const Run& run : runs) count += run.end - run.begin;
    if (x.size() < padded(count)) {
      for (Array<float>* component : {&x, &y, &z}) component->resize(2 * padded(count));
      index.resize(2 * padded(count));
    }
    float *to_x = x.data(), *to_y = y.data(), *to_z = z.data();
    std::int32_t* to_index = index.data();
    const float *from_x = position.x.data(), *from_y = position.y.data(), *from_z = position.z.data();
    int k = 0;
    for (const Run& run : runs) {
      // Whole vectors: what is written beyond a run is overwritten by the next one.
      for (int j = run.begin; j < run.end; j += lanes) {
        const int to = k + j - run.begin;
        store(to_x + to, load(from_x + j));
        store(to_y + to, load(from_y + j));
        store(to_z + to, load(from_z + j));
        store(to_index + to, lane_index() + j);
      }
      k += run.end - run.begin;
    }
    store(&x[count], floatv(nowhere));
    store(&y[count], floatv(nowhere));
    store(&z[count], floatv(nowhere));
  }
};

}  // namespace lockstep::fluid::openmp
