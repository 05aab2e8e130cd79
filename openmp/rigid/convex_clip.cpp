// Convex against convex: the points that hold the two apart along their axis, of sixteen pairs at once.
//
// serial/rigid/convex_clip.cpp explains how faces are clipped. Slots of candidates are the same for all pairs, so what
// the serial loops do to one candidate they do here to sixteen, and masks say which are candidates at all. A lane whose
// face has fewer corners than the largest waits. Pairs that are too far apart are left out before, so that lanes are
// full.
//
// Source: as in serial/rigid/convex_clip.cpp; early outs by masks, [LRB08] Figure 10. The contract stands in
//         common/rigid/convex_clip.h, formulas in common/rigid/clip_faces.h.
#include "common/rigid/convex_clip.h"

#include <algorithm>
#include <utility>

#include "common/real.h"
#include "common/rigid/clip_faces.h"
#include "common/simd.h"
#include "openmp/rigid/chunks.h"
#include "openmp/rigid/hull_lanes.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {
namespace {

constexpr Real infinity = std::numeric_limits<Real>::infinity();

// Sixteen axes.
struct AxisLanes {
  Vector3<floatv> normal, middle;
  floatv separation, cosine_a, cosine_b;
  intv face_a, face_b;
};
AxisLanes load_axes(std::span<const SeparatingAxis<Real>> axes, const Indices& which) {
  const auto records = [&](int part) {
    return load_records(&axes.data()->normal.x, indices_of(load(which.index) * 2 + part).index);
  };
  const auto [nx, ny, nz, separation, mx, my, mz, cosine_a] = records(0).field;
  const auto [cosine_b, face_a, face_b, u0, u1, u2, u3, u4] = records(1).field;
  return {{nx, ny, nz}, {mx, my, mz}, separation, cosine_a, cosine_b, bits_of(face_a), bits_of(face_b)};
}

// Faces of sixteen shapes, of which each corner is loaded by itself; of a core without faces, all its vertices.
struct Faces {
  maskv is_face;
  intv first, count;

  // The vertex that is corner k; lanes with fewer corners get their last one.
  intv vertex(const Placed<Real>& placed, int k) const {
    const intv corner = min(intv(k), count - 1);
    return select(is_face, gather(placed.hulls.corner.data(), first + corner, is_face), corner);
  }
};
Faces load_faces(const Placed<Real>& placed, const HullLanes& hulls, intv face) {
  const std::int32_t* const first_corner = placed.hulls.first_corner.data();
  const std::int32_t* const first_vertex = placed.hulls.first_vertex.data();
  const maskv is_face = face >= 0;
  const intv index = load(hulls.first_face.index) + face, hull = load(hulls.hull.index);
  const intv first = gather(first_corner, index, is_face), corners = gather(first_corner + 1, index, is_face) - first;
  return {is_face, first, select(is_face, corners, gather(first_vertex + 1, hull) - gather(first_vertex, hull))};
}

// Planes of faces, in the shape's frame; of what has no face, zero.
Quad<floatv> load_planes(const Placed<Real>& placed, const HullLanes& hulls, intv face, const Vector3<floatv>& scale) {
  const maskv is_face = face >= 0;
  const auto [x, y, z, w] =
      load_quad(placed.hulls.plane, indices_of(select(is_face, load(hulls.first_face.index) + face, 0)));
  const floatv distance =
      select(load(hulls.hull.index) == cube_hull, dot(absolute(Vector3<floatv>{x, y, z}), scale), w);
  return {select(is_face, x, 0.f), select(is_face, y, 0.f), select(is_face, z, 0.f), select(is_face, distance, 0.f)};
}

// The faces nearest to the axes, in a's frame: b's is the reference where `of_b` is true. Where `mask` is not, they may
// be cut short.
void load_polygons(const Placed<Real>& placed, const HullLanes& hulls_a, const HullLanes& hulls_b,
                   const Cores<floatv>& cores, const AxisLanes& axis, maskv of_b, maskv mask,
                   Polygon<floatv>& reference, Polygon<floatv>& incident) {
  const Faces a = load_faces(placed, hulls_a, axis.face_a), b = load_faces(placed, hulls_b, axis.face_b);
  const auto most_of = [&](intv count) { return static_cast<int>(reduce_max(to_float(select(mask, count, 0)))); };
  reference.count = select(of_b, b.count, a.count), incident.count = select(of_b, a.count, b.count);
  reference.most = most_of(reference.count), incident.most = most_of(incident.count);
  for (int k = 0; k < std::max(reference.most, incident.most); ++k) {
    const Vector3<floatv> corner_a = vertex_of_a(cores, load_vertices(placed, hulls_a, a.vertex(placed, k)));
    const Vector3<floatv> corner_b = vertex_of_b(cores, load_vertices(placed, hulls_b, b.vertex(placed, k)));
    reference.corner[k] = select(of_b, corner_b, corner_a), incident.corner[k] = select(of_b, corner_a, corner_b);
  }
  const Quad<floatv> plane_a = load_planes(placed, hulls_a, axis.face_a, cores.scale_a);
  const Quad<floatv> plane_b = turned_plane(cores, load_planes(placed, hulls_b, axis.face_b, cores.scale_b));
  const auto choose = [&](maskv mask, const Quad<floatv>& p, const Quad<floatv>& q) -> Quad<floatv> {
    return {select(mask, p.x, q.x), select(mask, p.y, q.y), select(mask, p.z, q.z), select(mask, p.w, q.w)};
  };
  reference.plane = choose(of_b, plane_b, plane_a), incident.plane = choose(of_b, plane_a, plane_b);
}

// The points that hold sixteen pairs apart along their axes.
ManifoldLanes manifolds_of(const Placed<Real>& placed, const PairLanes& pairs, const AxisLanes& axis, Real margin) {
  const HullLanes hulls_a = load_hulls(placed, pairs.a), hulls_b = load_hulls(placed, pairs.b);
  const floatv radius_a = load_quad(placed.colliders.size, pairs.a).w,
               radius_b = load_quad(placed.colliders.size, pairs.b).w;
  const Cores<floatv> cores = load_cores(placed, pairs);
  const floatv slack = slack_per_reach<Real> * load_reach(placed, cores, hulls_a, hulls_b);
  const Vector3<floatv>& normal = axis.normal;

  FacePoints<floatv> points;
  points.normal = normal, points.least_apart = apart_slacks * slack;
  const maskv of_b = axis.cosine_b - preference > axis.cosine_a;  // b's face is the reference
  const maskv clipped = max(axis.cosine_a, axis.cosine_b) > least_cosine;
  if (any(clipped)) {
    Polygon<floatv> reference, incident;
    load_polygons(placed, hulls_a, hulls_b, cores, axis, of_b, clipped, reference, incident);
    clip_faces(clipped, reference, incident, select(of_b, -normal, normal), slack, points);
  }
  const floatv radii = radius_a + radius_b;
  finish_points<floatv>(axis.middle, axis.separation, radii, margin, slack, points);

  ManifoldLanes manifold;
  manifold.normal = cores.from_a * normal;
  manifold.count = 0;
  manifold.a = load(pairs.a.index), manifold.b = load(pairs.b.index);
  const intv reference = max(select(of_b, axis.face_b, axis.face_a), 0),
             incident = max(select(of_b, axis.face_a, axis.face_b), 0);
  const Vector3<floatv> to_middle = (.5f * (radius_a - radius_b)) * normal;
  const auto put = [&](int k, maskv mask, const FacePoint<floatv>& point) {
    manifold.count = manifold.count + select(mask, intv(1), intv(0));
    manifold.position[k] = select(mask, in_world(cores, point.middle + to_middle), {0.f, 0.f, 0.f});
    manifold.separation[k] = select(mask, point.separation - radii, 0.f);
    manifold.feature[k] = select(mask, feature_of(select(of_b, intv(1), intv(0)), reference, incident, point.slot), 0);
  };
  const auto four = find_others<floatv>(points, find_deepest<floatv>(points));
  // Three are the first three.
  const auto& [left, right] = std::pair(four.left, four.right);
  FacePoint<floatv> third = right.point;
  take(left.there, left.point, third);
  put(0, four.deepest.there, four.deepest.point), put(1, four.farthest.there, four.farthest.point);
  put(2, left.there | right.there, third), put(3, left.there & right.there, right.point);
  return manifold;
}

// Pairs that a thread takes at once, at most: enough to fill vectors with those that are near.
constexpr int most_at_once = 256;

}  // namespace

void convex_clip(const Placed<Real>& placed, std::span<const Pair> pairs, std::span<const SeparatingAxis<Real>> axes,
                 Real margin, std::span<Manifold<Real>> manifolds) {
  const int count = static_cast<int>(pairs.size()), block = chunk_of(pairs.size(), most_at_once);
  // Manifold k is written where pair k is met, and nowhere else. Pairs differ in work, hence dynamic.
#pragma omp parallel for schedule(dynamic)
  for (int first = 0; first < count; first += block) {
    Indices near;
    int found = 0;
    const auto clip_found = [&] {
      const ManifoldLanes manifold = manifolds_of(placed, load_pairs(pairs, near), load_axes(axes, near), margin);
      store_manifolds(manifolds, near, manifold, first_lanes(std::exchange(found, 0)));
    };
    for (int k = first; k < std::min(first + block, count); ++k) {
      if (!(axes[k].separation < infinity)) {
        manifolds[k] = {};
        manifolds[k].a = pairs[k].a, manifolds[k].b = pairs[k].b;
        continue;
      }
      near.index[found++] = k;
      if (found == lanes) clip_found();
    }
    if (found == 0) continue;
    // Lanes beyond the last pair repeat the first.
    for (int l = found; l < lanes; ++l) near.index[l] = near.index[0];
    clip_found();
  }
}

}  // namespace lockstep::rigid::openmp
