// Box against box: separating axes, then contact points.
//
// Two boxes are apart if and only if they are apart along one of fifteen axes: the three that the faces of either are
// across, and the nine that are across an edge of each. Most pairs that are apart show it along the first few, so every
// test may be the last ([LRB08] Figure 10a). Where they overlap, the axis of least overlap is the way to push them
// apart.
//
// If a face gave the axis (the reference face), the face of the other box that is most nearly opposite to it (the
// incident face) is clipped against it. Of the points that both have four are kept, the deepest first, then those that
// support the most area.
//
// If two edges gave the axis, they touch in one point. But where a face beside one of them is nearly flush with their
// normal, the other box lies on that face, with a face, as in a stack, or with an edge that crosses two of its borders.
// Then faces are clipped along the edges' normal, so that contacts do not appear and disappear, or jump from border to
// border, where two axes are nearly equal and rounding decides between them.
//
// Source: [LRB08] "Collision Detection", Figure 10; Gottschalk, Lin and Manocha, SIGGRAPH 1996 (axes); Ericson,
//         Real-Time Collision Detection (2005), 4.4.1 and 5.1.9; Liang and Barsky, ACM Trans. Graphics 3 (1984)
//         (clipping). The contract stands in common/rigid/narrow_phase.h, formulas in common/rigid/box_axes.h and
//         box_faces.h, bounds in common/rigid/box_pair.h.
#include "common/real.h"
#include "common/rigid/box_axes.h"
#include "common/rigid/box_faces.h"
#include "common/rigid/narrow_phase.h"

namespace lockstep::rigid::serial {
namespace {

// Points of two faces.
void face_contact(const BoxPair<Real>& boxes, const Pose<Real>& pose, const ReferenceFace<Real>& face, Real margin,
                  Real separation, Manifold<Real>& manifold) {
  const auto& [on_b, axis, normal] = face;
  const BoxFaces<Real> faces = see_faces(boxes, pose, on_b, axis, normal);
  BoxPoint<Real> point[most_points];
  find_points(faces, separation, margin, point);
  const Vector3<Real> out = in_world(faces, faces.normal);
  manifold.normal = on_b ? -out : out;
  for (const auto& [x, y, separation, slot] : point) {
    if (slot == slots) continue;
    manifold.feature[manifold.count] = faces.feature + slot;
    manifold.point[manifold.count++] = {faces.origin + (in_world(faces, {x, y, 0}) + Real(.5) * separation * out),
                                        separation};
  }
}

// The point of two edges.
void edge_contact(const BoxPair<Real>& boxes, const Pose<Real>& pose_a, int i, int j, const Three<Real>& normal,
                  const Three<Real>& normal_b, Real separation, Manifold<Real>& manifold) {
  const EdgePoint<Real> point = edge_point(boxes, pose_a, i, j, normal, normal_b);
  manifold.normal = point.normal;
  manifold.count = 1;
  manifold.point[0] = {point.position, separation};
  manifold.feature[0] = point.feature;
}

}  // namespace

void box_box(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin,
             std::span<Manifold<Real>> manifolds) {
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [a, b] = pairs[k];
    const Pose<Real>&pose_a = placed.pose[a], &pose_b = placed.pose[b];
    const BoxPair<Real> boxes = box_pair(pose_a.position, pose_a.orientation, placed.colliders.size[a],  //
                                         pose_b.position, pose_b.orientation, placed.colliders.size[b]);
    manifolds[k].count = 0;
    bool active = true;
    const BoxAxis<Real> best = best_face(boxes, margin, active);
    if (!active) continue;
    const auto [number, separation] = best_axis(boxes, margin, best, active);
    if (!active) continue;

    Manifold<Real> manifold = {};
    manifold.a = a, manifold.b = b;
    if (number < 6) {
      const ReferenceFace<Real> face = winning_face(boxes, number);
      face_contact(boxes, face.on_b ? pose_b : pose_a, face, margin, separation, manifold);
    } else {
      const int i = axis_a(number), j = number - 6 - 3 * i;
      const Three<Real> normal = edge_normal(boxes, i, j), normal_b = along_b(boxes, normal);
      bool flush;
      const ReferenceFace<Real> face = flush_face(normal, normal_b, flush);
      if (flush)
        face_contact(boxes, face.on_b ? pose_b : pose_a, face, margin, separation, manifold);
      else
        edge_contact(boxes, pose_a, i, j, normal, normal_b, separation, manifold);
    }
    manifolds[k] = manifold;
  }
}

}  // namespace lockstep::rigid::serial
