// Pairs of convex cores of all kinds for tests of GJK, and the bounds on its rounding.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/rigid/gjk.h"
#include "common/rigid/make.h"
#include "tests/exact_convex.h"
#include "tests/rigid_shapes.h"

namespace lockstep::rigid::gjk_pairs {

using Vector = Vector3<double>;
using Random = std::mt19937;

template <class Real>
inline constexpr double unit_roundoff = std::numeric_limits<Real>::epsilon() / 2;

// The bound on the error of a distance, relative to `measure`, the sizes of both shapes and the way between them.
// Placing a corner costs the product of two quaternions, their matrix, three products and an offset: 16 u. The end of
// the walk costs a step across, up to twice the measure, times two epsilon: 8 u. A point between corners costs two
// epsilon for its place and two for the next point's greater distance: 16 u. The sum is 40 u; the rest is for terms of
// second order.
inline constexpr double good = 64;
// Volumes between the corners of a needle of length l and width w are about w^2 l, with rounding of about u l^3. If w <
// sqrt(u) l, rounding hides whether they enclose the origin. GJK then ends with some distance within the needle, at
// most w: less than sqrt(u) of the measure.
inline const double least_width = std::sqrt(unit_roundoff<float>);
inline const double thin_good = 1 / least_width;
// A walk that is stuck this near to the origin counts as an overlap: 32 epsilon of an edge, of up to twice the measure.
inline constexpr double stuck = 128;
// --- Shapes

inline double any(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
inline int any_below(Random& random, int n) { return std::uniform_int_distribution<int>(0, n - 1)(random); }
inline Vector any_direction(Random& random) {
  std::normal_distribution<double> normal;
  const Vector v = {normal(random), normal(random), normal(random)};
  return 1 / length(v) * v;
}
inline Vector any_inside(Random& random) { return std::cbrt(any(random, 0, 1)) * any_direction(random); }

inline std::vector<Vector> points_on_sphere(Random& random, int n) {
  std::vector<Vector> points(n);
  for (Vector& p : points) p = any_direction(random);
  return points;
}

// Adds vertices without faces, even of shapes that are not hulls: flat ones, points in a line, coincident points. GJK
// reads no more of a hull.
inline int add_vertices(Hulls<double>& hulls, const std::vector<Vector>& points) {
  const int hull = hulls.count++, first = hulls.first_vertex[hull], end = first + static_cast<int>(points.size());
  hulls.vertex.resize(padded(end)), hulls.first_vertex.resize(padded(hull + 2)),
      hulls.first_face.resize(padded(hull + 2));
  hulls.centre.resize(padded(hull + 1)), hulls.half.resize(padded(hull + 1));
  Vector low = points[0], high = points[0];
  for (int k = first; k < end; ++k) {
    const Vector& p = points[k - first];
    hulls.vertex[k] = {double(float(p.x)), double(float(p.y)), double(float(p.z)), 0};
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Vector centre = .5 * (low + high), half = .5 * (high - low);
  hulls.centre[hull] = {centre.x, centre.y, centre.z, 0}, hulls.half[hull] = {half.x, half.y, half.z, 0};
  hulls.first_vertex[hull + 1] = end, hulls.first_face[hull + 1] = hulls.first_face[hull];
  hulls.most_vertices = std::max(hulls.most_vertices, end - first);
  return hull;
}

// Twenty of each kind: round ones, all sizes, triangles, flat ones, ones with every vertex three times, grids with
// rounding, and needles. The needle is the last of every seven.
inline constexpr int vertex_kinds = 7;
inline std::vector<int> add_kinds(Random& random, Hulls<double>& hulls) {
  std::vector<int> added;
  for (int k = 0; k < 20; ++k) {
    const int n = 4 + any_below(random, most_hull_vertices - 3);
    added.push_back(add_vertices(hulls, points_on_sphere(random, 12 + k % 13)));
    added.push_back(add_vertices(hulls, points_on_sphere(random, n)));
    added.push_back(add_vertices(hulls, points_on_sphere(random, 3)));
    std::vector<Vector> flat = points_on_sphere(random, n), needle = flat, thrice = flat, grid = flat;
    const double width = std::pow(10., any(random, -7, -1));
    for (int l = 0; l < n; ++l) {
      flat[l].y = 0;
      needle[l].y *= width, needle[l].z *= width * any(random, 0, 1);
      thrice[l] = thrice[l / 3];
      grid[l] =
          1e-6 * grid[l] + Vector{any_below(random, 3) - 1., any_below(random, 3) - 1., any_below(random, 3) - 1.};
    }
    for (const std::vector<Vector>& points : {flat, thrice, grid, needle}) added.push_back(add_vertices(hulls, points));
  }
  return added;
}

// Pairs of colliders, placed: pair k is of colliders 2 k and 2 k + 1.
struct Scene {
  Shapes shapes;
  Pairs pairs;
  std::vector<int> thin;  // the hulls of needles thinner than least_width

  void pair(int a, int b) { pairs.push_back({a, b}); }
  bool has_thin(const Pair& pair) const {
    const auto is_thin = [&](int collider) {
      return std::count(thin.begin(), thin.end(), shapes.colliders.hull[collider]) > 0;
    };
    return is_thin(pair.a) || is_thin(pair.b);
  }
};

// Pairs of all kinds: near, far and overlapping, some along the axes of the world, some at the same place.
inline Scene all_kinds(Random& random, int pairs) {
  Scene scene;
  Shapes& shapes = scene.shapes;
  const std::vector<int> kinds = add_kinds(random, shapes.hulls);
  for (std::size_t k = vertex_kinds - 1; k < kinds.size(); k += vertex_kinds) {
    const Quad<double>& half = shapes.hulls.half[kinds[k]];
    if (std::max(half.y, half.z) < least_width * half.x) scene.thin.push_back(kinds[k]);
  }
  for (int k = 0; k < pairs; ++k) {
    const bool along_axes = any_below(random, 4) == 0, coincident = any_below(random, 50) == 0;
    const Vector where = std::pow(10., any(random, -1, 1)) * any_inside(random);
    const auto add = [&](const Vector& position) {
      const Pose<double> place = at(position, along_axes ? no_rotation : any_turn(random));
      switch (any_below(random, 6)) {
        case 0: return shapes.sphere(.1, place);
        case 1: return shapes.capsule(any_below(random, 8) == 0 ? 0 : any(random, .1, 1), .1, place);
        case 2: {
          Vector half = {any(random, .2, 1), any(random, .2, 1), any(random, .2, 1)};
          if (along_axes) half = {.5, .5, .5};
          if (any_below(random, 8) == 0) half.y = 0;
          if (any_below(random, 8) == 0) half.x *= 1e-3;
          return shapes.box(half, place);
        }
        default: return shapes.hull(kinds[any_below(random, static_cast<int>(kinds.size()))], place);
      }
    };
    const int a = add(where);
    Vector step = any(random, 0, 2.8) * any_direction(random);
    if (along_axes)
      step = .25 * Vector{any_below(random, 9) - 4., any_below(random, 9) - 4., any_below(random, 9) - 4.};
    if (coincident) step = {0, 0, 0};
    scene.pair(a, add(where + step));
  }
  return scene;
}

// Real hulls, boxes, segments and points, for the oracle.
inline Scene faced_kinds(Random& random, int pairs) {
  Scene scene;
  Shapes& shapes = scene.shapes;
  std::vector<int> hulls;
  for (int k = 0; k < 10; ++k) hulls.push_back(make_hull(shapes.hulls, points_on_sphere(random, 4 + 2 * k)));
  for (int k = 0; k < pairs; ++k) {
    const auto add = [&](const Vector& position) {
      const Pose<double> place = at(position, any_turn(random));
      switch (any_below(random, 5)) {
        case 0: return shapes.sphere(.1, place);
        case 1: return shapes.capsule(any(random, .1, 1), .1, place);
        case 2: return shapes.box({any(random, .2, 1), any(random, .2, 1), any(random, .2, 1)}, place);
        default: return shapes.hull(hulls[any_below(random, 10)], place);
      }
    };
    const Vector where = 3. * any_inside(random);
    const int a = add(where);
    scene.pair(a, add(where + any(random, .5, 2.5) * any_direction(random)));
  }
  return scene;
}

// Orientations rounded to float have length 1 only to float's precision. In double they are normalised.
template <class Real>
Rounded<Real> round_shapes(const Shapes& shapes) {
  Rounded<Real> rounded(shapes);
  if constexpr (std::is_same_v<Real, double>)
    for (Pose<double>& pose : rounded.pose) {
      auto& [x, y, z, w] = pose.orientation;
      const double scale = 1 / std::sqrt(x * x + y * y + z * z + w * w);
      x *= scale, y *= scale, z *= scale, w *= scale;
    }
  return rounded;
}

// The vertices of a core, in the world.
template <class Real>
ExactShape core(const Placed<Real>& placed, int collider) {
  ExactShape shape = exact_collider(placed, collider);
  shape.radius = 0;
  return shape;
}
template <class Real>
std::vector<Vector> corners(const Placed<Real>& placed, int collider) {
  const auto& [colliders, hulls, pose] = placed;
  const int hull = colliders.hull[collider];
  const Quad<Real>& size = colliders.size[collider];
  std::vector<Vector> result;
  for (int v = hulls.first_vertex[hull]; v < hulls.first_vertex[hull + 1]; ++v) {
    const Quad<Real>& p = hulls.vertex[v];
    result.push_back(exact_place(pose[collider], {double(p.x) * size.x, double(p.y) * size.y, double(p.z) * size.z}));
  }
  return result;
}
inline Vector in_double(const Vector3<float>& v) { return {v.x, v.y, v.z}; }
inline Vector in_double(const Vector3<double>& v) { return v; }

// The length that rounding is relative to: the extents of both shapes from their own origins, and the way between the
// origins.
template <class Real>
double measure(const Placed<Real>& placed, const Pair& pair) {
  const auto reach = [&](int collider) {
    double farthest = 0;
    for (const Vector& v : corners(placed, collider))
      farthest = std::max(farthest, length(v - in_double(placed.pose[collider].position)));
    return farthest;
  };
  return reach(pair.a) + reach(pair.b) +
         length(in_double(placed.pose[pair.b].position) - in_double(placed.pose[pair.a].position));
}

// --- Running it

template <class Real>
struct Answer {
  std::vector<Closest<Real>> closest;
  std::vector<Simplex> simplex;
};
template <class Real>
Answer<Real> run(Gjk<Real>& gjk, const Placed<Real>& placed, std::span<const Pair> pairs,
                 std::vector<Simplex> start = {}) {
  start.resize(pairs.size());
  std::vector<Closest<Real>> closest(pairs.size());
  gjk(placed, pairs, start, closest);
  return {std::move(closest), std::move(start)};
}

// A random simplex of existing vertices.
inline Simplex any_simplex(Random& random, const Placed<float>& placed, const Pair& pair) {
  Simplex simplex = {any_below(random, 5), {}, {}};
  const auto vertex = [&](int collider) {
    return static_cast<std::uint8_t>(any_below(random, placed.hulls.vertices(placed.colliders.hull[collider])));
  };
  for (int k = 0; k < simplex.count; ++k) simplex.a[k] = vertex(pair.a), simplex.b[k] = vertex(pair.b);
  return simplex;
}

}  // namespace lockstep::rigid::gjk_pairs
