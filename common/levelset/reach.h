// Which points can come out within the band: those that are no farther than that from an interface point along each axis.
//
// From point to neighbour the upwind solution grows along an axis by h at the most in what it is at the least: a field that grows by h a
// step along x alone is below any solution that starts above it. So a point k steps along some axis from all interface points is
// k h away or more, and need not be visited where that is beyond the band. In a narrow band that is most of the grid.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
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

template <class Real>
Reach make_reach(const Distances<Real>& distances, Real band) {
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
  for (const auto& [x, y, z] : distances.interface) {
    std::uint64_t* const line = &bits[static_cast<std::size_t>(z * d.ny + y) * words];
    for (int i = std::max(x - steps, 0), end = std::min(x + steps + 1, d.nx); i < end;) {
      const int next = std::min((i / 64 + 1) * 64, end);
      line[i / 64] |= (~std::uint64_t(0) >> (64 - (next - i))) << i % 64;
      i = next;
    }
  }
  // Along y and then z, what lies within `steps` lines.
  const auto spread_along = [&](int n, int stride, int others, auto line_of) {
    for (int other = 0; other < others; ++other)
      for (int i = 0; i < n; ++i)
        for (int w = 0; w < words; ++w) {
          std::uint64_t word = 0;
          for (int k = std::max(i - steps, 0); k <= std::min(i + steps, n - 1); ++k)
            word |= bits[static_cast<std::size_t>(line_of(other) + k * stride) * words + w];
          spread[static_cast<std::size_t>(line_of(other) + i * stride) * words + w] = word;
        }
    bits.swap(spread);
  };
  spread_along(d.ny, 1, d.nz, [&](int z) { return z * d.ny; });
  spread_along(d.nz, d.ny, d.ny, [](int y) { return y; });

  Reach reach;
  for (int line = 0; line < lines; ++line) {
    reach.begin.push_back(static_cast<int>(reach.extents.size()));
    const std::uint64_t* const word = &bits[static_cast<std::size_t>(line) * words];
    // The first point from x on that is (or is not) within reach; the end of the line if there is none.
    const auto find = [&](int x, bool within) {
      for (; x < d.nx; x = (x / 64 + 1) * 64)
        if (const std::uint64_t rest = (within ? word[x / 64] : ~word[x / 64]) >> x % 64) return std::min(x + std::countr_zero(rest), d.nx);
      return d.nx;
    };
    for (int begin = find(0, true); begin < d.nx;) {
      const int end = find(begin, false);
      reach.extents.push_back({begin, end});
      begin = find(end, true);
    }
  }
  reach.begin.push_back(static_cast<int>(reach.extents.size()));
  return reach;
}

}  // namespace lockstep::levelset
