// Puts colliders where their bodies are and draws a box along the world's axes around each.
//
// A collider's pose is its body's times its own. A sphere's point, a capsule's segment and a cube fill the box along their own axes:
// turned, that reaches along a world axis as far as the sum over its sides of |share of that axis| times half the side, and costs three
// absolute values. A hull leaves much of that box empty, so its vertices are turned one by one: two products and a comparison more for each
// pay many times over in pairs that need no narrow phase. All get the smallest box there is.
//
// Sixteen colliders at once: poses and sizes are loaded as whole records and turned into lanes, and poses go back as whole records.
//
// Source: [LRB08] Figure 5; the turned box, Ericson, Real-Time Collision Detection (2005), 4.2.6. The contract stands in
// common/rigid/place_colliders.h.
#include "common/rigid/place_colliders.h"

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/place.h"
#include "common/simd.h"
#include "openmp/spatial/boxes.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {
namespace {

using namespace spatial::openmp;

Vector3<floatv> position(const Quad<floatv>& quad) { return {quad.x, quad.y, quad.z}; }

Pose<floatv> load_pose(const Array<Pose<Real>>& pose, intv index) {
  Indices indices;
  store(indices.index, index);
  return load_pose(pose, indices);
}

Quad<floatv> load_quad(const Array<Quad<Real>>& quad, intv index) {
  Indices indices;
  store(indices.index, index);
  return load_quad(quad, indices);
}

// Lanes with fewer vertices than others meet their last one again.
Box<floatv> box_around_vertices(const Hulls<Real>& hulls, intv hull, const Pose<floatv>& pose, const Quad<floatv>& size, floatv widening) {
  const Matrix3<floatv> m = matrix_of(pose.orientation);
  Box<floatv> box = in_all_lanes(empty_box<Real>);
  const intv first = gather(hulls.first_vertex.data(), hull), last = gather(hulls.first_vertex.data() + 1, hull) - 1;
  const int most = static_cast<int>(reduce_max(to_float(last - first)));
  for (int k = 0; k <= most; ++k) {
    const intv vertex = first + k;
    reach_to(box, m, position(size), position(load_quad(hulls.vertex, select(vertex < last, vertex, last))));
  }
  return moved(box, pose.position, widening);
}

void store_pose(Array<Pose<Real>>& placed, intv index, const Pose<floatv>& pose, maskv mask) {
  Indices indices;
  store(indices.index, index);
  const Vector3<floatv>& p = pose.position;
  const Quaternion<floatv>& q = pose.orientation;
  store_records(&placed.data()->position.x, indices.index, {{p.x, p.y, p.z, q.x, q.y, q.z, q.w, 0.f}}, mask);
}

}  // namespace

void place_colliders(const World<Real>& world, Real margin, Array<Pose<Real>>& placed, Bounds<Real>& bounds) {
  const Colliders<Real>& colliders = world.colliders;
  const Hulls<Real>& hulls = world.hulls;
  placed.resize(padded(colliders.count));
  bounds.resize(colliders.count);

  // Every collider is one thread's.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < colliders.count; i += lanes) {
    const maskv inside = first_lanes(colliders.count - i);
    const intv index = select(inside, lane_index() + i, i);
    const Pose<floatv> pose = in_world(load_pose(world.bodies.pose, load(&colliders.body[i], inside)), load_pose(colliders.local, index));
    store_pose(placed, index, pose, inside);
    const intv hull = load(&colliders.hull[i], inside);
    const maskv plane = hull < 0;
    const intv known = select(plane, 0, hull);
    const Quad<floatv> size = load_quad(colliders.size, index), centre = load_quad(hulls.centre, known),
                       half = load_quad(hulls.half, known);
    const floatv widening = size.w + margin;
    const maskv full = fills_its_box(known);
    Box<floatv> box = box_around<floatv>(pose, position(size), position(centre), position(half), widening);
    if (!all(full)) box = select(full, box, box_around_vertices(hulls, known, pose, size, widening));
    store_boxes(bounds, i, select(plane, in_all_lanes(whole_space<Real>), box));
  }
}

}  // namespace lockstep::rigid::openmp
