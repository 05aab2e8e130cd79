// The candidates of a cell or a block of cells: the particles that may lie within h of its own, packed from up to nine
// runs into one. No serial twin: a serial loop reads the runs in place.
//
// The runs of a cell hold about 15 particles each, so lanes that walked them one by one would end nine times in a
// part-filled vector. Packed once, the candidates serve all particles of the cell as full vectors, from the first-level
// cache.
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "common/fluid/grid.h"
#include "common/simd.h"

namespace lockstep::fluid::openmp {

// Cells side by side in a row whose particles share candidates, of pair lists.
inline constexpr int block_cells = 2;

// One a thread; its arrays grow as needed and are kept from cell to cell.
struct Candidates {
  Array<float> x, y, z;
  Array<std::int32_t> index;
  Array<float> sum;  // for the caller
  int count = 0;

  // Fills up the last vector. Comparisons with NaN are false, so it is within h of no particle.
  static constexpr float nowhere = std::numeric_limits<float>::quiet_NaN();

  struct Pointers {
    const float *x, *y, *z;
    const std::int32_t* index;
    int count;
  };
  Pointers pointers() const { return {x.data(), y.data(), z.data(), index.data(), count}; }

  // Room for n, and for the vector that is written beyond them. The index grows last: where it has room, all have.
  void make_room(int n) {
    if (index.size() >= padded(n)) return;
    for (Array<float>* component : {&x, &y, &z, &sum}) component->resize(2 * padded(n));
    index.resize(2 * padded(n));
  }

  // Packs those particles of `runs` that are within h of the box around the particles `own`: all that may be within h
  // of one of them. The distance to the box is computed like the distance to a particle, from smaller differences.
  // Rounding is monotonic, so it never comes out larger.
  void pack(const Run& own, const Runs& runs, const Vectors<float>& position, float h2) {
    constexpr float infinite = std::numeric_limits<float>::infinity();
    Vector3<float> low = {infinite, infinite, infinite}, high = {-infinite, -infinite, -infinite};
    int room = 0;
    for (const Run& run : runs) room += run.end - run.begin;
    make_room(room);
    const float *from_x = position.x.data(), *from_y = position.y.data(), *from_z = position.z.data();
    for (int i = own.begin; i < own.end; ++i) {
      low = {std::min(low.x, from_x[i]), std::min(low.y, from_y[i]), std::min(low.z, from_z[i])};
      high = {std::max(high.x, from_x[i]), std::max(high.y, from_y[i]), std::max(high.z, from_z[i])};
    }
    const floatv low_x = low.x, low_y = low.y, low_z = low.z, high_x = high.x, high_y = high.y, high_z = high.z;
    float *to_x = x.data(), *to_y = y.data(), *to_z = z.data();
    std::int32_t* to_index = index.data();
    int k = 0;
    for (const Run& run : runs)
      for (int j = run.begin; j < run.end; j += lanes) {
        const floatv x_j = load(from_x + j), y_j = load(from_y + j), z_j = load(from_z + j);
        const floatv dx = x_j - min(max(x_j, low_x), high_x);
        const floatv dy = y_j - min(max(y_j, low_y), high_y);
        const floatv dz = z_j - min(max(z_j, low_z), high_z);
        const maskv near = first_lanes(run.end - j) & (dx * dx + dy * dy + dz * dz < h2);
        store(to_x + k, compress(near, x_j));
        store(to_y + k, compress(near, y_j));
        store(to_z + k, compress(near, z_j));
        store(to_index + k, compress(near, lane_index() + j));
        k += lockstep::count(near);
      }
    count = k;
    store(&x[count], floatv(nowhere));  // one component is enough
  }
};

}  // namespace lockstep::fluid::openmp
