// Matrices of model problems.
#pragma once

#include "common/linear/matrix.h"

namespace lockstep::linear {

// Poisson's equation for the pressure in a tank of cells^3 cubes, scaled by the square of their side. A ball of solid
// cells, of radius `hole` times the tank's side, stands in its middle; its cells are not unknowns. The tank's walls and
// the solid are closed, above the tank (y = cells) is air, where the pressure is 0. So a row has -1 for each of up to
// six neighbours, and their number on the diagonal, with one more under the air. Unknowns are numbered along x, then y,
// then z.
Rows<float> make_poisson(int cells, double hole);

// Linear elasticity of a block of cubes of side 1 between points^3 lattice points: trilinear elements, integrated by
// 2^3 Gauss points; Young's modulus 1, Poisson's ratio .3. The side x = 0 is held by one more layer of cubes whose far
// points do not move. Each point couples with up to 27. Points are numbered along x, then y, then z. Symmetric to the
// bit. points >= 2.
BlockRows<float> make_elasticity(int points);

}  // namespace lockstep::linear
