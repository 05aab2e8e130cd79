// Surfaces of solid shapes as polygons, for files that show them.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/vector3.h"

namespace lockstep {

// Polygons, counterclockwise from outside.
struct Surfaces {
  std::vector<Vector3<float>> points;  // m
  std::vector<std::int32_t> polygons;  // of each the number of its corners, then the corners
  std::int64_t count = 0;              // of the polygons

  // Returns the number of the point.
  int add_point(const Vector3<float>& p);
  void add_polygon(std::span<const std::int32_t> corners);
};

// The coordinates of a shape: its origin and its axes, which are orthogonal and of length 1, in the world.
struct Axes {
  Vector3<float> origin, x, y, z;

  Vector3<float> operator()(const Vector3<float>& p) const { return origin + p.x * x + p.y * y + p.z * z; }
};

// Axes of which y is given, of length 1.
Axes axes_along(const Vector3<float>& y, const Vector3<float>& origin);

// Each adds one shape to `to`. Lengths are in m.

// A capsule: `half` is half of its segment, along y; a sphere where it is 0. sides: around y, a multiple of four.
void add_capsule(Surfaces& to, const Axes& axes, float half, float radius, int sides);
// A box of half sides.
void add_box(Surfaces& to, const Axes& axes, const Vector3<float>& half);
// A square across y, of half a side.
void add_square(Surfaces& to, const Axes& axes, float half);
// A square that shows the plane through `on` whose normal of length 1 is given: about the foot of the middle of the box
// from `low` to `high`, and larger than that box. The plane alone where low.x > high.x.
void add_plane(Surfaces& to, const Vector3<float>& normal, const Vector3<float>& on, const Vector3<float>& low,
               const Vector3<float>& high);

}  // namespace lockstep
