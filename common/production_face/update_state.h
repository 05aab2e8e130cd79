// Contract: what a pose makes of each tetrahedron: the rotations of its strain, its energy, its stress, and the
// stress's derivative.
//
//   F = U diag(s) V^T                  svd.h
//   P = flesh (flesh_material.h) + each muscle fibre (muscle.h)
//   derivative of the flesh's P in the frames of U and V, and of each fibre's by itself
//
// With `definite`, the derivative has no negative eigenvalues: those of the flesh become 0, and so does a negative
// slope of a fibre's tension. Newton's method then goes downhill everywhere, but converges only linearly.
//
// In:  body; flesh with moduli up to those of Flesh; pose, finite, with entries of F up to 39. There, the energy of
//      a tetrahedron that is turned inside out comes near the greatest float.
// Out: strained, of the body's size: all of it, the elements that fill up the last block included.
// Source: [ITJ07] "Production Face"; Teran, Sifakis, Irving and Fedkiw, Robust quasistatic finite elements and flesh
//         simulation, SCA 2005.
#pragma once

#include "common/production_face/body.h"
#include "common/production_face/element.h"

namespace lockstep::production_face {

template <class Real>
using UpdateState = void(const Body<Real>& body, const Flesh& flesh, const Pose<Real>& pose, bool definite,
                         Strained<Real>& strained);

namespace serial {
UpdateState<float> update_state;
UpdateState<double> update_state;
}  // namespace serial

namespace openmp {
UpdateState<float> update_state;
}  // namespace openmp

}  // namespace lockstep::production_face
