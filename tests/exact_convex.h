// How far apart two convex shapes are, or how deep in one another: in double, by trying everything. For tests to
// measure against.
//
// A shape is its corners and its faces. Where shapes overlap, the depth is found among the normals of all faces and the
// cross products of all pairs of edges: these are the directions of the faces of their difference, and the depth is the
// distance of the nearest. Where they are apart, the closest points lie on two vertices, edges or faces: all pairs of
// segments and all vertices against all faces are tried. Nothing is shared with the algorithms under test but the pose
// and the list of corners.
//
// Rounding: every value is good to some 1e-15 of the shapes' size and place. No direction, however badly rounded, can
// make shapes look farther apart than they are: each is a bound from below, and the answer is the largest.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "common/rigid/world.h"

namespace lockstep::rigid {

struct ExactShape {
  std::vector<Vector3<double>> vertex;          // m, in the world
  std::vector<std::vector<int>> face;           // corners, counterclockwise from outside
  std::vector<Vector3<double>> normal;          // [face]: outward, unit
  std::vector<std::pair<int, int>> edge;        // of vertices, each once
  std::vector<Vector3<double>> edge_direction;  // unit; of parallel edges, one
  double radius = 0;                            // m: the shape is rounded by it
};

// Of two shapes, from a to b.
struct ExactSeparation {
  double separation;           // m: the distance, or less than zero: the depth
  Vector3<double> normal;      // unit, from a to b; no one direction where they touch in a point
  Vector3<double> on_a, on_b;  // m: closest points of the cores, where those are apart; nothing where they overlap
};

inline double length(const Vector3<double>& v) { return std::sqrt(dot(v, v)); }

// From corners and faces alone.
inline ExactShape exact_shape(std::vector<Vector3<double>> vertex, std::vector<std::vector<int>> face,
                              double radius = 0) {
  ExactShape shape{std::move(vertex), std::move(face), {}, {}, {}, radius};
  for (const std::vector<int>& corners : shape.face) {
    Vector3<double> sum = {0, 0, 0};
    for (std::size_t k = 0; k < corners.size(); ++k) {
      const int i = corners[k], j = corners[(k + 1) % corners.size()];
      const Vector3<double>& origin = shape.vertex[corners[0]];
      sum = sum + cross(shape.vertex[i] - origin, shape.vertex[j] - origin);
      shape.edge.push_back(std::minmax(i, j));
    }
    shape.normal.push_back(1 / length(sum) * sum);
  }
  if (shape.face.empty() && shape.vertex.size() == 2) shape.edge.push_back({0, 1});
  std::sort(shape.edge.begin(), shape.edge.end());
  shape.edge.erase(std::unique(shape.edge.begin(), shape.edge.end()), shape.edge.end());
  for (const auto& [i, j] : shape.edge) {
    const Vector3<double> along = shape.vertex[j] - shape.vertex[i], direction = 1 / length(along) * along;
    const auto parallel = [&](const Vector3<double>& other) { return length(cross(direction, other)) < 1e-14; };
    if (std::none_of(shape.edge_direction.begin(), shape.edge_direction.end(), parallel))
      shape.edge_direction.push_back(direction);
  }
  return shape;
}

template <class Real>
Vector3<double> exact_place(const Pose<Real>& pose, const Vector3<double>& local) {
  Quaternion<double> q = {pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w};
  const double inverse = 1 / std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
  q = {q.x * inverse, q.y * inverse, q.z * inverse, q.w * inverse};
  return Vector3<double>{pose.position.x, pose.position.y, pose.position.z} + matrix_of(q) * local;
}

// A box of half sides `half`, in any precision; its numbers are taken as they are.
template <class Real>
ExactShape exact_box(const Vector3<Real>& half, const Pose<Real>& pose) {
  std::vector<Vector3<double>> vertex;
  for (int k = 0; k < 8; ++k)
    vertex.push_back(exact_place(pose, {k & 1 ? half.x : -half.x, k & 2 ? half.y : -half.y, k & 4 ? half.z : -half.z}));
  return exact_shape(std::move(vertex),
                     {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}});
}

// A hull of a library, scaled and rounded as colliders' are (common/rigid/world.h).
template <class Real>
ExactShape exact_hull(const Hulls<Real>& hulls, int hull, const Quad<Real>& size, const Pose<Real>& pose) {
  std::vector<Vector3<double>> vertex;
  for (int v = hulls.first_vertex[hull]; v < hulls.first_vertex[hull + 1]; ++v) {
    const Quad<Real>& p = hulls.vertex[v];
    vertex.push_back(exact_place(pose, {double(p.x) * size.x, double(p.y) * size.y, double(p.z) * size.z}));
  }
  std::vector<std::vector<int>> face;
  for (int f = hulls.first_face[hull]; f < hulls.first_face[hull + 1]; ++f)
    face.emplace_back(hulls.corner.begin() + hulls.first_corner[f], hulls.corner.begin() + hulls.first_corner[f + 1]);
  return exact_shape(std::move(vertex), std::move(face), size.w);
}

template <class Real>
ExactShape exact_collider(const Placed<Real>& placed, int collider) {
  return exact_hull(placed.hulls, placed.colliders.hull[collider], placed.colliders.size[collider],
                    placed.pose[collider]);
}

// How far b begins behind where a ends along a unit axis: less than zero where they overlap along it. Cores, without
// their radii.
inline double separation_along(const ExactShape& a, const ExactShape& b, const Vector3<double>& axis) {
  double end_a = -std::numeric_limits<double>::infinity(), begin_b = std::numeric_limits<double>::infinity();
  for (const Vector3<double>& v : a.vertex) end_a = std::max(end_a, dot(axis, v));
  for (const Vector3<double>& v : b.vertex) begin_b = std::min(begin_b, dot(axis, v));
  return begin_b - end_a;
}

// The greatest separation along any axis: of overlapping cores with faces, the depth, exactly; of cores apart, > 0, not
// yet the distance. Edges that are parallel to within least_sine give no axis.
inline ExactSeparation separating_axis(const ExactShape& a, const ExactShape& b, double least_sine = 1e-14) {
  ExactSeparation best{-std::numeric_limits<double>::infinity(), {0, 0, 0}, {}, {}};
  const auto consider = [&](const Vector3<double>& axis) {
    for (const Vector3<double>& way : {axis, -axis}) {
      const double separation = separation_along(a, b, way);
      if (separation > best.separation) best.separation = separation, best.normal = way;
    }
  };
  for (const Vector3<double>& normal : a.normal) consider(normal);
  for (const Vector3<double>& normal : b.normal) consider(normal);
  for (const Vector3<double>& along_a : a.edge_direction)
    for (const Vector3<double>& along_b : b.edge_direction) {
      const Vector3<double> axis = cross(along_a, along_b);
      if (length(axis) > least_sine) consider(1 / length(axis) * axis);
    }
  return best;
}

// The closest points of segments p + s u and q + t v, 0 <= s, t <= 1: the inner point of both lines if it is within,
// else on a border.
inline std::pair<Vector3<double>, Vector3<double>> closest_of_segments(const Vector3<double>& p,
                                                                       const Vector3<double>& u,
                                                                       const Vector3<double>& q,
                                                                       const Vector3<double>& v) {
  const auto onto = [](const Vector3<double>& point, const Vector3<double>& origin, const Vector3<double>& along) {
    const double square = dot(along, along);
    return square > 0 ? std::clamp(dot(point - origin, along) / square, 0., 1.) : 0.;
  };
  std::pair<Vector3<double>, Vector3<double>> best;
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](double s, double t) {
    const std::pair<Vector3<double>, Vector3<double>> candidate = {p + s * u, q + t * v};
    const double distance = length(candidate.second - candidate.first);
    if (distance < least) least = distance, best = candidate;
  };
  for (const double end : {0., 1.}) {
    consider(end, onto(p + end * u, q, v));
    consider(onto(q + end * v, p, u), end);
  }
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), determinant = uu * vv - uv * uv;
  if (determinant > 0) {
    const double s = (dot(u, q - p) * vv - dot(v, q - p) * uv) / determinant;
    if (s > 0 && s < 1) consider(s, onto(p + s * u, q, v));
  }
  return best;
}

// The closest points of cores that are apart.
inline ExactSeparation exact_distance(const ExactShape& a, const ExactShape& b) {
  ExactSeparation best{std::numeric_limits<double>::infinity(), {0, 0, 0}, {}, {}};
  const auto consider = [&](const Vector3<double>& on_a, const Vector3<double>& on_b) {
    const double distance = length(on_b - on_a);
    if (distance < best.separation) best = {distance, 1 / distance * (on_b - on_a), on_a, on_b};
  };
  // Where v stands over the inside of a face, its foot.
  const auto over_faces = [](const ExactShape& shape, const Vector3<double>& v, auto&& found) {
    for (std::size_t f = 0; f < shape.face.size(); ++f) {
      const std::vector<int>& corners = shape.face[f];
      bool inside = true;
      for (std::size_t k = 0; k < corners.size() && inside; ++k) {
        const Vector3<double>&p = shape.vertex[corners[k]], &q = shape.vertex[corners[(k + 1) % corners.size()]];
        inside = dot(cross(q - p, v - p), shape.normal[f]) >= 0;
      }
      if (inside) found(v - dot(v - shape.vertex[corners[0]], shape.normal[f]) * shape.normal[f]);
    }
  };
  const auto segments = [](const ExactShape& shape) {
    std::vector<std::pair<int, int>> edges = shape.edge;
    if (edges.empty()) edges.push_back({0, 0});
    return edges;
  };
  for (const Vector3<double>& v : b.vertex) over_faces(a, v, [&](const Vector3<double>& foot) { consider(foot, v); });
  for (const Vector3<double>& v : a.vertex) over_faces(b, v, [&](const Vector3<double>& foot) { consider(v, foot); });
  for (const auto& [i, j] : segments(a))
    for (const auto& [k, l] : segments(b)) {
      const Vector3<double>&p = a.vertex[i], &q = b.vertex[k];
      const auto [on_a, on_b] = closest_of_segments(p, a.vertex[j] - p, q, b.vertex[l] - q);
      consider(on_a, on_b);
    }
  return best;
}

// Distance or depth of two shapes, radii and all. Exact where a core has faces or the cores are apart; of cores without
// a face (points, segments) that meet, whose depth any direction across both gives, it is the radii.
inline ExactSeparation exact_separation(const ExactShape& a, const ExactShape& b) {
  const bool flat = a.face.empty() && b.face.empty();
  ExactSeparation result = flat ? ExactSeparation{1, {}, {}, {}} : separating_axis(a, b);
  if (result.separation > 0) result = exact_distance(a, b);
  result.separation -= a.radius + b.radius;
  return result;
}

}  // namespace lockstep::rigid
