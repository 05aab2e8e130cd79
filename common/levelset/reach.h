// Which points can come out within the band: those no farther than the band, along each axis, from some interface
// point.
//
// Lower bound: a point that is k grid steps or more from each interface point, along some axis, is at least k h away.
// So points with k h > band are skipped. In a narrow band that is most of the grid. An upwind solution can be less
// where fronts meet: by .34 h where two plane fronts along axes do, by .50 h where three do. So make_reach adds a step.
//
// The points are found as bits, 64 to a word: marked around the interface points along x, then spread along y, then
// along z.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/levelset/field.h"

namespace lockstep::levelset {

// Points begin .. end - 1 along an axis.
struct Extent {
  int begin, end;
};

// Along every line z * ny + y, the points within reach: extents[begin[line]] .. extents[begin[line + 1] - 1], in order
// and apart.
struct Reach {
  std::vector<Extent> extents;
  std::vector<int> begin;
};

// for_each(n, f) calls f(0) .. f(n - 1) in any order; openmp/ shares them among threads.
struct InOrder {
  template <class F>
  void operator()(int n, const F& f) const {
    for (int i = 0; i < n; ++i) f(i);
  }
};

// A bit for every point: a byte would do, but bits are eight times faster to spread. Word w of a line is points 64 w ..
// 64 w + 63.
struct PointBits {
  int nx, ny, nz;
  std::ptrdiff_t line = (nx + 63) / 64, plane = ny * line;  // words from one to the next
  std::vector<std::uint64_t> words = std::vector<std::uint64_t>(nz * plane, 0);
};

// The interface points of plane z: they are in the order of the field, so they stand together.
inline std::span<const Point> points_of_plane(const std::vector<Point>& interface, int z) {
  const auto begin = std::ranges::lower_bound(interface, z, {}, &Point::z);
  return {begin, std::ranges::upper_bound(begin, interface.end(), z, {}, &Point::z)};
}

// Marks what is within `steps` along x of the interface points of plane z.
inline void mark_along_x(const std::vector<Point>& interface, int steps, int z, PointBits& bits) {
  for (const Point& point : points_of_plane(interface, z)) {
    std::uint64_t* const line = &bits.words[z * bits.plane + point.y * bits.line];
    for (int i = std::max(point.x - steps, 0), end = std::min(point.x + steps + 1, bits.nx); i < end;) {
      const int next = std::min((i / 64 + 1) * 64, end);
      line[i / 64] |= (~std::uint64_t(0) >> (64 - (next - i))) << i % 64;
      i = next;
    }
  }
}

// Adds `count` words of one array to those of another.
inline void add_bits(const std::uint64_t* from, std::ptrdiff_t count, std::uint64_t* to) {
  for (std::ptrdiff_t i = 0; i < count; ++i) to[i] |= from[i];
}

// Adds to plane z of `to` all that lies within `steps` lines in `from`.
inline void spread_along_y(const PointBits& from, int steps, int z, PointBits& to) {
  const std::uint64_t* const source = from.words.data() + z * from.plane;
  std::uint64_t* const target = to.words.data() + z * to.plane;
  for (int k = 0; k <= std::min(steps, from.ny - 1); ++k) {
    const std::ptrdiff_t shift = k * from.line;
    add_bits(source + shift, from.plane - shift, target);
    add_bits(source, from.plane - shift, target + shift);
  }
}

// Adds to plane z of `to` all that lies within `steps` planes in `from`.
inline void spread_along_z(const PointBits& from, int steps, int z, PointBits& to) {
  for (int k = std::max(z - steps, 0); k <= std::min(z + steps, from.nz - 1); ++k)
    add_bits(from.words.data() + k * from.plane, from.plane, to.words.data() + z * to.plane);
}

// The marked points of plane z: begin[y] is the first extent of its line y.
inline Reach extents_of_plane(const PointBits& bits, int z) {
  Reach plane;
  for (int y = 0; y < bits.ny; ++y) {
    plane.begin.push_back(static_cast<int>(plane.extents.size()));
    const std::uint64_t* const word = bits.words.data() + z * bits.plane + y * bits.line;
    // The first point from x on that is (or is not) marked; the end of the line if there is none.
    const auto find = [&](int x, bool marked) {
      for (; x < bits.nx; x = (x / 64 + 1) * 64)
        if (const std::uint64_t rest = (marked ? word[x / 64] : ~word[x / 64]) >> x % 64)
          return std::min(x + std::countr_zero(rest), bits.nx);
      return bits.nx;
    };
    for (int begin = find(0, true); begin < bits.nx;) {
      const int end = find(begin, false);
      plane.extents.push_back({begin, end});
      begin = find(end, true);
    }
  }
  return plane;
}

// The extents of all planes, one plane after another.
template <class ForEach>
Reach join_planes(const std::vector<Reach>& planes, int ny, const ForEach& for_each) {
  std::vector<std::size_t> first = {0};  // [plane]: extents of the planes before
  for (const Reach& p : planes) first.push_back(first.back() + p.extents.size());
  const int nz = static_cast<int>(planes.size());
  Reach reach;
  reach.extents.resize(first.back());
  reach.begin.assign(nz * ny + 1, static_cast<int>(first.back()));
  for_each(nz, [&](int z) {
    for (int y = 0; y < ny; ++y) reach.begin[z * ny + y] = static_cast<int>(first[z]) + planes[z].begin[y];
    std::ranges::copy(planes[z].extents, reach.extents.begin() + first[z]);
  });
  return reach;
}

inline Reach whole_grid(int nx, int lines) {
  Reach reach;
  reach.extents.assign(lines, {0, nx});
  for (int line = 0; line <= lines; ++line) reach.begin.push_back(line);
  return reach;
}

template <class Real, class ForEach = InOrder>
Reach make_reach(const Distances<Real>& distances, Real band, const ForEach& for_each = {}) {
  const Field<Real>& d = distances.distance;
  const int most = std::max({d.nx, d.ny, d.nz});
  // One step more than the band: for rounding, and where fronts meet (see above).
  const int steps = static_cast<int>(std::min<Real>(std::ceil(band / d.spacing) + 1, static_cast<Real>(most)));
  if (steps == most) return whole_grid(d.nx, d.ny * d.nz);

  PointBits marked{d.nx, d.ny, d.nz}, spread{d.nx, d.ny, d.nz};
  for_each(d.nz, [&](int z) { mark_along_x(distances.interface, steps, z, marked); });
  for_each(d.nz, [&](int z) { spread_along_y(marked, steps, z, spread); });
  // What is marked along x is within reach, so it may stay where the rest is added.
  for_each(d.nz, [&](int z) { spread_along_z(spread, steps, z, marked); });
  std::vector<Reach> planes(d.nz);
  for_each(d.nz, [&](int z) { planes[z] = extents_of_plane(marked, z); });
  return join_planes(planes, d.ny, for_each);
}

}  // namespace lockstep::levelset
