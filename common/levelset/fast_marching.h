// Contract: distances of all points within `band` of the interface, by the Fast Marching Method.
//
// First-order upwind (common/levelset/eikonal.h) from the interface points, whose distances are fixed. Points farther
// than `band` come out `far`; an infinite band reaches all points.
//
//   heap     the trial point nearest to the interface is accepted next; a binary heap finds it.
//   blocks   the grid is cut into blocks of `size` points a side (common/levelset/blocks.h), each padded by the band
//            and a little more; each block is marched on its own.
//
// In, out: distances, as initialize leaves them.
// In:      band, m, > 0; size, > 0.
// Errors:  std::bad_alloc.
// Source:  [ITJ07] Figures 6 and 7; Sethian, A fast marching level set method for monotonically advancing fronts, PNAS
//          93 (1996).
#pragma once

#include "common/levelset/field.h"

namespace lockstep::levelset {

template <class Real>
using FastMarching = void(Distances<Real>& distances, Real band);
template <class Real>
using FastMarchingInBlocks = void(Distances<Real>& distances, Real band, int size);

namespace serial {
FastMarching<float> fast_marching_heap;
FastMarching<double> fast_marching_heap;
FastMarchingInBlocks<float> fast_marching_blocks;
FastMarchingInBlocks<double> fast_marching_blocks;
}  // namespace serial

namespace openmp {
FastMarchingInBlocks<float> fast_marching_blocks;
}  // namespace openmp

}  // namespace lockstep::levelset
