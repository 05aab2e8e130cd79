// Contacts that are kept: refreshed where a pair has hardly moved, and put into the axes of their bodies where they
// have been found anew. Sixteen pairs at a time.
//
// A kept contact is five records of eight numbers, which lanes load and store whole ([LRB08] Figure 12).
//
// The contract stands in common/rigid/kept_contacts.h.
#include "common/rigid/kept_contacts.h"

#include <algorithm>

#include "common/real.h"
#include "common/simd.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {
namespace {

// The five records of a kept contact.
struct KeptLanes {
  Pose<floatv> b_in_a;
  Vector3<floatv> normal;
  intv count;
  floatv reach_a, reach_b;
  ContactPoint<floatv> point[most_points];
  intv feature[most_points];
};

Indices record_of(const Indices& contacts, int part) { return indices_of(load(contacts.index) * 5 + part); }

LOCKSTEP_INLINE KeptLanes load_kept(std::span<const KeptContact<float>> contacts, const Indices& indices) {
  const auto get = [&](int part) {
    return load_records(&contacts.data()->b_in_a.position.x, record_of(indices, part).index);
  };
  KeptLanes kept;
  const auto [x, y, z, qx, qy, qz, qw, unused] = get(0).field;
  kept.b_in_a = {{x, y, z}, {qx, qy, qz, qw}, unused};
  const auto [nx, ny, nz, count, reach_a, reach_b, u0, u1] = get(1).field;
  kept.normal = {nx, ny, nz}, kept.count = bits_of(count), kept.reach_a = reach_a, kept.reach_b = reach_b;
  for (int k = 0; k < most_points; k += 2) {
    const auto [px, py, pz, p, rx, ry, rz, r] = get(2 + k / 2).field;
    kept.point[k] = {{px, py, pz}, p}, kept.point[k + 1] = {{rx, ry, rz}, r};
  }
  const Records features = get(4);
  for (int k = 0; k < most_points; ++k) kept.feature[k] = bits_of(features.field[k]);
  return kept;
}

LOCKSTEP_INLINE void store_kept(std::span<KeptContact<float>> contacts, const Indices& indices, const KeptLanes& kept,
                                maskv mask) {
  const auto put = [&](int part, const Records& record) {
    store_records(&contacts.data()->b_in_a.position.x, record_of(indices, part).index, record, mask);
  };
  const auto& [p, q, unused] = kept.b_in_a;
  put(0, {{p.x, p.y, p.z, q.x, q.y, q.z, q.w, 0.f}});
  put(1,
      {{kept.normal.x, kept.normal.y, kept.normal.z, float_of_bits(kept.count), kept.reach_a, kept.reach_b, 0.f, 0.f}});
  for (int k = 0; k < most_points; k += 2) {
    const auto& [a, s] = kept.point[k];
    const auto& [b, t] = kept.point[k + 1];
    put(2 + k / 2, {{a.x, a.y, a.z, s, b.x, b.y, b.z, t}});
  }
  const auto& f = kept.feature;
  put(4, {{float_of_bits(f[0]), float_of_bits(f[1]), float_of_bits(f[2]), float_of_bits(f[3]), 0.f, 0.f, 0.f, 0.f}});
}

PairPoses<floatv> poses_of(const Placed<Real>& placed, const PairLanes& pairs) {
  return pair_poses(load_pose(placed.pose, pairs.a), load_pose(placed.pose, pairs.b));
}

floatv reach_of_collider(const Placed<Real>& placed, const Indices& colliders) {
  const Indices hull = indices_of(gather(placed.colliders.hull.data(), load(colliders.index)));
  return reach_of(load_quad(placed.colliders.size, colliders), load_quad(placed.hulls.centre, hull),
                  load_quad(placed.hulls.half, hull));
}

KeptLanes kept_contact(const Placed<Real>& placed, const PairLanes& pairs, const ManifoldLanes& manifolds) {
  const PairPoses<floatv> poses = poses_of(placed, pairs);
  const Vector3<floatv> zero = {0.f, 0.f, 0.f};
  KeptLanes kept;
  kept.b_in_a = poses.b_in_a;
  kept.normal = select(manifolds.count > 0, transposed_times(poses.axes_a, manifolds.normal), zero);
  kept.count = manifolds.count;
  kept.reach_a = reach_of_collider(placed, pairs.a), kept.reach_b = reach_of_collider(placed, pairs.b);
  for (int k = 0; k < most_points; ++k) {
    const auto [position, separation] =
        kept_point(poses, manifolds.normal, {manifolds.position[k], manifolds.separation[k]});
    const maskv is_there = manifolds.count > k;
    kept.point[k] = {select(is_there, position, zero), select(is_there, separation, floatv(0.f))};
    kept.feature[k] = select(is_there, manifolds.feature[k], intv(0));
  }
  return kept;
}

ManifoldLanes refreshed(const PairPoses<floatv>& poses, const PairLanes& pairs, const KeptLanes& kept) {
  ManifoldLanes manifolds;
  manifolds.normal = poses.axes_a * kept.normal;
  manifolds.count = kept.count;
  manifolds.a = load(pairs.a.index), manifolds.b = load(pairs.b.index);
  for (int k = 0; k < most_points; ++k) {
    const auto [position, separation] = refreshed_point(poses, manifolds.normal, kept.point[k]);
    const maskv is_there = kept.count > k;
    manifolds.position[k] = select(is_there, position, {0.f, 0.f, 0.f});
    manifolds.separation[k] = select(is_there, separation, floatv(0.f));
    manifolds.feature[k] = kept.feature[k];
  }
  return manifolds;
}

}  // namespace

void refresh_contacts(const Placed<Real>& placed, std::span<const Pair> pairs, std::span<const KeptContact<Real>> last,
                      Real tolerance, std::span<std::int32_t> of_last, std::span<Manifold<Real>> manifolds,
                      std::span<KeptContact<Real>> next) {
  const int n = static_cast<int>(pairs.size());
  // Sixteen pairs, with all that belongs to them, are one thread's.
#pragma omp parallel for schedule(static)
  for (int k = 0; k < n; k += lanes) {
    const maskv are_there = first_lanes(n - k);
    const intv other = load(&of_last[k], are_there);
    const maskv known = are_there & (other >= 0);
    if (none(known)) continue;
    const PairLanes in_lanes = load_pairs(pairs.subspan(k));
    const PairPoses<floatv> poses = poses_of(placed, in_lanes);
    const KeptLanes contact = load_kept(last, indices_of(max(other, 0)));
    const floatv moved = moved_since(contact.b_in_a, poses.b_in_a, contact.reach_a, contact.reach_b);
    const maskv keeps = known & (moved <= tolerance);
    store(&of_last[k], select(keeps, other, intv(-1)), are_there);
    store_manifolds(manifolds, sixteen(k), refreshed(poses, in_lanes, contact), keeps);
    store_kept(next, sixteen(k), contact, keeps);
  }
}

void keep_contacts(const Placed<Real>& placed, std::span<const Pair> pairs, std::span<const std::int32_t> which,
                   std::span<const Manifold<Real>> manifolds, std::span<KeptContact<Real>> contacts) {
  const int n = static_cast<int>(pairs.size());
  // Each pair has one lane of one thread, which writes its contact.
#pragma omp parallel for schedule(static)
  for (int k = 0; k < n; k += lanes) {
    const maskv are_there = first_lanes(n - k);
    const PairLanes in_lanes = load_pairs(pairs.subspan(k));
    const Indices to = indices_of(load(&which[k], are_there));
    store_kept(contacts, to, kept_contact(placed, in_lanes, load_manifolds(manifolds, to)), are_there);
  }
}

}  // namespace lockstep::rigid::openmp
