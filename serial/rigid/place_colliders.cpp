// Puts colliders where their bodies are and draws a box along the world's axes around each.
//
// A collider's pose is its body's times its own. A sphere's point, a capsule's segment and a cube fill the box along their own axes:
// turned, that reaches along a world axis as far as the sum over its sides of |share of that axis| times half the side, and costs three
// absolute values. A hull leaves much of that box empty, so its vertices are turned one by one: two products and a comparison more for each
// pay many times over in pairs that need no narrow phase. All get the smallest box there is.
//
// Source: [LRB08] Figure 5; the turned box, Ericson, Real-Time Collision Detection (2005), 4.2.6. The contract stands in
// common/rigid/place_colliders.h.
#include "common/math.h"
#include "common/real.h"
#include "common/rigid/place_colliders.h"
#include "common/rigid/place.h"

namespace lockstep::rigid::serial {
namespace {

Vector3<Real> position(const Quad<Real>& quad) { return {quad.x, quad.y, quad.z}; }

Box<Real> box_around_vertices(const Hulls<Real>& hulls, int hull, const Pose<Real>& pose, const Quad<Real>& size, Real widening) {
  const Matrix3<Real> m = matrix_of(pose.orientation);
  Box<Real> box = empty_box<Real>;
  for (int k = 0; k < hulls.vertices(hull); ++k) reach_to(box, m, position(size), position(hulls.vertex[hulls.first_vertex[hull] + k]));
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
    if (colliders.hull[i] < 0) {
      bounds.set(i, whole_space<Real>);
      continue;
    }
    const int hull = colliders.hull[i];
    const Quad<Real>& size = colliders.size[i];
    const Real widening = size.w + margin;
    if (fills_its_box(hull))
      bounds.set(i, box_around<Real>(pose, position(size), position(hulls.centre[hull]), position(hulls.half[hull]), widening));
    else
      bounds.set(i, box_around_vertices(hulls, hull, pose, size, widening));
  }
}

}  // namespace lockstep::rigid::serial
