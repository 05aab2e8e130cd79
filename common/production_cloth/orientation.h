// On which side a point lies: exact signs of determinants of floats.
//
// A determinant is computed in double first, with a bound of its rounding. Where the bound leaves the sign open, the
// products are added up without rounding, as expansions: sums of doubles that do not overlap. Floats, of whatever size,
// make products of three that neither overflow a double nor fall below its least, so both are exact.
//
// Source: Shewchuk, Adaptive precision floating-point arithmetic and fast robust geometric predicates, Discrete &
//         Computational Geometry 18 (1997).
#pragma once

#include "common/vector3.h"

namespace lockstep::production_cloth {

struct Point2 {
  float x, y;
};

// The sign, -1, 0 or 1, of the determinant of b - a, c - a, d - a: on which side of the plane of a, b, c point d lies.
// Coordinates are finite.
int orient3d(const Vector3<float>& a, const Vector3<float>& b, const Vector3<float>& c, const Vector3<float>& d);

// The sign of the determinant of b - a, c - a: on which side of the line from a to b point c lies.
int orient2d(const Point2& a, const Point2& b, const Point2& c);

}  // namespace lockstep::production_cloth
