// In which order openmp lets tetrahedra store their parts and nodes add them up (parts.h).
//
// Each thread has a run of blocks of tetrahedra, one after another, and goes through it in waves of some blocks. Behind
// a wave, those nodes add up whose last tetrahedron is in it. What a wave stores is read soon, while the caches hold
// it, and its room is used again: as much room as a wave takes, and the blocks before it that its nodes read. Where
// nodes and tetrahedra are numbered without regard to where they are, that is all of them.
//
// Made once from a body, by sequential code.
#pragma once

#include <cstdint>

#include "common/production_face/body.h"

namespace lockstep::production_face {

struct Waves {
  int blocks = 0;                     // of a wave
  int span = 0;                       // the most blocks between the first and the last tetrahedron of a node
  Array<std::int32_t> first{0};       // [block]: its first node in `node`; and the number of nodes, behind the last
  Array<std::int32_t> node;           // by the block of their last tetrahedra, ascending in each
  Array<std::int32_t> first_part{0};  // [place in `node`]: its first part in `part`; and the number of parts
  Array<std::int32_t> part;           // 4 t + a for corner a of tetrahedron t, ascending
};

// Waves of 16 blocks store 16 KB (notes/production_face.md).
template <class Real>
Waves make_waves(const Body<Real>& body, int blocks = 16);

// Room for the parts of all tetrahedra: four numbers a corner.
template <class Real>
Array<float> make_parts(const Body<Real>& body) {
  return Array<float>(static_cast<std::size_t>(body.blocks()) * lanes * 16);
}

}  // namespace lockstep::production_face
