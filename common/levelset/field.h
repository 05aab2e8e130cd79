// A number at every point of a regular grid in three dimensions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/array.h"
#include "common/arrays.h"

namespace lockstep::levelset {

// Points (x, y, z), 0 <= x < nx and so on, `spacing` metres apart. Owns its values: that of (x, y, z) is value[index(x,
// y, z)]. Lines along x are padded for lanes, left and right, by at least 32 values that no kernel changes, except that
// `initialize` sets those of its distances to `far`.
template <class Real>
struct Field {
  int nx = 0, ny = 0, nz = 0;
  Real spacing = 0;  // m
  int pitch = 0;     // from one line to the next
  Array<Real> value;

  std::size_t index(int x, int y, int z) const { return (static_cast<std::size_t>(z) * ny + y) * pitch + padding + x; }
  Real& operator()(int x, int y, int z) { return value[index(x, y, z)]; }
  const Real& operator()(int x, int y, int z) const { return value[index(x, y, z)]; }

  static constexpr int padding = 32;
};

template <class Real>
Field<Real> make_field(int nx, int ny, int nz, Real spacing, Real fill) {
  Field<Real> field{.nx = nx,
                    .ny = ny,
                    .nz = nz,
                    .spacing = spacing,
                    .pitch = (nx + 15) / 16 * 16 + 2 * Field<Real>::padding,
                    .value = {}};
  field.value.assign(static_cast<std::size_t>(ny) * nz * field.pitch + 2 * Field<Real>::padding, fill);
  return field;
}

struct Point {
  std::int32_t x, y, z;
};

// The distances of points from an interface, as far as they are known.
template <class Real>
struct Distances {
  Field<Real> distance;  // m, >= 0; `far` where it is not known
  std::vector<Point>
      interface;  // the points beside the interface, in the order of the field; their distances are fixed
};

// A distance greater than any, whose square is still finite.
template <class Real>
inline constexpr Real far = Real(1e18);

template <Same<Point> P, class F>
void for_each_field(P& point, const F& f) {
  f("x", point.x), f("y", point.y), f("z", point.z);
}

// Padding is listed, too, so that comparisons show a kernel that changes it.
template <Is<Distances> D, class F>
void for_each_array(D& distances, const F& f) {
  f("distance", distances.distance.value, distances.distance.value.size());
  f("interface", distances.interface, distances.interface.size());
}

}  // namespace lockstep::levelset
