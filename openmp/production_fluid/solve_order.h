// Orders in which threads go through the parts of skewed vectors in a triangular solve: of one factor (Whole), and of a
// factor a block (InBlocks).
//
//   ascending(f)    calls f(part) for each part, after all parts with neighbours along -x, -y and -z that count.
//   descending(f)   calls f(part, ready). `part` comes in the opposite order. `ready` is a part whose turn as `part` is
//                   over, as are the turns of all that hold its neighbours, and of those that read it in a solve; but
//                   tiles may still read its outer lanes. Each part comes once as `part` and once as `ready`, by tile
//                   in the opposite order. Either may be empty.
//
// f writes what belongs to the part, or to its tile alone. A tile is one thread's.
//
// No serial twin: serial code goes through cells in their order.
#pragma once

#include <omp.h>

#include <algorithm>
#include <vector>

#include "common/flags.h"
#include "openmp/production_fluid/skewed.h"

namespace lockstep::production_fluid::openmp {

// One factor of all cells. A thread has a run of tiles, and goes through them as one wavefront: part k of each tile
// after part k of the tile before. Threads wait for one another by flags, where two runs meet.
struct Whole {
  const Skewed& skewed;

  static constexpr bool are_tiles_coupled = true;

  template <class F>
  void ascending(const F& f) const {
    const int parts = skewed.parts_of_a_tile();
    std::vector<Flag> done(skewed.tiles());  // [tile] parts; set of the last tile of a run
    // A thread works on its own tiles. What it reads of the tile before its first is written before the flag is set.
#pragma omp parallel
    {
      const auto [first, end] = skewed.run_of_tiles(omp_get_thread_num(), omp_get_num_threads());
      for (int front = first; front < end - 1 + parts; ++front)
        for (int tile = std::max(first, front - parts + 1); tile < std::min(end, front + 1); ++tile) {
          const int k = front - tile;
          if (tile == first && tile > 0) await(done[tile - 1], k + 1);
          f(skewed.part(tile, k));
          if (tile == end - 1) post(done[tile], k + 1);
        }
    }
  }

  template <class F>
  void descending(const F& f) const {
    // The product of part k + behind reads parts from k + 1 on, or outer lanes of the tile before from part k + behind
    // - 1 on. The solve of part k reads up to part k + behind - 1.
    const int parts = skewed.parts_of_a_tile(), behind = skewed.parts_between() + 1;
    std::vector<Flag> done(skewed.tiles());  // [tile] parts; set of the first and the last tile of a run
    // A thread works on its own tiles. What it reads of the tiles beside them is written before their flags are set.
#pragma omp parallel
    {
      const auto [first, end] = skewed.run_of_tiles(omp_get_thread_num(), omp_get_num_threads());
      for (int front = end - 2 + parts; front >= first - behind; --front)
        for (int tile = std::min(end - 1, front + behind); tile >= std::max(first, front - parts + 1); --tile) {
          const int k = front - tile, ready = k + behind;
          if (tile == end - 1 && end < skewed.tiles() && k >= 0) await(done[end], parts - k);
          if (tile == first && first > 0 && ready < parts) await(done[first - 1], parts - std::max(ready - 1, 0));
          f(skewed.part(tile, k), skewed.part(tile, ready));
          if ((tile == first || tile == end - 1) && k >= 0) post(done[tile], parts - k);
        }
    }
  }
};

// A factor a tile. Tiles do not read what others write.
struct InBlocks {
  const Skewed& skewed;

  static constexpr bool are_tiles_coupled = false;

  template <class F>
  void ascending(const F& f) const {
    // An iteration writes its own tile.
#pragma omp parallel for schedule(dynamic)
    for (int tile = 0; tile < skewed.tiles(); ++tile)
      for (const Stretch& part : skewed.parts(tile)) f(part);
  }
  template <class F>
  void descending(const F& f) const {
    backward([&](const Stretch& part) { f(part, Stretch{}); });
    backward([&](const Stretch& part) { f(Stretch{}, part); });
  }

 private:
  template <class F>
  void backward(const F& f) const {
    // An iteration writes its own tile.
#pragma omp parallel for schedule(dynamic)
    for (int tile = 0; tile < skewed.tiles(); ++tile)
      for (int k = skewed.parts_of_a_tile() - 1; k >= 0; --k) f(skewed.part(tile, k));
  }
};

}  // namespace lockstep::production_fluid::openmp
