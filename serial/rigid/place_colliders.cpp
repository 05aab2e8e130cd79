// Places colliders with their bodies and computes the box along the world's axes around each.
//
// A collider's pose is its body's pose times its local pose. A sphere's point, a capsule's segment and a cube fill the
// box along their own axes. The extent of such a turned box along a world axis is the sum of the half sides, each times
// the absolute value of its component along that axis: three absolute values. A hull leaves much of its box empty, so
// its vertices are turned one by one. That costs two products and a comparison more per vertex. The tighter box saves
// more in pairs that need no narrow phase. Each box is the smallest there is.
//
// Source: [LRB08] Figure 5; the turned box, Ericson, Real-Time Collision Detection (2005), 4.2.6. The contract stands
// in common/rigid/place_colliders.h.
#include "common/rigid/place_colliders.h"
#include "common/math.h"
#include "common/real.h"
#include "common/rigid/place.h"

namespace lockstep::rigid::serial {
namespace {

Box<Real> box_around_vertices(const Hulls<Real>& hulls, int hull, const Pose<Real>& pose, const Quad<Real>& size,
                              Real widening) {
  const Matrix3<Real> m = matrix_of(pose.orientation);
  Box<Real> box = empty_box<Real>;
  for (int k = 0; k < hulls.vertices(hull); ++k) {
    const Quad<Real>& vertex = hulls.vertex[hulls.first_vertex[hull] + k];
    reach_to(box, m, vector_of(size), vector_of(vertex));
  }
  return moved(box, pose.position, widening);
}

}  // namespace

void place_colliders(const World<Real>& world, Real margin, Array<Pose<Real>>& placed, Bounds<Real>& bounds) {
  const Colliders<Real>& colliders = world.colliders;
  const Hulls<Real>& hulls = world.hulls;
  placed.resize(padded(colliders.count));
  bounds.resize(colliders.count);

  for (int i = 0; i < colliders.count; ++i) {
    const Pose<Real> pose = in_world(world.bodies.pose[colliders.body[i]], colliders.local[i]);
    placed[i] = pose;
    const int hull = colliders.hull[i];
    const Quad<Real>& size = colliders.size[i];
    const Real widening = size.w + margin;
    const bool plane = hull < 0, full = fills_its_box(hull);  // a plane has no hull
    if (!plane && full)
      bounds.set(i, box_around(pose, size, hulls.centre[hull], hulls.half[hull], widening));
    else if (!plane)
      bounds.set(i, box_around_vertices(hulls, hull, pose, size, widening));
    else
      bounds.set(i, whole_space<Real>);
  }
}

}  // namespace lockstep::rigid::serial
