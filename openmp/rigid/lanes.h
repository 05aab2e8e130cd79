// Sixteen colliders into lanes, and sixteen manifolds out of them: whole records, where a gather or a scatter a field would be
// an access a number ([LRB08] Figure 12).
#pragma once

#include <bit>
#include <span>

#include "common/rigid/manifold.h"
#include "common/rigid/world.h"
#include "common/simd.h"

namespace lockstep::rigid::openmp {

// The bits of integers among the floats of a record, and back.
LOCKSTEP_INLINE floatv as_float(intv v) { return std::bit_cast<floatv>(v); }
LOCKSTEP_INLINE intv as_int(floatv v) { return std::bit_cast<intv>(v); }

// Which records lanes read or write.
struct alignas(array_alignment) Indices {
  std::int32_t index[lanes];
};

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
    for (int l = 1; l < static_cast<int>(pairs.size()); ++l) result.a.index[l] = pairs[l].a, result.b.index[l] = pairs[l].b;
  }
  return result;
}

// pose[index[l]] in lane l.
struct PoseLanes {
  Vector3<floatv> position;
  Quaternion<floatv> orientation;
};
LOCKSTEP_INLINE PoseLanes load_poses(std::span<const Pose<float>> pose, const Indices& indices) {
  const auto [x, y, z, qx, qy, qz, qw, unused] = load_records(&pose.data()->position.x, indices.index).field;
  return {{x, y, z}, {qx, qy, qz, qw}};
}

// quad[index[l]] in lane l.
LOCKSTEP_INLINE Quad<floatv> load_quads(const Array<Quad<float>>& quad, const Indices& indices) {
  const auto [x, y, z, w] = lockstep::load_quads(&quad.data()->x, indices.index).field;
  return {x, y, z, w};
}

// A manifold a lane. Points beyond the count are zero, so that equal manifolds have equal bytes.
struct ManifoldLanes {
  Vector3<floatv> normal;
  intv count, a, b;
  Vector3<floatv> position[most_points];
  floatv separation[most_points];
  intv feature[most_points];
};

// manifolds[index[l]] = lane l of m, where active; active indices differ.
LOCKSTEP_INLINE void store_manifolds(std::span<Manifold<float>> manifolds, const Indices& indices, const ManifoldLanes& m, maskv mask) {
  const auto put = [&](int part, const Records& record) {
    Indices records;
    store(records.index, load(indices.index) * 4 + part);
    store_records(&manifolds.data()->normal.x, records.index, record, mask);
  };
  put(0, {{m.normal.x, m.normal.y, m.normal.z, as_float(m.count), as_float(m.a), as_float(m.b), 0.f, 0.f}});
  for (int k = 0; k < most_points; k += 2) {
    const Vector3<floatv>&p = m.position[k], &q = m.position[k + 1];
    put(1 + k / 2, {{p.x, p.y, p.z, m.separation[k], q.x, q.y, q.z, m.separation[k + 1]}});
  }
  const auto& f = m.feature;
  put(3, {{as_float(f[0]), as_float(f[1]), as_float(f[2]), as_float(f[3]), 0.f, 0.f, 0.f, 0.f}});
}

}  // namespace lockstep::rigid::openmp
