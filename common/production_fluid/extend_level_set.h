// Contract: the level set goes on into obstacles, so that the surface meets them at a right angle.
//
// Without it, phi in an obstacle would stay what it was: liquid that drains from a wall would leave a film, because a
// cell of air would keep a neighbour in the wall with phi < 0.
//
// A solid cell c of solid >= -3 h gets
//
//   phi = sum over axes of w phi(n) / sum over axes of w,   w = solid(n) - solid(c) > 0,
//
// where n is, of the two neighbours along the axis, the one of greater solid: the nearer to the open. So grad phi .
// grad solid = 0, upwind. Cells depend on cells nearer to the open alone. Deeper cells, and those from which no axis
// leads out, keep their phi. The mean is taken so that equal values give that value to the bit.
//
// Obstacles do not move, so make_extension finds order and weights once, sequentially.
//
// In:      extension, of the fluid's obstacles.
// In, out: phi, finite. Padding is not changed.
// Source:  Adalsteinsson and Sethian, The fast construction of extension velocities in level set methods, J. Comput.
//          Phys. 148 (1999); level sets in obstacles: Enright, Marschner and Fedkiw, SIGGRAPH 2002.
#pragma once

#include <cstdint>

#include "common/array.h"
#include "common/production_fluid/state.h"

namespace lockstep::production_fluid {

// The cells that get a value, level by level: a level depends on open cells and on earlier levels alone. Along an axis
// that does not count, the share is 0 and the neighbour is the cell itself. Arrays are padded.
template <class Real>
struct Extension {
  Array<std::int32_t> first{0};      // [level]: its first cell; and the number of cells behind the last
  Array<std::int32_t> cell;          // where it stands in phi.value, as neighbours do
  Array<std::int32_t> neighbour[3];  // along x, y, z
  Array<Real> share[3];              // of an axis in the mean of it and the axes before
};

inline constexpr float depth_of_extension = 3;  // cells

template <class Real>
Extension<Real> make_extension(const Fluid<Real>& fluid);

template <class Real>
using ExtendLevelSet = void(const Extension<Real>& extension, Field<Real>& phi);

namespace serial {
ExtendLevelSet<float> extend_level_set;
ExtendLevelSet<double> extend_level_set;
}  // namespace serial

namespace openmp {
ExtendLevelSet<float> extend_level_set;
}  // namespace openmp

// --- Formulas; of numbers or of lanes

// The mean of the neighbours along the three axes.
template <class Number>
inline Number mean_of_neighbours(const Number (&phi)[3], const Number (&share)[3]) {
  Number mean = share[0] * phi[0];
  for (int axis : {1, 2}) mean = mean + share[axis] * (phi[axis] - mean);
  return mean;
}

}  // namespace lockstep::production_fluid
