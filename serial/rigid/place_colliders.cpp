// Puts colliders where their bodies are and draws a box along the world's axes around each.
//
// A collider's pose is its body's times its own. The box comes from the box along the hull's axes, which never changes: turned, it reaches
// along a world axis as far as the sum over its sides of |share of that axis| times half the side. So a hull of 64 vertices costs as
// much as a cube; the price is a box that is larger than need be by what the hull leaves of its own box's corners. A sphere, whose hull is
// a point, and a capsule get the smallest box there is.
//
// Source: [LRB08] Figure 5; the turned box, Ericson, Real-Time Collision Detection (2005), 4.2.6. The contract stands in
// common/rigid/bounds.h.
#include "common/math.h"
#include "common/real.h"
#include "common/rigid/bounds.h"
#include "common/rigid/place.h"

namespace lockstep::rigid::serial {

void place_colliders(const World<Real>& world, Real margin, Array<Pose<Real>>& placed, Bounds<Real>& bounds) {
  const Colliders<Real>& colliders = world.colliders;
  const Hulls<Real>& hulls = world.hulls;
  placed.resize(padded(colliders.count));
  bounds.resize(colliders.count);

  for (int i = 0; i < colliders.count; ++i) {
    const Pose<Real> pose = in_world(world.bodies.pose[colliders.body[i]], colliders.local[i]);
    placed[i] = pose;
    if (colliders.hull[i] < 0) {
      bounds.set(i, whole_space<Real>);
      continue;
    }
    const Quad<Real>&size = colliders.size[i], &centre = hulls.centre[colliders.hull[i]], &half = hulls.half[colliders.hull[i]];
    bounds.set(i,
               box_around<Real>(pose, {size.x, size.y, size.z}, {centre.x, centre.y, centre.z}, {half.x, half.y, half.z}, size.w + margin));
  }
}

}  // namespace lockstep::rigid::serial
