// A body of tetrahedra with muscles in it: at rest, and deformed.
//
// Corners of a tetrahedron are counted from 0 to 3. The linear shape function of corner a is 1 at the corner and 0 at
// the others; gradient_a is its gradient at rest. Those of corners 1 to 3 are the rows of Dm^-1,
// Dm = [X1 - X0, X2 - X0, X3 - X0]. So F = I + sum over a = 1, 2, 3 of (u_a - u_0) gradient_a^T, where u are
// displacements. Displacements are stored, not positions, so that in float small strains keep their relative precision.
//
// The last block of tetrahedra is filled up with copies of the last one that have no volume. update_state computes
// them, too; they give nothing to nodes.
#pragma once

#include <cstdint>

#include "common/arrays.h"
#include "common/blocked.h"
#include "common/rotation.h"

namespace lockstep::production_face {

inline constexpr float muscle_stress = 3e5f;  // Pa: the greatest tension of a muscle, unless it has its own

template <class Real>
struct Body {
  int nodes = 0, tetrahedra = 0;  // without those that fill up the last block
  int muscles = 0;
  Vectors<Real> rest;            // m, of the nodes
  Blocked<std::int32_t> corner;  // 4: the nodes of a tetrahedron, with positive volume in this order
  Blocked<Real> gradient;        // 9, 1/m: of corners 1, 2 and 3
  Blocked<Real> volume;          // 1, m^3

  // Muscle fibres. A block of tetrahedra has as many slots of fibres as its tetrahedron with the most fibres. Block b
  // has the slots first_fibre[b] to first_fibre[b + 1] - 1. A slot is a block of Blocked.
  Array<std::int32_t> first_fibre;
  Blocked<std::int32_t> muscle;  // 1: the fibre's muscle, -1 where a tetrahedron has none in this slot
  // 5: its direction, of length 1; the share of the tetrahedron that is muscle; its greatest tension, Pa. 0 without one
  Blocked<Real> fibre;

  // The corners at a node, in the order of their tetrahedra: 4 tetrahedron + corner. Those of node n stand from
  // first_corner[n] to first_corner[n + 1] - 1.
  Array<std::int32_t> first_corner, corner_at_node;

  Array<std::int32_t> held;  // the nodes that bones hold, ascending: their places are given

  int blocks() const { return volume.blocks(); }
  int padded_tetrahedra() const { return blocks() * lanes; }
};

// How a body is deformed, and how its muscles are activated.
template <class Real>
struct Pose {
  Vectors<Real> displacement;  // m, of the nodes
  Array<Real> activation;      // 0 to 1, of the muscles
};

template <Is<Pose> P, class F>
void for_each_array(P& pose, const F& f) {
  f("displacement", pose.displacement, pose.displacement.x.size());
  f("activation", pose.activation, pose.activation.size());
}

// What follows from a pose in each tetrahedron (update_state.h).
template <class Real>
struct Strained {
  Blocked<Real> stress;      // 9, Pa: P by columns, muscles included
  Blocked<Real> u, v;        // 9 each: the rotations of F's singular values, by columns
  Blocked<Real> derivative;  // 12, Pa: xx, yy, zz, xy, yz, zx, alpha, beta (flesh_material.h)
  Blocked<Real> pull;        // 5, of a fibre: F w, and t / l and c in Pa (muscle.h)
  Blocked<Real> energy;      // 1, J/m^3: of the flesh and its fibres
};

template <Is<Strained> S, class F>
void for_each_array(S& strained, const F& f) {
  f("stress", strained.stress.value, strained.stress.value.size());
  f("u", strained.u.value, strained.u.value.size());
  f("v", strained.v.value, strained.v.value.size());
  f("derivative", strained.derivative.value, strained.derivative.value.size());
  f("pull", strained.pull.value, strained.pull.value.size());
  f("energy", strained.energy.value, strained.energy.value.size());
}

// Room for a body.
template <class Real>
Strained<Real> make_strained(const Body<Real>& body) {
  const int blocks = body.blocks(), fibres = body.muscle.value.empty() ? 0 : body.muscle.blocks();
  return {{9, blocks}, {9, blocks}, {9, blocks}, {12, blocks}, {5, fibres}, {1, blocks}};
}

}  // namespace lockstep::production_face
