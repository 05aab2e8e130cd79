// Plane against any convex shape: the deepest corners of its core, less the radius.
//
// A corner's height above the plane is linear in its place within the hull, so that the plane is turned into the hull's axes, scale and
// all, and no corner has to be turned. Of the corners within the margin, four at most hold the shape up as all of them would: the deepest;
// the one farthest from it; the one farthest from the line through both, and the one farthest on the other side of that line. Distances
// are measured along the plane, equals go to the lower number, and a corner that is no farther than rounding is left out.
//
// A point's feature is the corner's number. The contract stands in common/rigid/narrow_phase.h.
#include <cstddef>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/corners.h"
#include "common/rigid/narrow_phase.h"

namespace lockstep::rigid::serial {
namespace {

// What the formulas are about: one pair.
using Number = Real;
using Vector = Vector3<Number>;

// A corner in the hull's axes, and the height of the surface below it.
struct Corner {
  Vector place;
  Number separation;
  std::int32_t vertex;
};

}  // namespace

void planes(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin, std::span<Manifold<Real>> manifolds) {
  const Colliders<Real>& colliders = placed.colliders;
  const Hulls<Real>& hulls = placed.hulls;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [a, b] = pairs[k];
    const bool turned = static_cast<Kind>(colliders.kind[b]) == Kind::plane;
    const int plane = turned ? b : a, convex = turned ? a : b;
    const Pose<Real>&pose_a = placed.pose[plane], &pose_b = placed.pose[convex];
    const Quad<Real>& size = colliders.size[convex];
    const Quad<Real>* const vertex = &hulls.vertex[hulls.first_vertex[colliders.hull[convex]]];
    const int count = hulls.vertices(colliders.hull[convex]);

    const Vector normal = matrix_of(pose_a.orientation).y;
    const Matrix3<Number> axes = matrix_of(pose_b.orientation);
    const Vector up = transposed_times(axes, normal);
    const Number height = dot(normal, pose_b.position - pose_a.position) - size.w;
    const auto corner = [&](int i) {
      const Vector place = {vertex[i].x * size.x, vertex[i].y * size.y, vertex[i].z * size.z};
      return Corner{place, dot(up, place) + height, i};
    };

    Corner deepest = corner(0);
    for (int i = 1; i < count; ++i)
      if (const Corner c = corner(i); c.separation < deepest.separation) deepest = c;

    Manifold<Real> manifold = {};
    manifold.normal = turned ? -normal : normal;
    manifold.a = a, manifold.b = b;
    const auto put = [&](const Corner& c) {
      const Vector middle = axes * c.place - (size.w + Number(.5) * c.separation) * normal;
      manifold.point[manifold.count] = {pose_b.position + middle, c.separation};
      manifold.feature[manifold.count] = c.vertex;
      ++manifold.count;
    };
    if (deepest.separation <= margin) {
      put(deepest);

      Corner farthest = deepest;
      Number most = 0;
      for (int i = 0; i < count; ++i) {
        const Corner c = corner(i);
        const Vector to = c.place - deepest.place;
        const Number rise = c.separation - deepest.separation, slant = dot(to, to), square = slant - rise * rise;
        if (c.separation <= margin && square > most && square > overhead * slant) farthest = c, most = square;
      }

      const Vector across = cross(up, farthest.place - deepest.place);
      const Number base = dot(across, deepest.place);
      Corner left = deepest, right = deepest;
      Number most_left = in_line * most, most_right = -in_line * most;
      for (int i = 0; i < count; ++i) {
        const Corner c = corner(i);
        const Number area = dot(across, c.place) - base;
        if (c.separation <= margin && area > most_left) left = c, most_left = area;
        if (c.separation <= margin && area < most_right) right = c, most_right = area;
      }
      const bool has_left = most_left > in_line * most, has_right = most_right < -in_line * most, left_first = most_left >= -most_right;
      if (most > 0) put(farthest);
      if (has_left || has_right) put(left_first ? left : right);
      if (has_left && has_right) put(left_first ? right : left);
    }
    manifolds[k] = manifold;
  }
}

}  // namespace lockstep::rigid::serial
