// Orders in which the threads of a team go through the parts of skewed vectors in a triangular solve: of one factor
// (Whole), and of a factor a block (InBlocks). Every thread of the team must call them.
//
//   ascending(f)       calls f(part, next, coupled) for each part, after all parts with neighbours along -x, -y and -z
//                      that count. `next` is the part that the thread takes next, to be prefetched.
//   descending(f, g)   calls f in the opposite order. Calls g(part, next) for each part, from the last of a tile to the
//                      first; or for each tile as a whole. By then f is done with all parts that hold neighbours, and
//                      with those that read this part in a solve.
//
// No serial twin: serial code goes through cells in their order.
#pragma once

#include <omp.h>

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "common/real.h"
#include "common/simd.h"
#include "openmp/production_fluid/skewed.h"

namespace lockstep::production_fluid::openmp {

static_assert(side_of_a_block == lanes && side_of_a_block % depth == 0);

// Whether neighbours beyond a part's tile and planes count in the factor.
struct Coupled {
  bool y, low_z, high_z;
  Coupled of_plane(int k) const { return {y, k > 0 || low_z, k < depth - 1 || high_z}; }
};

// One factor of all cells, stage after stage. Parts of a stage do not wait for one another, and each writes its own
// cells; the barrier at the end of a stage makes what its parts wrote visible to the next.
struct Whole {
  const Skewed& skewed;

  template <class F>
  void ascending(const F& f) const {
    const std::ptrdiff_t count = std::ssize(skewed.stages());
    for (std::ptrdiff_t s = 0; s < count; ++s) {
      my_parts(s, s + 1, [&](const Stretch& part, const Stretch& next) { f(part, next, Coupled{true, true, true}); });
#pragma omp barrier
    }
  }
  template <class F, class G>
  void descending(const F& f, const G& g) const {
    const std::ptrdiff_t count = std::ssize(skewed.stages());
    // f works on stage s, and reads up to stage s + stages_between. g works on the first stage that f no longer reads.
    // It reads stages_between further on both sides, where f is done.
    for (std::ptrdiff_t s = count - 1; s >= -behind; --s) {
      my_parts(s + behind, s + behind - 1, g);
      my_parts(s, s - 1, [&](const Stretch& part, const Stretch& next) { f(part, next, Coupled{true, true, true}); });
#pragma omp barrier
    }
  }

 private:
  static constexpr std::ptrdiff_t behind = stages_between + 1;

  // The calling thread's parts of a stage; none if there is no such stage.
  std::span<const Stretch> mine(std::ptrdiff_t stage) const {
    if (stage < 0 || stage >= std::ssize(skewed.stages())) return {};
    const std::span<const Stretch> parts = skewed.stages()[stage];
    const std::size_t thread = omp_get_thread_num(), threads = omp_get_num_threads();
    const std::size_t begin = parts.size() * thread / threads, end = parts.size() * (thread + 1) / threads;
    return parts.subspan(begin, end - begin);
  }

  // Calls f(part, next) for them; the thread goes on with stage `then`.
  template <class F>
  void my_parts(std::ptrdiff_t stage, std::ptrdiff_t then, const F& f) const {
    const std::span<const Stretch> parts = mine(stage), later = mine(then);
    for (std::size_t k = 0; k < parts.size(); ++k)
      f(parts[k], k + 1 < parts.size() ? parts[k + 1] : later.empty() ? parts[k] : later[0]);
  }
};

// A factor a block.
struct InBlocks {
  const Skewed& skewed;

  template <class F>
  void ascending(const F& f) const {
    of_blocks([&](const std::vector<Stretch>& block) {
      for (std::size_t k = 0; k < block.size(); ++k)
        f(block[k], block[std::min(k + 1, block.size() - 1)], coupled(block[k]));
    });
  }
  template <class F, class G>
  void descending(const F& f, const G& g) const {
    of_blocks([&](const std::vector<Stretch>& block) {
      for (std::size_t k = block.size(); k-- > 0;) f(block[k], block[k > 0 ? k - 1 : 0], coupled(block[k]));
    });
    const std::vector<Stretch>& tiles = skewed.tiles();
    const std::ptrdiff_t count = std::ssize(tiles);
    // All blocks are done. g writes its tile alone, and not what it reads of others.
#pragma omp for schedule(static)
    for (std::ptrdiff_t k = 0; k < count; ++k) g(tiles[k], tiles[std::min(k + 1, count - 1)]);
  }

 private:
  static Coupled coupled(const Stretch& part) {
    return {false, part.z % side_of_a_block > 0, (part.z + depth) % side_of_a_block > 0};
  }
  template <class F>
  void of_blocks(const F& f) const {
    const std::ptrdiff_t count = std::ssize(skewed.blocks());
    // Blocks do not read what others write, and each writes its own cells.
#pragma omp for schedule(dynamic)
    for (std::ptrdiff_t k = 0; k < count; ++k) f(skewed.blocks()[k]);
  }
};

// Neighbours that count; those along x are given. A solve has just found them: they need not come back from memory.
LOCKSTEP_INLINE floatv low_y(const Skewed& skewed, const Real* at, floatv low_x, const Coupled& coupled) {
  return shift_up(low_x, coupled.y ? at[skewed.to_low_tile() + lanes - 1] : 0.f);
}
LOCKSTEP_INLINE floatv high_y(const Skewed& skewed, const Real* at, floatv high_x, const Coupled& coupled) {
  return shift_down(high_x, coupled.y ? at[skewed.to_high_tile()] : 0.f);
}
LOCKSTEP_INLINE floatv low_z(const Skewed& skewed, const Real* at, const Coupled& coupled) {
  return coupled.low_z ? low_z(skewed, at) : floatv(0.f);
}
LOCKSTEP_INLINE floatv high_z(const Skewed& skewed, const Real* at, const Coupled& coupled) {
  return coupled.high_z ? high_z(skewed, at) : floatv(0.f);
}

}  // namespace lockstep::production_fluid::openmp
