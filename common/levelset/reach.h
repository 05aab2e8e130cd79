// Which points can come out within the band: those that are no farther than that from an interface point along each axis.
//
// From point to neighbour the upwind solution grows along an axis by h at the most in what it is at the least: a field that grows by h a
// step along x alone is below any solution that starts above it. So a point k steps along some axis from all interface points is
// k h away or more, and need not be visited where that is beyond the band. In a narrow band that is most of the grid.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/levelset/field.h"

namespace lockstep::levelset {

// Points begin .. end - 1 along an axis.
struct Extent {
  int begin, end;
};

// Along every line z * ny + y, the points within reach: extents[begin[line]] .. extents[begin[line + 1] - 1], in order and apart.
struct Reach {
  std::vector<Extent> extents;
  std::vector<int> begin;
};

// for_each(n, f) calls f(0) .. f(n - 1) in any order; openmp/ shares them out.
struct InOrder {
  template <class F>
  void operator()(int n, const F& f) const {
    for (int i = 0; i < n; ++i) f(i);
  }
};

template <class Real, class ForEach = InOrder>
Reach make_reach(const Distances<Real>& distances, Real band, const ForEach& for_each = {}) {
  const Field<Real>& d = distances.distance;
  const int lines = d.ny * d.nz, most = std::max({d.nx, d.ny, d.nz});
  // One step more than the band, for rounding.
  const int steps = static_cast<int>(std::min<Real>(std::ceil(band / d.spacing) + 1, static_cast<Real>(most)));

  if (steps == most) {
    Reach all;
    for (int line = 0; line <= lines; ++line) {
      all.begin.push_back(line);
      if (line < lines) all.extents.push_back({0, d.nx});
    }
    return all;
  }

  // A byte a point would do; a bit a point is eight times faster to spread. Word w of a line holds points 64 w .. 64 w + 63.
  const int words = (d.nx + 63) / 64;
  std::vector<std::uint64_t> bits(static_cast<std::size_t>(lines) * words, 0), spread(bits.size());
  // Interface points are in the order of the field, so those of a plane stand together.
  for_each(d.nz, [&](int plane) {
    const auto first_of = [&](int z) {
      const auto before = [](const Point& p, int z) { return p.z < z; };
      return std::lower_bound(distances.interface.begin(), distances.interface.end(), z, before);
    };
    const auto end_of_plane = first_of(plane + 1);
    for (auto point = first_of(plane); point != end_of_plane; ++point) {
      const auto [x, y, z] = *point;
      std::uint64_t* const line = &bits[static_cast<std::size_t>(z * d.ny + y) * words];
      for (int i = std::max(x - steps, 0), end = std::min(x + steps + 1, d.nx); i < end;) {
        const int next = std::min((i / 64 + 1) * 64, end);
        line[i / 64] |= (~std::uint64_t(0) >> (64 - (next - i))) << i % 64;
        i = next;
      }
    }
  });
  // Along y, whatever lies within `steps` lines, and then along z, within `steps` planes.
  const std::ptrdiff_t plane = static_cast<std::ptrdiff_t>(d.ny) * words;
  const auto add = [&](std::ptrdiff_t to, std::ptrdiff_t from, std::ptrdiff_t count) {
    const std::uint64_t* const source = bits.data() + from;
    std::uint64_t* const target = spread.data() + to;
    for (std::ptrdiff_t i = 0; i < count; ++i) target[i] |= source[i];
  };
  for_each(d.nz, [&](int z) {
    for (int k = 0; k <= std::min(steps, d.ny - 1); ++k) {
      const std::ptrdiff_t first = z * plane, shift = static_cast<std::ptrdiff_t>(k) * words;
      add(first, first + shift, plane - shift);
      add(first + shift, first, plane - shift);
    }
  });
  bits.swap(spread);
  for_each(d.nz, [&](int z) {
    for (int k = std::max(z - steps, 0); k <= std::min(z + steps, d.nz - 1); ++k) add(z * plane, k * plane, plane);
  });
  bits.swap(spread);

  std::vector<Reach> planes(d.nz);
  for_each(d.nz, [&](int z) {
    for (int y = 0; y < d.ny; ++y) {
      planes[z].begin.push_back(static_cast<int>(planes[z].extents.size()));
      const std::uint64_t* const word = bits.data() + z * plane + static_cast<std::ptrdiff_t>(y) * words;
      // The first point from x on that is (or is not) within reach; the end of the line if there is none.
      const auto find = [&](int x, bool within) {
        for (; x < d.nx; x = (x / 64 + 1) * 64)
          if (const std::uint64_t rest = (within ? word[x / 64] : ~word[x / 64]) >> x % 64)
            return std::min(x + std::countr_zero(rest), d.nx);
        return d.nx;
      };
      for (int begin = find(0, true); begin < d.nx;) {
        const int end = find(begin, false);
        planes[z].extents.push_back({begin, end});
        begin = find(end, true);
      }
    }
  });
  std::vector<std::size_t> first = {0};  // [plane]: extents of the planes before
  for (const Reach& p : planes) first.push_back(first.back() + p.extents.size());
  Reach reach;
  reach.extents.resize(first.back());
  reach.begin.assign(lines + 1, static_cast<int>(first.back()));
  for_each(d.nz, [&](int z) {
    for (int y = 0; y < d.ny; ++y) reach.begin[z * d.ny + y] = static_cast<int>(first[z]) + planes[z].begin[y];
    std::ranges::copy(planes[z].extents, reach.extents.begin() + first[z]);
  });
  return reach;
}

}  // namespace lockstep::levelset
