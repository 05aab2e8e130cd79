// Contract: the points beside the interface phi = 0, and their distances from it.
//
// A point is beside the interface if phi there is 0 or has another sign (of the three -, 0, +) than at one of its up to
// six neighbours. Along that axis the interface is at theta = |phi| / (|phi| + |phi of the neighbour|) of the spacing.
// Take the nearest crossing along each axis that has one: the plane through them is at the distance 1 / sqrt(sum 1 /
// theta^2). This is exact, whatever the slope of phi, for a plane with a crossing along each axis that it is not
// parallel to; otherwise it is too large by less than h. All other points come out `far`.
//
// In:      phi, finite, < 0 inside; it need not be a distance.
// Out:     distances, of the same size: distance (m) and interface.
// Errors:  std::bad_alloc.
// Source:  [ITJ07] uses the distances "for a narrow band around the interface"; the formula is from Adalsteinsson and
//          Sethian, The fast construction of extension velocities in level set methods, J. Comput. Phys. 148 (1999).
#pragma once

#include "common/levelset/field.h"

namespace lockstep::levelset {

template <class Real>
using Initialize = void(const Field<Real>& phi, Distances<Real>& distances);

namespace serial {
Initialize<float> initialize;
Initialize<double> initialize;
}  // namespace serial

namespace openmp {
Initialize<float> initialize;
}  // namespace openmp

}  // namespace lockstep::levelset
