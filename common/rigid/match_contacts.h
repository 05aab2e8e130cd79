// Contract: finds the impulses of the last step for the contacts of this one.
//
// A point is the same as one of the last step if the same two colliders have it and its feature is the same. A point
// with a new feature takes the nearest of the points left over, if that is within `same_place`. Where two corners
// coincide, as in a stack of equal boxes, rounding decides from step to step which of them is the point. Without this
// rule a tower of ten lost its impulses often enough to sway and fall. The solver starts with these impulses (warm
// start). New points start with 0.
//
// In: the manifolds and impulses of the last step, and the manifolds of this one. Both are in the order of pairs, each
// pair once. Out: the impulses of every manifold, 0 for points that are not there. Source: [LRB08] "Rigid Body
// Simulation" leaves it open; Catto, Iterative Dynamics with Temporal Coherence (GDC 2005).
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

// The impulses for the points of `m` from a manifold of the same two colliders in the last step.
template <class Real>
inline Impulses<Real> matched(const Manifold<Real>& last, const Impulses<Real>& from, const Manifold<Real>& m) {
  Impulses<Real> impulses{};
  bool taken[most_points] = {}, matched[most_points] = {};
  const auto take = [&](int k, int j) {
    impulses.normal[k] = from.normal[j];
    impulses.tangent[k] = from.tangent[j];
    impulses.bitangent[k] = from.bitangent[j];
    taken[j] = matched[k] = true;
  };
  for (int k = 0; k < m.count; ++k)
    for (int j = 0; j < last.count; ++j)
      if (!taken[j] && last.feature[j] == m.feature[k] && !matched[k]) take(k, j);
  for (int k = 0; k < m.count; ++k) {
    if (matched[k]) continue;
    int nearest = -1;
    Real least = static_cast<Real>(same_place * same_place);
    for (int j = 0; j < last.count; ++j) {
      const Vector3<Real> off = m.point[k].position - last.point[j].position;
      if (!taken[j] && dot(off, off) < least) nearest = j, least = dot(off, off);
    }
    if (nearest >= 0) take(k, nearest);
  }
  return impulses;
}

namespace serial {
MatchContacts<float> match_contacts;
MatchContacts<double> match_contacts;
}  // namespace serial

namespace openmp {
MatchContacts<float> match_contacts;
}  // namespace openmp

}  // namespace lockstep::rigid
