// The whole state of a game cloth: particles, constraints between them, triangles for the wind, and bodies to collide
// with.
//
// A cloth is a sheet (particles on a grid of rows and columns; a rope is one row) or a triangle mesh. Both hold the
// same lists of constraints and triangles. A sheet's constraints also follow from its grid, without a list, which is
// what lanes need.
//
// Source: [Jakobsen 2001]; [LRB08] "Cloth Simulation"; [ITJ07] "Game Cloth".
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/arrays.h"
#include "common/mesh.h"
#include "common/vector3.h"

namespace lockstep::cloth {

// The parameters of a step. Units: m, kg, s.
template <class Real>
struct Model {
  Real time_step;         // s, of a substep
  int substeps;           // of a step; each is verlet, relax, collide
  int iterations;         // of the relaxation in a substep
  Vector3<Real> gravity;  // m/s^2
  Vector3<Real> wind;     // m/s, the velocity of the air
  Real drag;              // kg/m^3: air density times drag coefficient; 0 for no air
  Real velocity_factor;   // 0 .. 1: damping, by which each substep multiplies velocities
};

// The grid of a sheet. Particle (row, column) is at index row * pitch + column of every array; rows are padded to whole
// vectors by pinned particles (inverse mass 0, at the origin). A mesh has rows = 0.
struct Sheet {
  int rows = 0, columns = 0, pitch = 0;

  int index(int row, int column) const { return row * pitch + column; }
};

// Constraints of one kind between particles of a sheet: one between (r, c) and (r + down, c + right) wherever both
// exist.
template <class Real>
struct Family {
  int down, right;
  Real rest_2;  // m^2: the square of their rest length
};

// Colours of a family's constraints: 0 or 1 by the row they begin in, or, where they stay in their row, by the column.
// The colour changes every `down` rows (`right` columns), so that no two constraints of one colour share a particle.
inline constexpr int every_colour = -1;

// Distance constraints as a list: the rest length of constraint k, between particles a[k] and b[k], squared is
// rest_2[k].
template <class Real>
struct Constraints {
  Array<std::int32_t> a, b;
  Array<Real> rest_2;  // m^2, > 0
  int count = 0;
};

// Solid bodies, which do not move. The loader has added the scene's `thickness` to their sizes.
template <class Real>
struct Plane {
  Vector3<Real> normal;  // of length 1
  Real offset;           // m: inside is normal . x < offset
};
template <class Real>
struct Capsule {  // a sphere where from = to
  Vector3<Real> from, to;
  Real radius;
};
template <class Real>
struct Box {
  Vector3<Real> centre;
  Vector3<Real> half;                 // m
  std::array<Vector3<Real>, 3> axis;  // orthogonal, of length 1: along which half.x, half.y, half.z extend
};
template <class Real>
struct Bodies {
  std::vector<Plane<Real>> planes;
  std::vector<Capsule<Real>> capsules;
  std::vector<Box<Real>> boxes;
  Real friction = 0;  // Coulomb's coefficient of all of them
};

// Owns everything; one thread of control at a time may step it.
template <class Real>
struct Cloth {
  Model<Real> model;
  Bodies<Real> bodies;

  int count = 0;             // particles, a sheet's padding among them
  Vectors<Real> position;    // m
  Vectors<Real> previous;    // m: the positions one substep ago; the difference is the velocity times the time step
  Array<Real> inverse_mass;  // 1/kg; 0 for a pinned particle, which does not move
  // N: scratch of verlet, a force a triangle. A sheet has room for 2 (rows + 1) (pitch + 16), the layout of openmp/:
  // squares row by row with a border of zeros, so that sixteen are loaded at once without a test for the sheet's edge.
  Vectors<Real> force;

  Sheet sheet;
  std::vector<Family<Real>> families;  // of a sheet, in the order of the passes: vertical, horizontal, diagonal

  Constraints<Real> constraints;  // in their original order: of a sheet left to right and top to bottom
  Constraints<Real> batched;      // the same constraints, batch by batch: those of a batch share no particle that moves
  std::vector<int> batch_begin;   // [batch], and one more: where its constraints begin in `batched`

  std::vector<Triangle> triangles;
  std::vector<int> corner_begin;  // [particle], and one more: where its corners begin in `corner`
  std::vector<int> corner;        // the triangles that a particle is a corner of, in their order
};

// What steps change.
template <Is<Cloth> C, class F>
void for_each_array(C& cloth, const F& f) {
  f("position", cloth.position, cloth.count);
  f("previous", cloth.previous, cloth.count);
}

}  // namespace lockstep::cloth
