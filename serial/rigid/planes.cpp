// Plane against any convex shape: the deepest corners of its core, less the radius.
//
// A corner's height above the plane is linear in its place within the hull. So the plane is turned into the hull's
// axes, scale and all, and no corner has to be turned. Of the corners within the margin, four at most hold the shape up
// as all of them would: the deepest; the one farthest from it; the one farthest from the line through both, and the one
// farthest on the other side of that line. Distances are measured along the plane, equals go to the lower number, and a
// corner that is no farther than rounding is left out.
//
// A point's feature is the corner's number. The contract stands in common/rigid/narrow_phase.h, formulas in
// common/rigid/corners.h.
#include <cstddef>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/corners.h"
#include "common/rigid/narrow_phase.h"

namespace lockstep::rigid::serial {

void planes(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin, std::span<Manifold<Real>> manifolds) {
  const Colliders<Real>& colliders = placed.colliders;
  const Hulls<Real>& hulls = placed.hulls;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [a, b] = pairs[k];
    const bool turned = static_cast<Kind>(colliders.kind[b]) == Kind::plane;
    const int plane = turned ? b : a, convex = turned ? a : b;
    const PlaneView<Real> view = view_plane(placed.pose[plane], placed.pose[convex], colliders.size[convex]);
    const Quad<Real>* const vertex = &hulls.vertex[hulls.first_vertex[colliders.hull[convex]]];
    const auto corner = [&](int i) { return view.corner(vector_of(vertex[i]), i); };

    Manifold<Real> manifold = {};
    manifold.normal = turned ? -view.normal : view.normal;
    manifold.a = a, manifold.b = b;
    const auto put = [&](const Corner<Real>& c) {
      manifold.point[manifold.count] = {view.position(c), c.separation};
      manifold.feature[manifold.count++] = c.vertex;
    };
    auto corners = corners_of(hulls.vertices(colliders.hull[convex]), view, corner);
    const auto deepest = find_deepest<Real>(corners);
    if (deepest.point.separation <= margin) {
      corners.limit = margin;
      const auto four = find_others<Real>(corners, deepest);
      const auto &left = four.left, &right = four.right;
      const bool left_first = four.most_left >= four.most_right;
      put(deepest.point);
      if (four.farthest.there) put(four.farthest.point);
      if (left.there || right.there) put(left_first ? left.point : right.point);
      if (left.there && right.there) put(left_first ? right.point : left.point);
    }
    manifolds[k] = manifold;
  }
}

}  // namespace lockstep::rigid::serial
