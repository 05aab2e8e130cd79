// Orders in which the threads of a team go through the parts of skewed vectors in a triangular solve: of one factor
// (Whole), and of a factor a block (InBlocks). Every thread of the team must call them.
//
//   ascending(f)    calls f(part) for each part, after all parts with neighbours along -x, -y and -z that count.
//   descending(f)   calls f(part, ready). `part` comes in the opposite order. `ready` is a part whose turn as `part` is
//                   over, as are the turns of all that hold its neighbours, and of those that read it in a solve. Each
//                   part comes once as `part` and once as `ready`, by tile in the opposite order. Either may be empty.
//
// No serial twin: serial code goes through cells in their order.
#pragma once

#include <omp.h>

#include <algorithm>
#include <cstddef>
#include <ranges>
#include <span>
#include <vector>

#include "openmp/production_fluid/skewed.h"

namespace lockstep::production_fluid::openmp {

// One factor of all cells, stage after stage. Parts of a stage do not wait for one another, and each writes its own
// cells; the barrier at the end of a stage makes what its parts wrote visible to the next.
struct Whole {
  const Skewed& skewed;

  static constexpr bool are_tiles_coupled = true;

  template <class F>
  void ascending(const F& f) const {
    const std::ptrdiff_t count = std::ssize(skewed.stages());
    for (std::ptrdiff_t s = 0; s < count; ++s) {
      for (const Stretch& part : mine(s)) f(part);
#pragma omp barrier
    }
  }
  template <class F>
  void descending(const F& f) const {
    // While `part` is of stage s, its solve reads up to stage s + stages_between. `ready` is of the first stage that it
    // does not read. Neighbours of `ready` are stages_between further on both sides, where all solves are over.
    const std::ptrdiff_t count = std::ssize(skewed.stages()), behind = skewed.stages_between() + 1;
    for (std::ptrdiff_t s = count - 1; s >= -behind; --s) {
      const std::span<const Stretch> parts = mine(s), ready = mine(s + behind);
      for (std::size_t k = 0; k < std::max(parts.size(), ready.size()); ++k)
        f(k < parts.size() ? parts[k] : Stretch{}, k < ready.size() ? ready[k] : Stretch{});
#pragma omp barrier
    }
  }

 private:
  // The calling thread's parts of a stage; none if there is no such stage.
  std::span<const Stretch> mine(std::ptrdiff_t stage) const {
    if (stage < 0 || stage >= std::ssize(skewed.stages())) return {};
    const std::span<const Stretch> parts = skewed.stages()[stage];
    const std::size_t thread = omp_get_thread_num(), threads = omp_get_num_threads();
    const std::size_t begin = parts.size() * thread / threads, end = parts.size() * (thread + 1) / threads;
    return parts.subspan(begin, end - begin);
  }
};

// A factor a tile. Tiles do not read what others write, and each writes its own cells.
struct InBlocks {
  const Skewed& skewed;

  static constexpr bool are_tiles_coupled = false;

  template <class F>
  void ascending(const F& f) const {
#pragma omp for schedule(dynamic)
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
#pragma omp for schedule(dynamic)
    for (int tile = 0; tile < skewed.tiles(); ++tile)
      for (const Stretch& part : std::views::reverse(skewed.parts(tile))) f(part);
  }
};

}  // namespace lockstep::production_fluid::openmp
