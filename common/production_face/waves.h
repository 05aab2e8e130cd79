// In which order openmp lets tetrahedra store their parts and nodes add them up (parts.h).
//
// A wave is some blocks of tetrahedra, one after another, and behind them the nodes whose last tetrahedron is in them.
// What a wave stores is read soon, while the caches hold it, and its room is used again: that of block b is the room of
// block b + `room`. So the room is as many waves as lie from the first to the last tetrahedron of a node, at most.
// Where nodes and tetrahedra are numbered without regard to where they are, that is all of them.
//
// Made once from a body, by sequential code.
#pragma once

#include <cstdint>

#include "common/production_face/body.h"

namespace lockstep::production_face {

struct Waves {
  int blocks = 0;                     // of a wave
  int room = 0;                       // blocks that there is room for: whole waves
  Array<std::int32_t> first{0};       // [wave]: its first node in `node`; and the number of nodes, behind the last
  Array<std::int32_t> node;           // wave by wave, ascending in each
  Array<std::int32_t> first_part{0};  // [place in `node`]: its first part in `part`; and the number of parts
  Array<std::int32_t> part;  // where it stands in the room, in the order of tetrahedra: four numbers from 4 part on

  int count() const { return static_cast<int>(first.size()) - 1; }
};

// Waves of 2048 blocks store 2 MB; smaller ones are slower (notes/production_face.md).
template <class Real>
Waves make_waves(const Body<Real>& body, int blocks = 2048);

inline Array<float> make_parts(const Waves& waves) {
  return Array<float>(static_cast<std::size_t>(waves.room) * lanes * 16);
}

}  // namespace lockstep::production_face
