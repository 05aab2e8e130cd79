// The constraints of a sheet, sixteen at once, without gathers: constraints that begin side by side in a row end side
// by side in a row, so both ends are loaded whole. Constraints along a row take 32 particles and split them into
// partners by one shuffle.
//
// No serial twin: there a constraint is two particles (enforce in serial/cloth/relax.cpp).
#pragma once

#include <algorithm>

#include "common/cloth/cloth.h"
#include "common/cloth/project.h"
#include "common/simd.h"
#include "openmp/vector_lanes.h"

namespace lockstep::cloth::openmp {

// Where the particles of a sheet are. Local copies of the pointers, so that stores to one array leave the others known.
struct Rows {
  Vector3<float*> position;
  const float* inverse_mass;
  int pitch;  // from one row to the next
};

inline Rows rows_of(Cloth<float>& cloth) {
  return {pointers(cloth.position), cloth.inverse_mass.data(), cloth.sheet.pitch};
}

// Particles i, i + 1, ... i + 15, or those of them that the mask says are there.
LOCKSTEP_INLINE Point<floatv> read(const Rows& rows, int i) {
  const auto [x, y, z] = load(rows.position, i);
  return {x, y, z, load(rows.inverse_mass + i)};
}
LOCKSTEP_INLINE Point<floatv> read(const Rows& rows, int i, maskv mask) {
  const auto [x, y, z] = load(rows.position, i, mask);
  return {x, y, z, load(rows.inverse_mass + i, mask)};
}
LOCKSTEP_INLINE void write(const Rows& rows, int i, const Point<floatv>& p) {
  store(rows.position, i, {p.x, p.y, p.z});
}
LOCKSTEP_INLINE void write(const Rows& rows, int i, const Point<floatv>& p, maskv mask) {
  store(rows.position, i, {p.x, p.y, p.z}, mask);
}

// n constraints between particles a, a + 1, ... and b, b + 1, ..., of different rows.
LOCKSTEP_INLINE void enforce_between(const Rows& rows, int a, int b, int n, floatv rest_2) {
  int k = 0;
  for (; k + lanes <= n; k += lanes) {
    Point<floatv> pa = read(rows, a + k), pb = read(rows, b + k);
    project(pa, pb, rest_2);
    write(rows, a + k, pa);
    write(rows, b + k, pb);
  }
  if (k == n) return;
  const maskv inside = first_lanes(n - k);
  Point<floatv> pa = read(rows, a + k, inside), pb = read(rows, b + k, inside);
  project(pa, pb, rest_2);
  write(rows, a + k, pa, inside);
  write(rows, b + k, pb, inside);
}

// The constraints of a family that begin in one row and end in another.
LOCKSTEP_INLINE void enforce_row(const Rows& rows, const Sheet& sheet, const Family<float>& family, int row) {
  const auto [down, right, rest_2] = family;
  const int begin = std::max(0, -right), end = sheet.columns - std::max(0, right);
  enforce_between(rows, sheet.index(row, begin), sheet.index(row + down, begin + right), end - begin, rest_2);
}

// Enforces the constraints between partners G apart among 32 particles.
template <int G>
LOCKSTEP_INLINE void enforce_partners(Point<floatv>& low, Point<floatv>& high, floatv rest_2) {
  const Halves x = split<G>(low.x, high.x), y = split<G>(low.y, high.y), z = split<G>(low.z, high.z),
               w = split<G>(low.w, high.w);
  Point<floatv> a = {x.first, y.first, z.first, w.first}, b = {x.second, y.second, z.second, w.second};
  project(a, b, rest_2);
  join<G>({a.x, b.x}, low.x, high.x);
  join<G>({a.y, b.y}, low.y, high.y);
  join<G>({a.z, b.z}, low.z, high.z);
}

// The constraints of one colour along a row: particles first .. first + n - 1 in blocks of 2 G, where particles of the
// first half are tied to those of the second, G farther on.
template <int G>
LOCKSTEP_INLINE void enforce_along(const Rows& rows, int first, int n, floatv rest_2) {
  int k = 0;
  for (; k + 2 * lanes <= n; k += 2 * lanes) {
    Point<floatv> low = read(rows, first + k), high = read(rows, first + k + lanes);
    enforce_partners<G>(low, high, rest_2);
    write(rows, first + k, low);
    write(rows, first + k + lanes, high);
  }
  if (k >= n) return;
  // Both of a pair must be there.
  const auto paired = [&](intv i) { return max(i, i ^ intv(G)) < n; };
  const maskv low_paired = paired(lane_index() + k), high_paired = paired(lane_index() + (k + lanes));
  Point<floatv> low = read(rows, first + k, low_paired), high = read(rows, first + k + lanes, high_paired);
  enforce_partners<G>(low, high, rest_2);
  write(rows, first + k, low, low_paired);
  write(rows, first + k + lanes, high, high_paired);
}

}  // namespace lockstep::cloth::openmp
