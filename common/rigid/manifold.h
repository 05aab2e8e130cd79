// Contacts: where and how deep two colliders touch.
#pragma once

#include <cstdint>
#include <vector>

#include "common/rigid/pairs.h"
#include "common/vector3.h"

namespace lockstep::rigid {

inline constexpr int most_points = 4;

template <class Real>
struct ContactPoint {
  Vector3<Real> position;  // m, in the world: midway between the two surfaces
  Real separation;         // m, along the normal; negative where the colliders penetrate each other
};

// What one pair of colliders has: up to four points that share a normal. The order of points follows from the
// shapes alone. Aligned to lanes' records: in float 32 words, four records of eight.
template <class Real>
struct alignas(8 * sizeof(Real)) Manifold {
  Vector3<Real> normal;  // unit, from a to b
  std::int32_t count;    // points, 0 .. 4; those beyond are all zero; where it is 0, the normal holds nothing
  std::int32_t a, b;     // colliders
  std::int32_t unused[2];
  ContactPoint<Real> point[most_points];
  std::int32_t feature[most_points];  // which corner, edge or face each point comes from: the same in the next step
  std::int32_t more_unused[4];
};
static_assert(sizeof(Manifold<float>) == 128);

}  // namespace lockstep::rigid
