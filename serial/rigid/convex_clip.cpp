// Convex against convex: the points that hold the two apart along their axis.
//
// The faces of a and b that support the normal best are clipped against one another: every edge of the one (incident)
// is cut by the planes through the sides of the other (reference), by Cyrus and Beck. Where it enters and leaves are
// points, and so are corners of the reference face that have the incident face above. Each has a slot of its own; there
// are no lists. Of all points four are kept.
//
// Source: clipping, Cyrus and Beck, Computers & Graphics 3 (1978). The contract stands in common/rigid/convex_clip.h,
//         formulas in common/rigid/clip_faces.h.
#include "common/rigid/convex_clip.h"

#include <algorithm>

#include "common/real.h"
#include "common/rigid/clip_faces.h"

namespace lockstep::rigid::serial {
namespace {

constexpr Real infinity = std::numeric_limits<Real>::infinity();

// The face of a collider in a's frame, to which `place` brings a vertex; of a core without faces, all it has.
template <class Place>
void load_polygon(const Placed<Real>& placed, int collider, int face, const Place& place, Polygon<Real>& polygon) {
  const Hulls<Real>& hulls = placed.hulls;
  const int hull = placed.colliders.hull[collider];
  const Quad<Real>* const vertex = &hulls.vertex[hulls.first_vertex[hull]];
  const std::int32_t* const first_corner = &hulls.first_corner[hulls.first_face[hull]];
  const int first = face >= 0 ? first_corner[face] : 0;
  polygon.count = polygon.most = face >= 0 ? first_corner[face + 1] - first : hulls.vertices(hull);
  for (int k = 0; k < polygon.count; ++k)
    polygon.corner[k] = place(vector_of(vertex[face >= 0 ? hulls.corner[first + k] : k]));
}

// The plane of a face, in the shape's frame; of what has no face, zero.
Quad<Real> plane_of(const Placed<Real>& placed, int collider, int face) {
  if (face < 0) return {0, 0, 0, 0};
  const int hull = placed.colliders.hull[collider];
  const Quad<Real>& plane = placed.hulls.plane[placed.hulls.first_face[hull] + face];
  const Real distance =
      hull == cube_hull ? dot(absolute(vector_of(plane)), vector_of(placed.colliders.size[collider])) : plane.w;
  return {plane.x, plane.y, plane.z, distance};
}

// The points that hold the two apart along the axis.
Manifold<Real> manifold_of(const Placed<Real>& placed, const Pair& pair, const SeparatingAxis<Real>& axis,
                           Real margin) {
  const auto& [colliders, hulls, pose] = placed;
  const Pose<Real>&a = pose[pair.a], &b = pose[pair.b];
  const Quad<Real>&size_a = colliders.size[pair.a], &size_b = colliders.size[pair.b];
  const int hull_a = colliders.hull[pair.a], hull_b = colliders.hull[pair.b];
  const Cores<Real> cores =
      make_cores(vector_of(size_a), vector_of(size_b), a.position, b.position, a.orientation, b.orientation);
  const Real slack = slack_per_reach<Real> * reach_of(cores, hulls.centre[hull_a], hulls.half[hull_a],
                                                      hulls.centre[hull_b], hulls.half[hull_b]);
  const Vector3<Real>& normal = axis.normal;

  FacePoints<Real> points;
  points.normal = normal, points.least_apart = apart_slacks * slack;
  const bool of_b = axis.cosine_b - preference > axis.cosine_a;  // b's face is the reference
  if (max(axis.cosine_a, axis.cosine_b) > least_cosine) {
    Polygon<Real> polygon_a, polygon_b;
    load_polygon(
        placed, pair.a, axis.face_a, [&](const Vector3<Real>& v) { return vertex_of_a(cores, v); }, polygon_a);
    load_polygon(
        placed, pair.b, axis.face_b, [&](const Vector3<Real>& v) { return vertex_of_b(cores, v); }, polygon_b);
    polygon_a.plane = plane_of(placed, pair.a, axis.face_a);
    polygon_b.plane = turned_plane(cores, plane_of(placed, pair.b, axis.face_b));
    clip_faces(true, of_b ? polygon_b : polygon_a, of_b ? polygon_a : polygon_b, of_b ? -normal : normal, slack,
               points);
  }
  const Real radii = size_a.w + size_b.w;
  finish_points(axis.middle, axis.separation, radii, margin, slack, points);

  Manifold<Real> manifold = {};
  manifold.normal = cores.from_a * normal;
  manifold.a = pair.a, manifold.b = pair.b;
  const int reference = std::max(of_b ? axis.face_b : axis.face_a, 0),
            incident = std::max(of_b ? axis.face_a : axis.face_b, 0);
  const Vector3<Real> to_middle = (Real(.5) * (size_a.w - size_b.w)) * normal;
  const auto put = [&](const Kept<Real, FacePoint<Real>>& kept) {
    if (!kept.there) return;
    manifold.point[manifold.count] = {in_world(cores, kept.point.middle + to_middle), kept.point.separation - radii};
    manifold.feature[manifold.count++] = feature_of<std::int32_t>(of_b, reference, incident, kept.point.slot);
  };
  const auto four = find_others<Real>(points, find_deepest<Real>(points));
  put(four.deepest), put(four.farthest), put(four.left), put(four.right);
  return manifold;
}

}  // namespace

void convex_clip(const Placed<Real>& placed, std::span<const Pair> pairs, std::span<const SeparatingAxis<Real>> axes,
                 Real margin, std::span<Manifold<Real>> manifolds) {
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    manifolds[k] = {};
    manifolds[k].a = pairs[k].a, manifolds[k].b = pairs[k].b;
    if (axes[k].separation < infinity) manifolds[k] = manifold_of(placed, pairs[k], axes[k], margin);
  }
}

}  // namespace lockstep::rigid::serial
