// Planes against everything: they are unbounded, so the other broad phases do not pair them.
//
// A box reaches below a plane if its lowest corner does; the signs of the normal say which corner that is. There are
// few planes, so every box is tested against each plane. The pairs of a collider are made together, where it is the
// smaller of the two numbers: this gives the order of the contract.
//
// Source: Ericson, Real-Time Collision Detection (2005), 5.2.3. The contract stands in common/rigid/broad_phase.h.
#include "common/math.h"
#include "common/real.h"
#include "common/rigid/broad_phase.h"
#include "common/rigid/reach.h"

namespace lockstep::rigid::serial {
namespace {

struct Plane {
  std::int32_t collider, group;
  Vector3<Real> normal, point;
};

std::vector<Plane> planes_of(const Colliders<Real>& colliders, std::span<const Pose<Real>> placed) {
  std::vector<Plane> planes;
  for (int i = 0; i < colliders.count; ++i)
    if (colliders.kind[i] == static_cast<std::int32_t>(Kind::plane))
      planes.push_back({i, colliders.group[i], matrix_of(placed[i].orientation).y, placed[i].position});
  return planes;
}

}  // namespace

void plane_pairs(const Colliders<Real>& colliders, std::span<const Pose<Real>> placed, const Bounds<Real>& bounds,
                 Pairs& pairs) {
  const std::vector<Plane> planes = planes_of(colliders, placed);
  const auto touch = [&](const Plane& plane, int i) {
    return bounds.bounded(i) && lowest_corner(bounds.box(i), plane.normal, plane.point) <= 0 &&
           plane.group != colliders.group[i];
  };

  pairs.clear();
  int begin = 0;
  for (std::size_t p = 0; p <= planes.size(); ++p) {
    // Colliders before the next plane, each with that plane and all later ones; then that plane with all later
    // colliders.
    const int end = p < planes.size() ? planes[p].collider : colliders.count;
    for (int i = begin; i < end; ++i)
      for (std::size_t q = p; q < planes.size(); ++q)
        if (touch(planes[q], i)) pairs.push_back({i, planes[q].collider});
    if (p < planes.size())
      for (int i = end + 1; i < colliders.count; ++i)
        if (touch(planes[p], i)) pairs.push_back({planes[p].collider, i});
    begin = end + 1;
  }
}

}  // namespace lockstep::rigid::serial
