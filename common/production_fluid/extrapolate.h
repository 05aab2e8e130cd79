// Contract: the liquid's velocity goes on into the air, so that surface and particles find one to follow there.
//
// A face has the distance phi_face = (phi(a) + phi(b)) / 2, where a and b are the cells beside it. Beside a solid cell
// or a side of the box, it is the other cell's phi, and between two of them the mean again, with 0 for a side. Where
// neither value is negative, phi_face is at least 1e-30 m: the surface may go through the centres of two air cells, and
// the pressure has not pushed the face between them.
//
// A face is known from the start if it is closed (project has set it to the velocity of what closes it) or has a liquid
// cell beside it: the pressure has pushed it. So what the liquid's cells lose and gain stays zero. With faces of
// phi_face > 0 replaced, liquid cells had divergence again after every substep: an elliptical drop lost twice as much
// speed, and more so the shorter the substeps (notes/production_fluid.md, "Oracles").
//
// The other faces, in ascending order of phi_face as far as `distance`, get
//
//   u = sum over axes of w u(n) / sum over axes of w,   w = phi_face - phi_face(n) > 0,
//
// where n is the neighbour along the axis, a face of the same component, that is known and has the lesser phi_face; of
// two equal ones the lower. An axis whose known neighbours are all as far as the face or farther does not count. Where
// no axis counts, the face gets 0 and is unknown to others: no liquid is there to follow, and with its own velocity it
// would fall in every substep, faster than any liquid (notes/production_fluid.md, "Velocity in the air"). Faces farther
// than `distance` get 0.
//
// So grad phi . grad u = 0, upwind: u is constant along the way to the surface. The weighted mean is taken so that
// equal velocities give that velocity to the bit. A face depends on nearer faces alone: whatever the order in which
// others are computed, a face whose nearer neighbours are done gets the same bits.
//
// In:     fluid: phi and solid, finite; distance, m, some cells; faces, from project, finite.
// Out:    faces, which may be fluid.velocity itself. Padding is not changed.
// Errors: std::bad_alloc.
// Source: Adalsteinsson and Sethian, The fast construction of extension velocities in level set methods, J. Comput.
//         Phys. 148 (1999); Enright, Marschner and Fedkiw, SIGGRAPH 2002.
#pragma once

#include "common/math.h"
#include "common/production_fluid/neighbours.h"
#include "common/production_fluid/state.h"

namespace lockstep::production_fluid {

template <class Real>
using Extrapolate = void(const Fluid<Real>& fluid, Real distance, Faces<Real>& faces);

namespace serial {
Extrapolate<float> extrapolate;
Extrapolate<double> extrapolate;
}  // namespace serial

namespace openmp {
Extrapolate<float> extrapolate;
}  // namespace openmp

// The cells before and behind the faces of a line. Above an open top, phi is that of the cell below: the air there has
// no distance of its own.
template <class Real>
struct Beside {
  Line<Real> a, b;
};
template <class Real>
Beside<Real> beside(const Fluid<Real>& fluid, const Lines<Real>& lines, int axis, int y, int z) {
  const Line<Real> here = lines(y, z);
  if (axis == 0) return {{here.phi - 1, here.solid - 1}, here};
  const Line<Real> before = axis == 1 ? lines(y - 1, z) : lines(y, z - 1);
  return {before, {y == fluid.ny && fluid.open_top ? before.phi : here.phi, here.solid}};
}

// --- Formulas; of numbers or of lanes

// Whether project has set the face.
template <class Number>
inline auto is_known(const Number& phi_a, const Number& solid_a, const Number& phi_b, const Number& solid_b) {
  return is_closed(solid_a, solid_b) | (phi_a < Number(0)) | (phi_b < Number(0));
}

template <class Number>
inline Number distance_of_face(const Number& phi_a, const Number& solid_a, const Number& phi_b, const Number& solid_b) {
  constexpr float least = 1e-30f;
  const Number a = select(is_solid(solid_a), phi_b, phi_a), b = select(is_solid(solid_b), phi_a, phi_b);
  const Number mean = (a + b) * Number(.5f);
  return select((a < Number(0)) | (b < Number(0)), mean, max(mean, Number(least)));
}

// A neighbour: its distance, or `far` where it is unknown, and its velocity.
template <class Number>
struct Neighbour {
  Number distance, velocity;
};

// The weighted mean of a face's neighbours so far.
template <class Number>
struct Continued {
  Number velocity{0}, weight{0};
};

// Adds the neighbours along an axis.
template <class Number>
inline void add_axis(const Number& distance, const Neighbour<Number>& low, const Neighbour<Number>& high,
                     Continued<Number>& face) {
  const auto from_high = high.distance < low.distance;
  const Number weight = distance - select(from_high, high.distance, low.distance);
  const Number change = select(from_high, high.velocity, low.velocity) - face.velocity;
  const auto counts = weight > Number(0);
  const Number all = face.weight + weight;
  face.velocity = select(counts, face.velocity + weight / all * change, face.velocity);
  face.weight = select(counts, all, face.weight);
}

}  // namespace lockstep::production_fluid
