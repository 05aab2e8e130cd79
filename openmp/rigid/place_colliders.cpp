// Places colliders with their bodies and computes the box along the world's axes around each.
//
// A collider's pose is its body's pose times its local pose. A sphere's point, a capsule's segment and a cube fill the
// box along their own axes. The extent of such a turned box along a world axis is the sum of the half sides, each times
// the absolute value of its component along that axis: three absolute values. A hull leaves much of its box empty, so
// its vertices are turned one by one. That costs two products and a comparison more per vertex. The tighter box saves
// more in pairs that need no narrow phase. Each box is the smallest there is.
//
// Sixteen colliders are placed at once. Poses and sizes are loaded as whole records and transposed into lanes. Poses
// are stored as whole records.
//
// Source: [LRB08] Figure 5; the turned box, Ericson, Real-Time Collision Detection (2005), 4.2.6. The contract stands
// in common/rigid/place_colliders.h.
#include "common/rigid/place_colliders.h"

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/place.h"
#include "common/simd.h"
#include "openmp/rigid/lanes.h"
#include "openmp/spatial/boxes.h"

namespace lockstep::rigid::openmp {
namespace {

using namespace spatial::openmp;

// Lanes with fewer vertices than others repeat their last one.
Box<floatv> box_around_vertices(const Hulls<Real>& hulls, intv hull, const Pose<floatv>& pose, const Quad<floatv>& size,
                                floatv widening) {
  const Matrix3<floatv> m = matrix_of(pose.orientation);
  Box<floatv> box = in_all_lanes(empty_box<Real>);
  const intv first = gather(hulls.first_vertex.data(), hull), last = gather(hulls.first_vertex.data() + 1, hull) - 1;
  const int most = static_cast<int>(reduce_max(to_float(last - first)));
  for (int k = 0; k <= most; ++k) {
    const Quad<floatv> vertex = load_quad(hulls.vertex, indices_of(min(first + k, last)));
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

  // Each collider belongs to one thread.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < colliders.count; i += lanes) {
    const maskv inside = first_lanes(colliders.count - i);
    const Indices index = indices_of(select(inside, lane_index() + i, i));
    const Indices body = indices_of(load(&colliders.body[i], inside));
    const Pose<floatv> pose = in_world(load_pose(world.bodies.pose, body), load_pose(colliders.local, index));
    store_pose(placed, index, pose, inside);
    const intv hull = load(&colliders.hull[i], inside);
    const Quad<floatv> size = load_quad(colliders.size, index);
    const floatv widening = size.w + margin;
    const maskv plane = hull < 0, full = fills_its_box(hull);  // a plane has no hull: lanes of planes use the first
    const Indices of = indices_of(max(hull, 0));
    Box<floatv> box = box_around(pose, size, load_quad(hulls.centre, of), load_quad(hulls.half, of), widening);
    if (!all(full)) box = select(full, box, box_around_vertices(hulls, max(hull, 0), pose, size, widening));
    store_boxes(bounds, i, select(plane, in_all_lanes(whole_space<Real>), box));
  }
}

}  // namespace lockstep::rigid::openmp
