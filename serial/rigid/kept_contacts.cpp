// Contacts that are kept: refreshed where a pair has hardly moved, and put into the axes of their bodies where they
// have been found anew.
//
// The contract stands in common/rigid/kept_contacts.h.
#include "common/rigid/kept_contacts.h"

#include "common/real.h"

namespace lockstep::rigid::serial {
namespace {

PairPoses<Real> poses_of(const Placed<Real>& placed, const Pair& pair) {
  return pair_poses(placed.pose[pair.a], placed.pose[pair.b]);
}

Real reach_of_collider(const Placed<Real>& placed, int collider) {
  const int hull = placed.colliders.hull[collider];
  return reach_of(placed.colliders.size[collider], placed.hulls.centre[hull], placed.hulls.half[hull]);
}

KeptContact<Real> kept_contact(const Placed<Real>& placed, const Pair& pair, const Manifold<Real>& manifold) {
  const PairPoses<Real> poses = poses_of(placed, pair);
  KeptContact<Real> kept = {};
  kept.b_in_a = poses.b_in_a;
  if (manifold.count > 0) kept.normal = transposed_times(poses.axes_a, manifold.normal);
  kept.count = manifold.count;
  kept.reach_a = reach_of_collider(placed, pair.a), kept.reach_b = reach_of_collider(placed, pair.b);
  for (int k = 0; k < manifold.count; ++k) {
    kept.point[k] = kept_point(poses, manifold.normal, manifold.point[k]);
    kept.feature[k] = manifold.feature[k];
  }
  return kept;
}

Manifold<Real> refreshed(const PairPoses<Real>& poses, const Pair& pair, const KeptContact<Real>& kept) {
  Manifold<Real> manifold = {};
  manifold.normal = poses.axes_a * kept.normal;
  manifold.count = kept.count;
  manifold.a = pair.a, manifold.b = pair.b;
  for (int k = 0; k < kept.count; ++k) {
    manifold.point[k] = refreshed_point(poses, manifold.normal, kept.point[k]);
    manifold.feature[k] = kept.feature[k];
  }
  return manifold;
}

}  // namespace

void refresh_contacts(const Placed<Real>& placed, std::span<const Pair> pairs, std::span<const KeptContact<Real>> last,
                      Real tolerance, std::span<std::int32_t> of_last, std::span<Manifold<Real>> manifolds,
                      std::span<KeptContact<Real>> next) {
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (of_last[k] < 0) continue;
    const PairPoses<Real> poses = poses_of(placed, pairs[k]);
    const KeptContact<Real>& contact = last[of_last[k]];
    const Real moved = moved_since(contact.b_in_a, poses.b_in_a, contact.reach_a, contact.reach_b);
    if (moved <= tolerance) {
      manifolds[k] = refreshed(poses, pairs[k], contact);
      next[k] = contact;
    } else {
      of_last[k] = -1;
    }
  }
}

void keep_contacts(const Placed<Real>& placed, std::span<const Pair> pairs, std::span<const std::int32_t> which,
                   std::span<const Manifold<Real>> manifolds, std::span<KeptContact<Real>> contacts) {
  for (std::size_t k = 0; k < pairs.size(); ++k)
    contacts[which[k]] = kept_contact(placed, pairs[k], manifolds[which[k]]);
}

}  // namespace lockstep::rigid::serial
