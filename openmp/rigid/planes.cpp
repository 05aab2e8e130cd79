// Plane against any convex shape: the deepest corners of its core, less the radius.
//
// A corner's height above the plane is linear in its place within the hull, so that the plane is turned into the hull's axes, scale and
// all, and no corner has to be turned. Of the corners within the margin, four at most hold the shape up as all of them would: the deepest;
// the one farthest from it; the one farthest from the line through both, and the one farthest on the other side of that line. Distances
// are measured along the plane, equals go to the lower number, and a corner that is no farther than rounding is left out.
//
// Threads take blocks of pairs; a block is sorted by kind, so that sixteen pairs at once go through corners as many. Spheres, capsules and
// boxes have one hull each, whose corners are the same number in all lanes; others have theirs loaded, and the lanes of lesser hulls wait.
//
// A point's feature is the corner's number. The contract stands in common/rigid/narrow_phase.h.
#include <algorithm>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/corners.h"
#include "common/rigid/narrow_phase.h"
#include "common/simd.h"
#include "openmp/rigid/bins.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {
namespace {

// What the formulas are about: sixteen pairs.
using Number = floatv;
using Vector = Vector3<Number>;

// A corner in the hull's axes, and the height of the surface below it.
struct Corner {
  Vector place;
  Number separation;
  intv vertex;
};

LOCKSTEP_INLINE void take(maskv mask, const Corner& c, Corner& corner) {
  where(mask, corner.place.x) = c.place.x, where(mask, corner.place.y) = c.place.y, where(mask, corner.place.z) = c.place.z;
  where(mask, corner.separation) = c.separation, where(mask, corner.vertex) = c.vertex;
}

// How many corners all shapes of a kind have, which then have the same hull; 0 where each has its own.
constexpr int corners_of(Kind kind) { return kind == Kind::sphere ? 1 : kind == Kind::capsule ? 2 : kind == Kind::box ? 8 : 0; }

// As load_poses does; sixteen pairs often have one plane.
LOCKSTEP_INLINE Pose<floatv> load_planes(std::span<const Pose<Real>> pose, const Indices& indices) {
  const int first = indices.index[0];
  if (!all(load(indices.index) == first)) return load_pose(pose, indices);
  const auto& [p, q, unused] = pose[first];
  return {{p.x, p.y, p.z}, {q.x, q.y, q.z, q.w}, 0.f};
}

template <Kind kind>
void collide(const Placed<Real>& placed, Bin& bin, Real margin, std::span<Manifold<Real>> manifolds) {
  constexpr int corners = corners_of(kind);
  const Colliders<Real>& colliders = placed.colliders;
  const Hulls<Real>& hulls = placed.hulls;
  bin.fill_up();
  for (int k = 0; k < bin.count; k += lanes) {
    const Indices &plane = bin.first[k / lanes], &convex = bin.second[k / lanes], &pair = bin.pair[k / lanes];
    const intv shape_a = load(plane.index), shape_b = load(convex.index);
    const maskv turned = shape_a > shape_b;
    const Pose<floatv> pose_a = load_planes(placed.pose, plane), pose_b = load_pose(placed.pose, convex);
    const Quad<floatv> size = load_quad(colliders.size, convex);
    int most_corners = corners;
    intv first_vertex, last_vertex;
    const Quad<Real>* vertex = &hulls.vertex[hulls.first_vertex[colliders.hull[convex.index[0]]]];
    if constexpr (corners == 0) {
      Indices first, last;
      for (int l = 0; l < lanes; ++l) {
        const int hull = colliders.hull[convex.index[l]];
        first.index[l] = hulls.first_vertex[hull], last.index[l] = hulls.first_vertex[hull + 1] - 1;
        most_corners = std::max(most_corners, hulls.vertices(hull));
      }
      first_vertex = load(first.index), last_vertex = load(last.index);
    }

    const Vector normal = matrix_of(pose_a.orientation).y;
    const Matrix3<Number> axes = matrix_of(pose_b.orientation);
    const Vector up = transposed_times(axes, normal);
    const Number height = dot(normal, pose_b.position - pose_a.position) - size.w;
    const auto corner = [&](int i) {
      Vector v;
      if constexpr (corners > 0) {
        v = {vertex[i].x, vertex[i].y, vertex[i].z};
      } else {
        Indices own;
        store(own.index, min(first_vertex + i, last_vertex));
        const Quad<floatv> loaded = load_quad(hulls.vertex, own);
        v = {loaded.x, loaded.y, loaded.z};
      }
      const Vector place = {v.x * size.x, v.y * size.y, v.z * size.z};
      return Corner{place, dot(up, place) + height, i};
    };

    // A lane beyond its last corner meets that corner again, which is never better than itself.
    Corner deepest = corner(0);
    for (int i = 1; i < most_corners; ++i) {
      const Corner c = corner(i);
      take(c.separation < deepest.separation, c, deepest);
    }

    ManifoldLanes manifold = {};
    manifold.normal = {select(turned, -normal.x, normal.x), select(turned, -normal.y, normal.y), select(turned, -normal.z, normal.z)};
    manifold.a = min(shape_a, shape_b), manifold.b = max(shape_a, shape_b), manifold.count = 0;
    for (int p = 0; p < most_points; ++p) manifold.position[p] = {0, 0, 0}, manifold.separation[p] = 0, manifold.feature[p] = 0;
    const auto put = [&](int p, maskv mask, const Corner& c) {
      const Vector middle = axes * c.place - (size.w + Number(.5) * c.separation) * normal;
      const Vector position = pose_b.position + middle;
      manifold.position[p] = {select(mask, position.x, 0), select(mask, position.y, 0), select(mask, position.z, 0)};
      manifold.separation[p] = select(mask, c.separation, 0);
      manifold.feature[p] = select(mask, c.vertex, 0);
      where(mask, manifold.count) += 1;
    };
    const maskv touch = deepest.separation <= margin;
    if (any(touch)) put(0, touch, deepest);
    if (corners != 1 && any(touch)) {
      Corner farthest = deepest;
      Number most = 0;
      for (int i = 0; i < most_corners; ++i) {
        const Corner c = corner(i);
        const Vector to = c.place - deepest.place;
        const Number rise = c.separation - deepest.separation, slant = dot(to, to), square = slant - rise * rise;
        const maskv farther = touch & (c.separation <= margin) & (square > most) & (square > overhead * slant);
        take(farther, c, farthest), where(farther, most) = square;
      }
      put(1, most > 0, farthest);

      if (corners != 2) {
        const Vector across = cross(up, farthest.place - deepest.place);
        const Number base = dot(across, deepest.place);
        Corner left = deepest, right = deepest;
        Number most_left = in_line * most, most_right = -in_line * most;
        for (int i = 0; i < most_corners; ++i) {
          const Corner c = corner(i);
          const Number area = dot(across, c.place) - base;
          const maskv near = c.separation <= margin, is_left = near & (area > most_left), is_right = near & (area < most_right);
          take(is_left, c, left), where(is_left, most_left) = area;
          take(is_right, c, right), where(is_right, most_right) = area;
        }
        const maskv has_left = most_left > in_line * most, has_right = most_right < -in_line * most, left_first = most_left >= -most_right;
        Corner third = right, fourth = left;
        take(left_first, left, third), take(left_first, right, fourth);
        put(2, has_left | has_right, third);
        put(3, has_left & has_right, fourth);
      }
    }
    if constexpr (corners == 1 || corners == 2)
      store_short_manifolds<corners>(manifolds, pair, manifold);
    else
      store_manifolds(manifolds, pair, manifold, lanes_of(0xffff));
  }
}

}  // namespace

void planes(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin, std::span<Manifold<Real>> manifolds) {
  const int count = static_cast<int>(pairs.size());
  // A block writes the manifolds of its own pairs alone. Kinds differ in work, hence dynamic.
#pragma omp parallel for schedule(dynamic)
  for (int begin = 0; begin < count; begin += block) {
    Bin bins[kinds];
    sort_block(pairs, begin, std::min(begin + block, count), bins, [&](const Pair& pair) -> Place {
      const auto [a, b] = pair;
      const int kind_a = placed.colliders.kind[a], kind_b = placed.colliders.kind[b];
      const bool turned = static_cast<Kind>(kind_b) == Kind::plane;
      return {turned ? kind_a : kind_b, turned ? b : a, turned ? a : b};
    });
    const auto bin = [&](Kind kind) -> Bin& { return bins[static_cast<int>(kind)]; };
    collide<Kind::sphere>(placed, bin(Kind::sphere), margin, manifolds);
    collide<Kind::capsule>(placed, bin(Kind::capsule), margin, manifolds);
    collide<Kind::box>(placed, bin(Kind::box), margin, manifolds);
    collide<Kind::hull>(placed, bin(Kind::hull), margin, manifolds);
    collide<Kind::triangle>(placed, bin(Kind::triangle), margin, manifolds);
  }
}

}  // namespace lockstep::rigid::openmp
