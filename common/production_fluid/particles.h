// Particles that carry the liquid's surface where the grid is too coarse for it (particle level set).
//
// Particles of sign -1 mark liquid, those of sign +1 mark air. Each is a ball that touches the surface from its side,
// as far as its radius reaches. A particle has escaped if it stands on the other side of the surface by more than its
// radius: there the level set is wrong.
//
// A block is the cube between eight neighbouring centres of cells. So all particles of a block read the same eight
// values of phi. Block (x, y, z) begins at the centre of cell (x, y, z). The first and the last block along an axis
// reach to the side of the box. There are as many blocks as cells.
//
// Source: Enright, Fedkiw, Ferziger and Mitchell, A hybrid particle level set method for improved interface capturing,
//         J. Comput. Phys. 183 (2002).
#pragma once

#include <cstdint>

#include "common/arrays.h"
#include "common/production_fluid/state.h"
#include "common/production_fluid/trace.h"
#include "common/vector3.h"

namespace lockstep::production_fluid {

// Arrays have room for padded(count) elements.
template <class Real>
struct Particles {
  int count = 0;
  Vectors<Real> position;  // m, from the corner of the box; inside it
  Array<Real> radius;      // m, from .1 h to .5 h
  Array<Real> sign;        // -1 in the liquid, +1 in the air
  // Where the particles of each block begin, and `count` behind the last. It holds while particles are sorted by
  // block: after sort_particles, and until they move.
  Array<std::int32_t> first;
};

// Liquid that left the surface by more than the grid can follow: drops that fly freely until they fall back.
template <class Real>
struct Spray {
  int count = 0;
  Vectors<Real> position;  // m
  Vectors<Real> velocity;  // m/s
  Array<Real> radius;      // m
};

inline constexpr float least_radius = .1f, most_radius = .5f;  // in cells
inline constexpr float band_of_particles = 3;                  // cells on both sides of the surface

template <Is<Particles> P, class F>
void for_each_array(P& particles, const F& f) {
  f("position", particles.position, particles.count);
  f("radius", particles.radius, particles.count);
  f("sign", particles.sign, particles.count);
  f("first", particles.first, particles.first.size());
}

template <Is<Spray> S, class F>
void for_each_array(S& spray, const F& f) {
  f("position", spray.position, spray.count);
  f("velocity", spray.velocity, spray.count);
  f("radius", spray.radius, spray.count);
}

// Room for `count` particles; what is there stays.
template <class Real>
void resize(Particles<Real>& particles, std::size_t count) {
  particles.count = static_cast<int>(count);
  particles.position.resize(count);
  particles.radius.resize(padded(count)), particles.sign.resize(padded(count));
}
template <class Real>
void resize(Spray<Real>& spray, std::size_t count) {
  spray.count = static_cast<int>(count);
  spray.position.resize(count), spray.velocity.resize(count);
  spray.radius.resize(padded(count));
}

// --- Formulas; of numbers or of lanes. Positions are in cells from the corner of the box.

// The block of a position, x + nx (y + ny z).
template <class Index, class Number, class Real>
inline Index block_of(const Field<Real>& phi, const Vector3<Number>& at) {
  const Index x = place<Index>(at.x - Number(.5f), phi.nx).first, y = place<Index>(at.y - Number(.5f), phi.ny).first,
              z = place<Index>(at.z - Number(.5f), phi.nz).first;
  return x + phi.nx * (y + phi.ny * z);
}

// How far a particle's ball reaches: to the surface, within bounds. `phi` is the level set at the particle.
template <class Number>
inline Number radius_of(const Number& sign, const Number& phi, const Number& spacing) {
  return min(max(sign * phi, Number(least_radius) * spacing), Number(most_radius) * spacing);
}

template <class Number>
inline auto has_escaped(const Number& sign, const Number& phi, const Number& radius) {
  return Number(0) - sign * phi > radius;
}

}  // namespace lockstep::production_fluid
