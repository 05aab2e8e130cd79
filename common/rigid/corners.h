// A convex shape above a plane: its corners, and how contact points are chosen among them. For T a number or sixteen
// lanes.
#pragma once

#include <limits>

#include "common/rigid/keep_four.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

// Square of the sine of the angle below which a corner stands straight above another. The square of their distance
// along the plane is a difference, good to some 1e-6 of the square of their distance.
inline constexpr float overhead = 1e-5f;

// A corner is in line with two others where it is nearer to their line than this times their distance along the plane.
inline constexpr float in_line = 1e-5f;

// A corner in the hull's axes, and the height of the surface below it over the plane.
template <class T>
struct Corner {
  Vector3<T> place;
  T separation;
  Integer<T> vertex;
};
template <class T>
[[gnu::always_inline]] inline void take(const Truth<T>& mask, const Corner<T>& from, Corner<T>& to) {
  where(mask, to.place.x) = from.place.x, where(mask, to.place.y) = from.place.y,
              where(mask, to.place.z) = from.place.z;
  where(mask, to.separation) = from.separation, where(mask, to.vertex) = from.vertex;
}

// A plane, seen from a shape. A corner's height is linear in its place within the hull, so the plane is turned into the
// hull's axes.
template <class T>
struct PlaneView {
  Vector3<T> normal, up;  // of the plane, in the world and in the hull's axes
  Matrix3<T> axes;        // of the hull
  Vector3<T> origin;      // of the hull, in the world
  Quad<T> size;           // the hull's scale, and the radius
  T height;               // of the surface below the hull's origin

  [[gnu::always_inline]] Corner<T> corner(const Vector3<T>& vertex, int number) const {
    const Vector3<T> place = {vertex.x * size.x, vertex.y * size.y, vertex.z * size.z};
    return {place, dot(up, place) + height, Integer<T>(number)};
  }
  // Midway between the plane and the surface below the corner, in the world.
  [[gnu::always_inline]] Vector3<T> position(const Corner<T>& corner) const {
    return origin + (axes * corner.place - (size.w + T(.5f) * corner.separation) * normal);
  }
};
template <class T>
[[gnu::always_inline]] inline PlaneView<T> view_plane(const Pose<T>& plane, const Pose<T>& convex,
                                                      const Quad<T>& size) {
  const Vector3<T> normal = matrix_of(plane.orientation).y;
  const Matrix3<T> axes = matrix_of(convex.orientation);
  return {normal, transposed_times(axes, normal),
          axes,   convex.position,
          size,   dot(normal, convex.position - plane.position) - size.w};
}

// The corners of a shape, as keep_four.h asks for them. Distances are measured along the plane; a corner that is no
// farther than rounding does not count.
template <class T, class CornerOf>
struct Corners {
  using Point = Corner<T>;

  int count;
  const CornerOf& corner_of;
  const Vector3<T>& up;
  T limit = std::numeric_limits<float>::infinity();  // higher corners are not valid

  template <class Action>
  [[gnu::always_inline]] void each(const Action& action) const {
    for (int i = 0; i < count; ++i) {
      const Point corner = corner_of(i);
      if (const Truth<T> valid = corner.separation <= limit; any(valid)) action(corner, valid);
    }
  }
  T deeper_by() const { return T(0); }
  [[gnu::always_inline]] T distance_2(const Point& corner, const Point& deepest) const {
    const Vector3<T> to = corner.place - deepest.place;
    const T rise = corner.separation - deepest.separation, slant = dot(to, to), square = slant - rise * rise;
    return select(square > T(overhead) * slant, square, T(0));
  }
  T least_distance_2() const { return T(0); }
  [[gnu::always_inline]] auto side(const Point& deepest, const Point& farthest) const {
    const Vector3<T> across = cross(up, farthest.place - deepest.place);
    const T base = dot(across, deepest.place);
    return [=](const Point& corner) { return dot(across, corner.place) - base; };
  }
  T least_side(const T& distance_2) const { return T(in_line) * distance_2; }
};
template <class T, class CornerOf>
Corners<T, CornerOf> corners_of(int count, const PlaneView<T>& view, const CornerOf& corner_of) {
  return {count, corner_of, view.up};
}

}  // namespace lockstep::rigid
