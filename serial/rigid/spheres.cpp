// Sphere or capsule against sphere, capsule or box, one pair after another. The formulas and how they work:
// common/rigid/round_contacts.h.
//
// Works relative to collider a, or in the axes of the box. The contract stands in common/rigid/narrow_phase.h.
#include <cstddef>

#include "common/real.h"
#include "common/rigid/narrow_phase.h"
#include "common/rigid/round_contacts.h"

namespace lockstep::rigid::serial {

void spheres(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin,
             std::span<Manifold<Real>> manifolds) {
  const Colliders<Real>& colliders = placed.colliders;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [a, b] = pairs[k];
    const Kind kind_a = static_cast<Kind>(colliders.kind[a]), kind_b = static_cast<Kind>(colliders.kind[b]);
    const RoundForm form = round_form(kind_a, kind_b);
    const bool box = form == RoundForm::box_point || form == RoundForm::box_segment, turned = kind_b == Kind::box;
    const int first = turned ? b : a, second = turned ? a : b;
    const Pose<Real>&pose_a = placed.pose[first], &pose_b = placed.pose[second];
    const Quad<Real>&size_a = colliders.size[first], &size_b = colliders.size[second];

    const Vector3<Real> d = pose_b.position - pose_a.position;
    RoundContact<Real> contact;
    if (box) {
      const Matrix3<Real> axes = matrix_of(pose_a.orientation);
      const Vector3<Real> half = {size_a.x, size_a.y, size_a.z}, c = transposed_times(axes, d);
      if (form == RoundForm::box_point)
        contact = contact_of_box_and_point(half, c, size_b.w);
      else
        contact = contact_of_box_and_segment(half, c, transposed_times(axes, matrix_of(pose_b.orientation).y), size_b.y,
                                             size_b.w);
      contact.normal = axes * contact.normal;
      contact.position[0] = axes * contact.position[0], contact.position[1] = axes * contact.position[1];
    } else if (form == RoundForm::segments) {
      contact = contact_of_segments(d, matrix_of(pose_a.orientation).y, size_a.y, matrix_of(pose_b.orientation).y,
                                    size_b.y, size_a.w, size_b.w);
    } else {
      contact = contact_of_points(d, size_a.w, size_b.w);
    }

    Manifold<Real> manifold = {};
    manifold.normal = turned ? -contact.normal : contact.normal;
    manifold.a = a, manifold.b = b;
    for (int end = 0; end <= static_cast<int>(contact.two); ++end)
      if (contact.separation[end] <= margin) {
        manifold.point[manifold.count] = {pose_a.position + contact.position[end], contact.separation[end]};
        manifold.feature[manifold.count] = contact.two ? (end == 0 ? lower_end : upper_end) : only_point;
        ++manifold.count;
      }
    manifolds[k] = manifold;
  }
}

}  // namespace lockstep::rigid::serial
