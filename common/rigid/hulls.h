// What the makers of worlds share: arrays that grow and stay padded, and hulls put into them face by face.
#pragma once

#include <span>
#include <vector>

#include "common/rigid/world.h"

namespace lockstep::rigid {

// Writes element `at` of an array that holds as many already. The padding behind it is `inert`.
template <class T>
void put(Array<T>& array, int at, const T& value, const T& inert) {
  array.resize(padded(at + 1), inert);
  array[at] = value;
}

using Face = std::vector<int>;  // corners, counterclockwise from outside

// Triangles that are coplanar to within this, relative to the extent of their hull, are one face. Coordinates written
// with six digits are no better.
inline constexpr double flat = 1e-6;

// Appends a hull whose vertices and faces are known. Returns its number.
int put_hull(Hulls<double>& hulls, std::span<const Vector3<double>> vertices, std::span<const Face> faces);

}  // namespace lockstep::rigid
