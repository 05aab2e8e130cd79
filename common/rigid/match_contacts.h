// Contract: the impulses of the last step, for the contacts of this one.
//
// A point is the same as one of the last step if the same two colliders have it and its feature is the same; or, where none has its
// feature, if it is the nearest of those left over, and within `same_place`: where two corners coincide, as in a stack of equal boxes,
// rounding decides from step to step which of them is the point, and without this a tower of ten lost its impulses often enough to sway and
// fall. Its impulses are where the solver starts; those of a new point are 0.
//
// In: the manifolds and impulses of the last step, and the manifolds of this one, each in the order of pairs, each pair once. Out:
// impulses, of every manifold, also of points that are not there (0). Source: [LRB08] "Rigid Body Simulation" leaves it open; Catto,
// Iterative Dynamics with Temporal Coherence (GDC 2005).
#pragma once

#include <span>

#include "common/rigid/contact_solver.h"

namespace lockstep::rigid {

inline constexpr double same_place = .02;  // m

template <class Real>
using MatchContacts = void(std::span<const Manifold<Real>> last, std::span<const Impulses<Real>> last_impulses,
                           std::span<const Manifold<Real>> manifolds, std::span<Impulses<Real>> impulses);

template <class Real>
inline Pair pair_of(const Manifold<Real>& m) {
  return {m.a, m.b};
}

namespace serial {
MatchContacts<float> match_contacts;
MatchContacts<double> match_contacts;
}  // namespace serial

namespace openmp {
MatchContacts<float> match_contacts;
}  // namespace openmp

}  // namespace lockstep::rigid
