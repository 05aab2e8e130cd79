// Contract: distances of all points within `band` of the interface, by the Fast Sweeping Method.
//
// A round is eight Gauss-Seidel sweeps over all points, one for each combination of directions along x, y and z. In a
// sweep, each point takes the upwind solution from its neighbours (common/levelset/eikonal.h) if that is less than its
// distance and not more than `band`. The distances of interface points are fixed. Rounds end when `rounds` of them are
// done, or one changed nothing. The sweeps of a round in order, as signs of the steps along (x, y, z):
//
//   +++ ++- --+ --- +-+ +-- -++ -+-
//
//   sweeps   over the whole grid. openmp has the order of serial: points of a hyperplane x + y = const are independent.
//   blocks   the grid is cut into blocks of `size` points a side (common/levelset/blocks.h), each padded by the band
//            and a little more; each block is swept on its own.
//
// In, out: distances, as initialize leaves them.
// In:      band, m, > 0; rounds, > 0; size, > 0.
// Returns  how many rounds were made; in blocks, the most of any block.
// Errors:  std::bad_alloc.
// Source:  [ITJ07] Figure 8; Zhao, A fast sweeping method for eikonal equations, Math. Comp. 74 (2005); for hyperplanes
//          Detrixhe, Gibou and Min, A parallel fast sweeping method for the eikonal equation, J. Comput. Phys. 237
//          (2013).
#pragma once

#include "common/levelset/field.h"

namespace lockstep::levelset {

template <class Real>
using FastSweeping = int(Distances<Real>& distances, Real band, int rounds);
template <class Real>
using FastSweepingInBlocks = int(Distances<Real>& distances, Real band, int rounds, int size);

namespace serial {
FastSweeping<float> fast_sweeping_sweeps;
FastSweeping<double> fast_sweeping_sweeps;
FastSweepingInBlocks<float> fast_sweeping_blocks;
FastSweepingInBlocks<double> fast_sweeping_blocks;
}  // namespace serial

namespace openmp {
FastSweeping<float> fast_sweeping_sweeps;
FastSweepingInBlocks<float> fast_sweeping_blocks;
}  // namespace openmp

}  // namespace lockstep::levelset
