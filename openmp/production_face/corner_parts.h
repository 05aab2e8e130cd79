// What tetrahedra give to their nodes, in two passes wave by wave (common/production_face/waves.h): sixteen tetrahedra
// at a time store their parts, then each node adds up its own, in the order of tetrahedra. These are the additions of a
// serial loop over tetrahedra, in its order, and no two threads write to one node.
#pragma once

#include <algorithm>
#include <span>

#include "common/production_face/parts.h"
#include "common/production_face/waves.h"
#include "common/simd.h"

namespace lockstep::production_face::openmp {

// A tetrahedron's parts are one line of the cache: four numbers a corner, of which the last is 0.
LOCKSTEP_INLINE void store_parts(const Parts<floatv>& part, float* to) {
  const auto& [a, b, c, d] = part.of;
  const floatv zero = 0.f;
  floatv row[lanes] = {a.x, a.y, a.z, zero, b.x, b.y, b.z, zero, c.x, c.y, c.z, zero, d.x, d.y, d.z, zero};
  transpose(row);
  for (int l = 0; l < lanes; ++l) store(to + lanes * l, row[l]);
}

LOCKSTEP_INLINE void add_up_node(const Waves& waves, const float* parts, int place, float* y) {
  float sum[4] = {0, 0, 0, 0};
  for (int k = waves.first_part[place]; k < waves.first_part[place + 1]; ++k) {
    const float* const part = parts + 4 * static_cast<std::size_t>(waves.part[k]);
    for (int c = 0; c < 4; ++c) sum[c] += part[c];
  }
  for (int c = 0; c < 3; ++c) y[3 * static_cast<std::size_t>(waves.node[place]) + c] = sum[c];
}

// parts_of(block) are those of sixteen tetrahedra.
template <class PartsOf>
void add_up_parts(const Body<float>& body, const Waves& waves, const PartsOf& parts_of, Array<float>& parts,
                  std::span<float> y) {
#pragma omp parallel
  for (int wave = 0; wave < waves.count(); ++wave) {
    const int first = wave * waves.blocks, last = std::min(first + waves.blocks, body.blocks());
    // A block writes the parts of its own tetrahedra, where no node of this wave or a later one reads others.
#pragma omp for schedule(static)
    for (int block = first; block < last; ++block)
      store_parts(parts_of(block), &parts[static_cast<std::size_t>(block % waves.room) * lanes * lanes]);
      // A node writes its own components, and reads parts that nobody writes: the next wave waits for this loop.
#pragma omp for schedule(static)
    for (int place = waves.first[wave]; place < waves.first[wave + 1]; ++place)
      add_up_node(waves, parts.data(), place, y.data());
  }
}

}  // namespace lockstep::production_face::openmp
