// Sixteen records into lanes and back: poses, motions, quads and manifolds. Each record is one access; a gather or a
// scatter of each field would be one access a number ([LRB08] Figure 12).
#pragma once

#include <span>

#include "common/rigid/manifold.h"
#include "common/rigid/world.h"
#include "common/simd.h"

namespace lockstep::rigid::openmp {

// Which records lanes read or write.
struct alignas(array_alignment) Indices {
  std::int32_t index[lanes];
};
LOCKSTEP_INLINE Indices indices_of(intv v) {
  Indices indices;
  store(indices.index, v);
  return indices;
}
// i .. i + 15.
LOCKSTEP_INLINE Indices sixteen(int i) { return indices_of(lane_index() + i); }

// Colliders of up to sixteen pairs; lanes beyond the last pair repeat the first, so that they may be loaded.
struct PairLanes {
  Indices a, b;
};
inline PairLanes load_pairs(std::span<const Pair> pairs) {
  PairLanes result;
  if (pairs.size() >= lanes) {
    for (int l = 0; l < lanes; ++l) result.a.index[l] = pairs[l].a, result.b.index[l] = pairs[l].b;
  } else {
    store(result.a.index, pairs[0].a), store(result.b.index, pairs[0].b);
    for (int l = 1; l < static_cast<int>(pairs.size()); ++l) {
      result.a.index[l] = pairs[l].a, result.b.index[l] = pairs[l].b;
    }
  }
  return result;
}

// The pairs of number which.index[l].
inline PairLanes load_pairs(std::span<const Pair> pairs, const Indices& which) {
  PairLanes result;
  for (int l = 0; l < lanes; ++l)
    result.a.index[l] = pairs[which.index[l]].a, result.b.index[l] = pairs[which.index[l]].b;
  return result;
}

// In lane l, the record of number indices.index[l]. A store writes active lanes alone, whose numbers differ.
LOCKSTEP_INLINE Quad<floatv> load_quad(std::span<const Quad<float>> quad, const Indices& indices) {
  const auto [x, y, z, w] = load_quads(&quad.data()->x, indices.index).field;
  return {x, y, z, w};
}

LOCKSTEP_INLINE Pose<floatv> load_pose(std::span<const Pose<float>> pose, const Indices& indices) {
  const auto [x, y, z, qx, qy, qz, qw, unused] = load_records(&pose.data()->position.x, indices.index).field;
  return {{x, y, z}, {qx, qy, qz, qw}, unused};
}
LOCKSTEP_INLINE void store_pose(std::span<Pose<float>> pose, const Indices& indices, const Pose<floatv>& value,
                                maskv mask) {
  const auto& [p, q, unused] = value;
  store_records(&pose.data()->position.x, indices.index, {{p.x, p.y, p.z, q.x, q.y, q.z, q.w, unused}}, mask);
}
// The position alone: the first half of each record.
LOCKSTEP_INLINE Vector3<floatv> load_position(std::span<const Pose<float>> pose, const Indices& indices) {
  const Indices halves = indices_of(load(indices.index) * 2);
  const auto [x, y, z, unused] = load_quads(&pose.data()->position.x, halves.index).field;
  return {x, y, z};
}

LOCKSTEP_INLINE Motion<floatv> load_motion(std::span<const Motion<float>> motion, const Indices& indices) {
  const auto [x, y, z, wx, wy, wz, u0, u1] = load_records(&motion.data()->velocity.x, indices.index).field;
  return {{x, y, z}, {wx, wy, wz}, {u0, u1}};
}
LOCKSTEP_INLINE void store_motion(std::span<Motion<float>> motion, const Indices& indices, const Motion<floatv>& value,
                                  maskv mask) {
  const auto& [v, w, unused] = value;
  store_records(&motion.data()->velocity.x, indices.index, {{v.x, v.y, v.z, w.x, w.y, w.z, unused[0], unused[1]}},
                mask);
}

// A manifold a lane. Points beyond the count are zero, so that equal manifolds have equal bytes.
struct ManifoldLanes {
  Vector3<floatv> normal;
  intv count, a, b;
  Vector3<floatv> position[most_points];
  floatv separation[most_points];
  intv feature[most_points];
};

LOCKSTEP_INLINE ManifoldLanes load_manifolds(std::span<const Manifold<float>> manifolds, const Indices& indices) {
  const auto get = [&](int part) {
    const Indices records = indices_of(load(indices.index) * 4 + part);
    return load_records(&manifolds.data()->normal.x, records.index);
  };
  ManifoldLanes m;
  const auto [x, y, z, count, a, b, u0, u1] = get(0).field;
  m.normal = {x, y, z}, m.count = bits_of(count), m.a = bits_of(a), m.b = bits_of(b);
  for (int k = 0; k < most_points; k += 2) {
    const auto [px, py, pz, p, qx, qy, qz, q] = get(1 + k / 2).field;
    m.position[k] = {px, py, pz}, m.separation[k] = p, m.position[k + 1] = {qx, qy, qz}, m.separation[k + 1] = q;
  }
  const Records features = get(3);
  for (int k = 0; k < most_points; ++k) m.feature[k] = bits_of(features.field[k]);
  return m;
}

// manifolds[index[l]] = lane l of m, where active; active indices differ.
LOCKSTEP_INLINE void store_manifolds(std::span<Manifold<float>> manifolds, const Indices& indices,
                                     const ManifoldLanes& m, maskv mask) {
  const auto put = [&](int part, const Records& record) {
    const Indices records = indices_of(load(indices.index) * 4 + part);
    store_records(&manifolds.data()->normal.x, records.index, record, mask);
  };
  put(0,
      {{m.normal.x, m.normal.y, m.normal.z, float_of_bits(m.count), float_of_bits(m.a), float_of_bits(m.b), 0.f, 0.f}});
  for (int k = 0; k < most_points; k += 2) {
    const Vector3<floatv>&p = m.position[k], &q = m.position[k + 1];
    put(1 + k / 2, {{p.x, p.y, p.z, m.separation[k], q.x, q.y, q.z, m.separation[k + 1]}});
  }
  const auto& f = m.feature;
  put(3, {{float_of_bits(f[0]), float_of_bits(f[1]), float_of_bits(f[2]), float_of_bits(f[3]), 0.f, 0.f, 0.f, 0.f}});
}

}  // namespace lockstep::rigid::openmp
