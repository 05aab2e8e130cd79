// Contract: takes particles away that no longer help the level set; liquid that got away from it becomes spray.
//
// phi, solid: the level set and the distance from obstacles at a particle; s its sign, r its radius. In this order:
//
//   solid < 0                          inside an obstacle: deleted
//   -s phi > 1.5 r,  s = -1            liquid that got away: becomes spray, with its radius and the grid's velocity
//   -s phi > 1.5 r,  s = +1            air that got lost in the liquid: deleted
//   |phi| > 4 h                        too far from the surface to correct it: deleted
//   s = +1, a bubble's centre within r deleted
//
// A bubble is a cell with 0 < phi < h that no cell beside it exceeds: air about a cell wide, the least that phi can
// hold. Air has no pressure here, so the liquid may close such a hole. A particle in its middle would open it again and
// again. In wider air there are other particles, and this one may stay.
//
// Bubbles so small that a lost particle stands for them are not followed, while spray is: liquid that vanished would be
// missed, air is not. Particles of liquid more than 4 h out in the air become spray, too, since they have escaped.
//
// In:      fluid: phi a distance near the surface, solid and velocity finite, as is their padding; particles, sorted:
//          `first` holds.
// Out:     kept: the particles that stay, in their order, and where those of each block begin. It must be another
//          object than `particles`.
//          spray: what was there, and then the new drops in the order of the particles.
// Errors:  std::bad_alloc.
// Source:  Enright, Marschner and Fedkiw, Animation and rendering of complex water surfaces, SIGGRAPH 2002; [ITJ07]
//          "Production Fluid".
#pragma once

#include <algorithm>

#include "common/math.h"
#include "common/production_fluid/particles.h"
#include "common/production_fluid/state.h"
#include "common/production_fluid/trace.h"

namespace lockstep::production_fluid {

template <class Real>
using RemoveParticles = void(const Fluid<Real>& fluid, const Particles<Real>& particles, Particles<Real>& kept,
                             Spray<Real>& spray);

namespace serial {
RemoveParticles<float> remove_particles;
RemoveParticles<double> remove_particles;
}  // namespace serial

namespace openmp {
RemoveParticles<float> remove_particles;
}  // namespace openmp

// --- Formulas; of numbers or of lanes. Positions are in cells from the corner of the box.

inline constexpr float radii_of_removed = 1.5f;  // by which a particle has escaped for good
inline constexpr float reach_of_particles = 4;   // cells from the surface

// What becomes of a particle: both false if it is deleted. Mask: bool or maskv.
template <class Mask>
struct Fate {
  Mask keep, spray;
};

// By all rules but that of bubbles.
template <class Number>
inline auto fate_of(const Number& sign, const Number& radius, const Number& phi, const Number& solid,
                    const Number& spacing) {
  using Mask = decltype(sign < sign);
  const Mask free = !is_solid(solid), escaped = has_escaped(sign, phi, Number(radii_of_removed) * radius),
             near = !(abs(phi) > Number(reach_of_particles) * spacing);
  return Fate<Mask>{.keep = Mask(free & !escaped & near), .spray = Mask(free & escaped & (sign < Number(0)))};
}

// Whether the centre of the cell in which a position lies is within a radius of it. No other centre can be: a radius is
// at most half a cell.
template <class Index, class Number, class Real>
inline auto reaches_centre(const Field<Real>& phi, const Vector3<Number>& at, const Number& radius) {
  const auto from_centre = [](const Number& x, int n) {
    return x - (Number(to_float(place<Index>(x, n).first)) + Number(.5f));
  };
  const Vector3<Number> away = {from_centre(at.x, phi.nx), from_centre(at.y, phi.ny), from_centre(at.z, phi.nz)};
  return dot(away, away) <= radius * radius;
}

// Beside the sides of the box, phi is what it is at the side.
template <class Real>
inline bool is_bubble(const Field<Real>& phi, int x, int y, int z) {
  const Real here = phi(x, y, z);
  if (!(here > 0 && here < phi.spacing)) return false;
  return here >= phi(std::max(x - 1, 0), y, z) && here >= phi(std::min(x + 1, phi.nx - 1), y, z) &&
         here >= phi(x, std::max(y - 1, 0), z) && here >= phi(x, std::min(y + 1, phi.ny - 1), z) &&
         here >= phi(x, y, std::max(z - 1, 0)) && here >= phi(x, y, std::min(z + 1, phi.nz - 1));
}

// Whether the cell in which a position lies is a bubble.
template <class Real>
inline bool is_in_bubble(const Field<Real>& phi, const Vector3<Real>& at) {
  using Index = std::int32_t;
  return is_bubble(phi, place<Index>(at.x, phi.nx).first, place<Index>(at.y, phi.ny).first,
                   place<Index>(at.z, phi.nz).first);
}

}  // namespace lockstep::production_fluid
