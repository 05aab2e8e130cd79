// Plane against any convex shape: the deepest corners of its core, less the radius, of sixteen pairs at once.
//
// serial/rigid/planes.cpp explains how corners are chosen. Threads take blocks of pairs; a block is sorted by kind, so
// that sixteen pairs at once go through corners as many. Spheres, capsules and boxes have one hull each, whose corners
// are the same number in all lanes; others have theirs loaded, and the lanes of lesser hulls wait.
//
// The contract stands in common/rigid/narrow_phase.h, formulas in common/rigid/corners.h.
#include <algorithm>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/corners.h"
#include "common/rigid/narrow_phase.h"
#include "common/simd.h"
#include "openmp/rigid/bins.h"
#include "openmp/rigid/chunks.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {
namespace {

// How many corners all shapes of a kind have, which then have the same hull; 0 where each has its own.
constexpr int corners_of_kind(Kind kind) {
  return kind == Kind::sphere ? 1 : kind == Kind::capsule ? 2 : kind == Kind::box ? 8 : 0;
}

// As load_pose does; sixteen pairs often have one plane.
LOCKSTEP_INLINE Pose<floatv> load_planes(std::span<const Pose<Real>> pose, const Indices& indices) {
  const int first = indices.index[0];
  if (!all(load(indices.index) == first)) return load_pose(pose, indices);
  const auto& [p, q, unused] = pose[first];
  return {{p.x, p.y, p.z}, {q.x, q.y, q.z, q.w}, 0.f};
}

// Vertices of the hulls of sixteen shapes of a kind. A lane beyond its last corner meets that corner again, which is
// never better than itself.
template <Kind kind>
struct VertexLanes {
  const Quad<Real>* vertex;  // of the hull that all have, if they do
  const Hulls<Real>& hulls;
  intv first, last;
  int count = corners_of_kind(kind);  // of the hull that has most

  VertexLanes(const Placed<Real>& placed, const Indices& convex) : hulls(placed.hulls) {
    const auto hull_of = [&](int l) { return placed.colliders.hull[convex.index[l]]; };
    vertex = &hulls.vertex[hulls.first_vertex[hull_of(0)]];
    if constexpr (corners_of_kind(kind) == 0) {
      Indices first_vertex, last_vertex;
      for (int l = 0; l < lanes; ++l) {
        const int hull = hull_of(l);
        first_vertex.index[l] = hulls.first_vertex[hull], last_vertex.index[l] = hulls.first_vertex[hull + 1] - 1;
        count = std::max(count, hulls.vertices(hull));
      }
      first = load(first_vertex.index), last = load(last_vertex.index);
    }
  }
  LOCKSTEP_INLINE Vector3<floatv> operator[](int i) const {
    if constexpr (corners_of_kind(kind) > 0) return {vertex[i].x, vertex[i].y, vertex[i].z};
    return vector_of(load_quad(hulls.vertex, indices_of(min(first + i, last))));
  }
};

// The points of sixteen pairs of a plane and a shape of a kind.
template <Kind kind>
LOCKSTEP_INLINE void find_points(const PlaneView<floatv>& view, const VertexLanes<kind>& vertex, floatv margin,
                                 ManifoldLanes& manifold) {
  constexpr int most_corners = corners_of_kind(kind);
  const auto corner = [&](int i) { return view.corner(vertex[i], i); };
  const auto put = [&](int p, maskv mask, const Corner<floatv>& c) {
    manifold.position[p] = select(mask, view.position(c), {0.f, 0.f, 0.f});
    manifold.separation[p] = select(mask, c.separation, 0.f);
    manifold.feature[p] = select(mask, c.vertex, 0);
    where(mask, manifold.count) += 1;
  };
  auto corners = corners_of(most_corners > 0 ? most_corners : vertex.count, view, corner);
  const auto deepest = find_deepest<floatv>(corners);
  const maskv touch = deepest.point.separation <= margin;
  if (none(touch)) return;
  put(0, touch, deepest.point);
  if constexpr (most_corners == 1) return;

  corners.limit = margin;
  const auto four = find_others<floatv>(corners, deepest);
  put(1, four.farthest.there, four.farthest.point);
  if constexpr (most_corners == 2) return;

  const auto &left = four.left, &right = four.right;
  const maskv left_first = four.most_left >= four.most_right;
  Corner<floatv> third = right.point, fourth = left.point;
  take(left_first, left.point, third), take(left_first, right.point, fourth);
  put(2, left.there | right.there, third);
  put(3, left.there & right.there, fourth);
}

template <Kind kind>
void collide(const Placed<Real>& placed, Bin& bin, Real margin, std::span<Manifold<Real>> manifolds) {
  constexpr int most_corners = corners_of_kind(kind);
  bin.fill_up();
  for (int k = 0; k < bin.count; k += lanes) {
    const Indices &plane = bin.first[k / lanes], &convex = bin.second[k / lanes], &pair = bin.pair[k / lanes];
    const intv shape_a = load(plane.index), shape_b = load(convex.index);
    const PlaneView<floatv> view = view_plane(load_planes(placed.pose, plane), load_pose(placed.pose, convex),
                                              load_quad(placed.colliders.size, convex));
    ManifoldLanes manifold;
    manifold.normal = select(shape_a > shape_b, -view.normal, view.normal);
    manifold.a = min(shape_a, shape_b), manifold.b = max(shape_a, shape_b), manifold.count = 0;
    for (int p = 0; p < most_points; ++p) {
      manifold.position[p] = {0.f, 0.f, 0.f}, manifold.separation[p] = 0.f, manifold.feature[p] = 0;
    }
    find_points<kind>(view, VertexLanes<kind>(placed, convex), margin, manifold);
    if constexpr (most_corners == 1 || most_corners == 2)
      store_short_manifolds<most_corners>(manifolds, pair, manifold);
    else
      store_manifolds(manifolds, pair, manifold, lanes_of(0xffff));
  }
}

}  // namespace

void planes(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin, std::span<Manifold<Real>> manifolds) {
  const int count = static_cast<int>(pairs.size()), size = chunk_of(pairs.size(), block);
  // A block writes the manifolds of its own pairs alone. Kinds differ in work, hence dynamic.
#pragma omp parallel for schedule(dynamic)
  for (int begin = 0; begin < count; begin += size) {
    Bin bins[kinds];
    sort_block(pairs, begin, std::min(begin + size, count), bins, [&](const Pair& pair) -> Place {
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
