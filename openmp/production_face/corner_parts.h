// What tetrahedra give to their nodes, in two passes wave by wave (common/production_face/waves.h): sixteen tetrahedra
// at a time store their parts, then each node adds up its own, in the order of tetrahedra. These are the additions of a
// serial loop over tetrahedra, in its order, and no two threads write to one node.
//
// A thread reads what it has stored itself, except at the nodes where its run of blocks meets the one before. These add
// up when all threads have stored.
#pragma once

#include <omp.h>

#include <algorithm>
#include <bit>
#include <span>

#include "common/production_face/parts.h"
#include "common/production_face/waves.h"
#include "common/simd.h"

namespace lockstep::production_face::openmp {

// Blocks first .. last - 1 of n are one thread's. Their parts have places in an array of all. The first `span` blocks
// keep theirs, because nodes at the border of two runs read them in the end. Those behind share a ring of places, of
// which the last `span` blocks are read in the end, too.
struct Run {
  int first, last;
  int ring, mask;  // of parts: where the ring begins, and its length less one

  // Of the thread that has part `part`.
  int place_of(int part) const { return part < ring ? part : ring + ((part - ring) & mask); }
};

inline constexpr int parts_of_block = 4 * lanes;

inline Run run_of(const Waves& waves, int blocks, int thread, int threads) {
  const auto cut = [&](long long k) { return static_cast<int>(k * blocks / threads); };
  const int first = cut(thread),
            ring = static_cast<int>(std::bit_ceil(static_cast<unsigned>(waves.span + waves.blocks)));
  return {first, cut(thread + 1), parts_of_block * (first + waves.span), parts_of_block * ring - 1};
}

// The run that has part `part`.
inline Run run_with(const Waves& waves, int blocks, int part, int threads) {
  const long long behind = part / parts_of_block + 1;
  return run_of(waves, blocks, static_cast<int>((behind * threads - 1) / blocks), threads);
}

// A tetrahedron's parts are one line of the cache: four numbers a corner, of which the last is 0.
LOCKSTEP_INLINE void store_parts(const Parts<floatv>& part, float* to) {
  const auto& [a, b, c, d] = part.of;
  const floatv zero = 0.f;
  floatv row[lanes] = {a.x, a.y, a.z, zero, b.x, b.y, b.z, zero, c.x, c.y, c.z, zero, d.x, d.y, d.z, zero};
  transpose(row);
  for (int l = 0; l < lanes; ++l) store(to + lanes * l, row[l]);
}

// place_of(part) says where a part is.
template <class PlaceOf>
LOCKSTEP_INLINE void add_up_node(const Waves& waves, const PlaceOf& place_of, const float* parts, int at, float* y) {
  float sum[4] = {0, 0, 0, 0};
  for (int k = waves.first_part[at]; k < waves.first_part[at + 1]; ++k) {
    const float* const part = parts + 4 * static_cast<std::size_t>(place_of(waves.part[k]));
    for (int c = 0; c < 4; ++c) sum[c] += part[c];
  }
  for (int c = 0; c < 3; ++c) y[3 * static_cast<std::size_t>(waves.node[at]) + c] = sum[c];
}

// parts_of(block) are those of sixteen tetrahedra.
template <class PartsOf>
void add_up_parts(const Body<float>& body, const Waves& waves, const PartsOf& parts_of, Array<float>& parts,
                  std::span<float> y) {
  // A block's parts, and a node's components, are written by the thread in whose run the block, or the node's last
  // tetrahedron is. Before the barrier a thread reads parts of its own run alone, and behind it nobody writes parts.
#pragma omp parallel
  {
    const int threads = omp_get_num_threads();
    const Run mine = run_of(waves, body.blocks(), omp_get_thread_num(), threads);
    const auto is_mine = [&](int at) { return waves.part[waves.first_part[at]] >= parts_of_block * mine.first; };
    for (int begin = mine.first; begin < mine.last; begin += waves.blocks) {
      const int end = std::min(begin + waves.blocks, mine.last);
      for (int block = begin; block < end; ++block)
        store_parts(parts_of(block), &parts[4 * static_cast<std::size_t>(mine.place_of(parts_of_block * block))]);
      for (int at = waves.first[begin]; at < waves.first[end]; ++at)
        if (is_mine(at))
          add_up_node(
              waves, [&](int part) { return mine.place_of(part); }, parts.data(), at, y.data());
    }
#pragma omp barrier
    const int end = std::min(mine.first + waves.span, mine.last);
    for (int at = waves.first[mine.first]; at < waves.first[end]; ++at)
      if (!is_mine(at))
        add_up_node(
            waves, [&](int part) { return run_with(waves, body.blocks(), part, threads).place_of(part); }, parts.data(),
            at, y.data());
  }
}

}  // namespace lockstep::production_face::openmp
