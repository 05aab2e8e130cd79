// Contract: evens out how many particles the blocks beside the surface hold.
//
// What moves with the liquid gathers in some blocks and leaves others. So from time to time, in each block:
//
// - a particle that has escaped stays, whatever comes below;
// - others go if they are more than the band away from the surface, |phi| > 3 h;
// - if more than `per_block` would stay, of both signs together, those of the least s phi - r stay, as many as are
//   allowed beside the escaped ones; s is a particle's sign, r its radius. Of equal ones those that come first stay;
// - if fewer stay and the block has room, new ones are added, up to `per_block`.
//
// The kept ones stay in order, and the new ones come after them. The block has room if on one side of the surface
// s phi at its corners reaches into what particles keep, .1 h to 3 h, and if a corner is outside obstacles.
//
// A new particle begins at a random point of the block and gets the sign of the side that the point is on, so the signs
// have the sides' proportions. If the point is not within .1 h and 3 h of the surface, up to fifteen moves take it
// towards a goal, a phi drawn evenly from those that the block's corners allow on this side:
//
//   position += share (goal - phi) slope / |slope|
//
// where `share` is 1 at first. A move that ends outside the block or in an obstacle, or beyond its goal and outside of
// what particles keep, is not made: `share` is halved. A particle that does not get there begins at another point, up
// to five times, and is then given up.
//
// PhysBAM draws its goals from the whole band, and lets particles leave their block. Here a block keeps what it seeds.
// So its work depends on nothing that other blocks do, the particles are in order once they are made, and a block that
// has few is not emptied by the way to a far goal. Random numbers depend on the block, the number of the particle in
// it, which attempt it is, `seed` and `round`, and so not on the threads.
//
// In:      fluid, of which phi and solid are read, finite, as is their padding; fewer than 2^31 values a field with
//          padding. particles, sorted by block, or none; finite; radius > 0; sign -1 or 1. per_block >= 0; fewer than
//          2^31 particles and blocks.
// Out:     reseeded, another object: sorted by block, with `first`.
// Errors:  std::bad_alloc.
// Source:  Enright, Fedkiw, Ferziger and Mitchell, A hybrid particle level set method for improved interface capturing,
//          J. Comput. Phys. 183 (2002), 3.1 and 3.5.
#pragma once

#include <cstdint>

#include "common/math.h"
#include "common/production_fluid/particles.h"
#include "common/random.h"

namespace lockstep::production_fluid {

struct ReseedSettings {
  int per_block = 16;
  std::uint32_t seed = 0;
  std::uint32_t round = 0;  // how many times particles were reseeded before
};

template <class Real>
using Reseed = void(const Fluid<Real>& fluid, const ReseedSettings& settings, const Particles<Real>& particles,
                    Particles<Real>& reseeded);

namespace serial {
Reseed<float> reseed;
Reseed<double> reseed;
}  // namespace serial

namespace openmp {
Reseed<float> reseed;
}  // namespace openmp

inline constexpr int most_moves = 15, most_attempts = 6;

// --- Blocks; of numbers or of lanes. Lengths are in cells where nothing else is said.

template <class Number>
struct Block {
  Vector3<Number> low, high;   // a position is in the block if low <= position < high
  Vector3<Number> corner;      // the centre of its cell, from which the block's values count
  Corners<Number> phi, solid;  // m
  Number spacing, per_metre;   // m, and cells a metre
};

// The values around the block of cell (x, y, z). Where there is no further cell along an axis, the last one counts
// twice. load(index) is an element of the field, counted from cell (0, 0, 0).
template <class Index, class Real, class Load>
inline auto corners_of(const Field<Real>& field, const Index& x, const Index& y, const Index& z, const Load& load) {
  const auto step = [](const Index& at, int n, int distance) {
    return select(at < Index(n - 1), Index(distance), Index(0));
  };
  const Index first = (z * Index(field.ny) + y) * Index(field.pitch) + x, next = step(x, field.nx, 1);
  const Index line = first + step(y, field.ny, field.pitch);
  const Index to_plane = step(z, field.nz, field.pitch * field.ny), plane = first + to_plane, both = line + to_plane;
  return Corners<decltype(load(first))>{load(first), load(first + next), load(line), load(line + next),
                                        load(plane), load(plane + next), load(both), load(both + next)};
}

// load_from(values) returns corners_of's `load` for an array.
template <class Number, class Index, class Real, class LoadFrom>
inline Block<Number> block_at(const Fluid<Real>& fluid, const Index& x, const Index& y, const Index& z,
                              const LoadFrom& load_from) {
  const auto low = [](const Index& at) { return select(at > Index(0), Number(to_float(at)) + Number(.5f), Number(0)); };
  const auto high = [](const Index& at, int n) {
    return select(at < Index(n - 1), Number(to_float(at)) + Number(1.5f), Number(static_cast<float>(n)));
  };
  const auto corner = [](const Index& at) { return Number(to_float(at)) + Number(.5f); };
  const auto corners = [&](const Field<Real>& field) {
    return corners_of(field, x, y, z, load_from(&field.value[field.index(0, 0, 0)]));
  };
  return {.low = {low(x), low(y), low(z)},
          .high = {high(x, fluid.nx), high(y, fluid.ny), high(z, fluid.nz)},
          .corner = {corner(x), corner(y), corner(z)},
          .phi = corners(fluid.phi),
          .solid = corners(fluid.solid),
          .spacing = Number(fluid.spacing),
          .per_metre = Number(Real(1) / fluid.spacing)};
}

// The range of s phi, m, that particles may keep and a block's corners reach; empty where least > most.
template <class Number>
struct Reach {
  Number least, most;
};
template <class Number>
inline Reach<Number> reach(const Corners<Number>& phi, const Number& sign, const Number& spacing) {
  Number least = sign * phi.value[0], most = least;
  for (int k = 1; k < 8; ++k) {
    least = min(least, sign * phi.value[k]);
    most = max(most, sign * phi.value[k]);
  }
  return {max(least, Number(least_radius) * spacing), min(most, Number(band_of_particles) * spacing)};
}

template <class Number>
inline auto has_room(const Corners<Number>& phi, const Corners<Number>& solid, const Number& spacing) {
  const auto on_side = [&](const Reach<Number>& side) { return side.least <= side.most; };
  Number open = solid.value[0];
  for (int k = 1; k < 8; ++k) open = max(open, solid.value[k]);
  const auto is_open = !is_solid(open);
  return is_open & (on_side(reach(phi, Number(-1), spacing)) | on_side(reach(phi, Number(1), spacing)));
}

// How far a position in the block is from the corner, along each axis. Beside a side of the box, values do not change.
template <class Number>
inline Vector3<Number> place_in(const Block<Number>& block, const Vector3<Number>& at) {
  const Vector3<Number> way = at - block.corner;
  return {max(way.x, Number(0)), max(way.y, Number(0)), max(way.z, Number(0))};
}

// phi at a position in m that is in the block.
template <class Number>
inline Number phi_at(const Block<Number>& block, const Vector3<Number>& position) {
  const Vector3<Number> place = place_in(block, block.per_metre * position);
  return interpolate(block.phi, place.x, place.y, place.z);
}

// --- Which particles are kept

template <class Number>
inline auto is_beyond(const Number& phi, const Number& spacing) {
  return abs(phi) > Number(band_of_particles) * spacing;
}

// Particles of the least rank are kept; escaped ones rank before all others.
template <class Number>
inline Number rank_of(const Number& sign, const Number& phi, const Number& radius) {
  return select(has_escaped(sign, phi, radius), Number(-levelset::far<float>), sign * phi - radius);
}

// --- New particles

template <class Number>
struct Seed {
  Vector3<Number> position;  // m
  Number phi, goal;          // m
  Number sign, share;
};

// Where a particle may stand: in its block, outside obstacles.
template <class Number>
inline auto may_stand(const Block<Number>& block, const Vector3<Number>& position) {
  const auto within = [](const Number& low, const Number& at, const Number& high) { return (low <= at) & (at < high); };
  const Vector3<Number> at = block.per_metre * position, place = place_in(block, at);
  return within(block.low.x, at.x, block.high.x) & within(block.low.y, at.y, block.high.y) &
         within(block.low.z, at.z, block.high.z) & !is_solid(interpolate(block.solid, place.x, place.y, place.z));
}

// Whether s phi is within what particles keep, .1 h to 3 h.
template <class Number>
inline auto is_in_band(const Number& sign, const Number& phi, const Number& spacing) {
  return (sign * phi >= Number(least_radius) * spacing) & (sign * phi <= Number(band_of_particles) * spacing);
}

template <class Number, class Index>
inline Seed<Number> begin_at_random(const Block<Number>& block, const FourWords<Index>& random) {
  const auto between = [&](const Number& low, const Number& high, int k) {
    return low + unit<Number>(random.word[k]) * (high - low);
  };
  const Vector3<Number>&low = block.low, &high = block.high;
  const Vector3<Number> position =
      block.spacing * Vector3<Number>{between(low.x, high.x, 0), between(low.y, high.y, 1), between(low.z, high.z, 2)};
  const Number phi = phi_at(block, position), sign = select(phi < Number(0), Number(-1), Number(1));
  const Reach<Number> goals = reach(block.phi, sign, block.spacing);
  return {.position = position,
          .phi = phi,
          .goal = sign * between(goals.least, goals.most, 3),
          .sign = sign,
          .share = Number(1)};
}

// One move towards the goal. Where phi has no slope, the position becomes NaN; comparisons with it are false, so the
// move is not made.
template <class Number>
inline void move(const Block<Number>& block, Seed<Number>& seed) {
  const Vector3<Number> at = block.per_metre * seed.position, place = place_in(block, at);
  Vector3<Number> up = slope(block.phi, place.x, place.y, place.z);
  where(at.x < block.corner.x, up.x) = Number(0);
  where(at.y < block.corner.y, up.y) = Number(0);
  where(at.z < block.corner.z, up.z) = Number(0);
  const Number way = seed.goal - seed.phi;
  const Vector3<Number> position = seed.position + (seed.share * way / sqrt(dot(up, up))) * up;
  const Number phi = phi_at(block, position);
  const auto is_short = (way < Number(0)) ^ (seed.goal - phi >= Number(0));
  const auto is_made = may_stand(block, position) & (is_short | is_in_band(seed.sign, phi, block.spacing));
  seed.position = select(is_made, position, seed.position);
  seed.phi = select(is_made, phi, seed.phi);
  seed.share = select(is_made, seed.share, Number(.5f) * seed.share);
}

}  // namespace lockstep::production_fluid
