// The order of triangular solves with a factor of the pressure's system. Whole and InBlocks, its two kinds, have the
// functions
//
//   ascending(f)      calls f(part, coupled) for all parts (skewed.h), each after those that a solve along x, y and z
//                     takes values from
//   descending(f, g)  calls f(part, coupled) for all parts, each after those that a solve backwards takes values from;
//                     and g(part), once f has been called for the part and for all its neighbours, and needs what g
//                     changes no more; both in descending order along a tile
//
// Every thread of a team must call them. Parts that threads work on at once do not read what others of them write.
//
// No serial twin: serial solves go through the cells in order.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "common/production_fluid/pressure_solve.h"
#include "common/simd.h"
#include "openmp/production_fluid/skewed.h"

namespace lockstep::production_fluid::openmp {

// Whether neighbours beyond a tile count in the factor: along y, in the plane before, in the plane after.
struct Coupled {
  bool y, low_z, high_z;
};

// One factor of all cells, stage after stage. The barrier at the end of a stage makes what its parts wrote visible to
// the next.
struct Whole {
  const Skewed& skewed;

  template <class F>
  void ascending(const F& f) const {
    for (const std::vector<Stretch>& parts : skewed.stages()) {
      const std::ptrdiff_t count = std::ssize(parts);
      // Parts of a stage do not wait for one another, and each writes its own cells.
#pragma omp for schedule(static)
      for (std::ptrdiff_t k = 0; k < count; ++k) f(parts[k], all);
    }
  }

  // Neighbours are at most a stage away. So g follows f by two stages: f was called for the stage between them before
  // the last barrier.
  template <class F, class G>
  void descending(const F& f, const G& g) const {
    for (std::ptrdiff_t stage = std::ssize(skewed.stages()) - 1; stage >= -lag; --stage) {
      const std::span<const Stretch> leading = parts_of(stage), following = parts_of(stage + lag);
      const std::ptrdiff_t pairs = std::max(std::ssize(leading), std::ssize(following));
      // Parts of a stage do not wait for one another, nor for those two stages away, and each writes its own cells. In
      // pairs, few threads share both kinds equally, and many can have a part each.
#pragma omp for schedule(static)
      for (std::ptrdiff_t k = 0; k < 2 * pairs; ++k) {
        if (k % 2 == 0 && k / 2 < std::ssize(leading)) f(leading[k / 2], all);
        if (k % 2 == 1 && k / 2 < std::ssize(following)) g(following[k / 2]);
      }
    }
  }

 private:
  static constexpr Coupled all = {true, true, true};
  static constexpr std::ptrdiff_t lag = 2;

  std::span<const Stretch> parts_of(std::ptrdiff_t stage) const {
    if (stage < 0 || stage >= std::ssize(skewed.stages())) return {};
    return skewed.stages()[stage];
  }
};

// A factor a block.
struct InBlocks {
  const Skewed& skewed;

  template <class F>
  void ascending(const F& f) const {
    of_blocks([&](const std::vector<Stretch>& block) {
      for (const Stretch& part : block) f(part, coupled(part));
    });
  }
  template <class F, class G>
  void descending(const F& f, const G& g) const {
    of_blocks([&](const std::vector<Stretch>& block) {
      for (auto part = block.rbegin(); part != block.rend(); ++part) f(*part, coupled(*part));
    });
    of_blocks([&](const std::vector<Stretch>& block) {
      for (const Stretch& part : block) g(part);
    });
  }

 private:
  static Coupled coupled(const Stretch& part) {
    return {false, part.z % side_of_a_block > 0, (part.z + 1) % side_of_a_block > 0};
  }
  template <class F>
  void of_blocks(const F& f) const {
    const std::ptrdiff_t count = std::ssize(skewed.blocks());
    // Blocks do not read what others write, and each writes its own cells.
#pragma omp for schedule(dynamic)
    for (std::ptrdiff_t k = 0; k < count; ++k) f(skewed.blocks()[k]);
  }
};

// Neighbours of the sixteen cells at `at` that count; their neighbours along x are given.
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
