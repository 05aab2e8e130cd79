// The grid cut into independent blocks: each is padded by the width of the band, and a little more. The price of
// padding is that some points are computed more than once.
//
// A padding of the band alone covers all interface points that a block's distances start from, but not all points on
// the way: where the front is nearly parallel to an axis, a distance also depends, by a share that falls with every
// step, on points beside its path. Band plus one left differences of .003 h (spheres and box at 128^3), plus two .0003
// h, plus three .00008 h, plus four none beyond rounding.
//
// Source: [ITJ07] Figure 7.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/levelset/field.h"
#include "common/levelset/reach.h"

namespace lockstep::levelset {

struct Block {
  Extent x, y, z;                       // its own points: every point of the grid is one block's
  Extent padded_x, padded_y, padded_z;  // with the padding, as far as the grid goes
  std::vector<Point> interface;         // the interface points in the padded block, in the order of the field
};

// A good size of blocks along each axis, without padding. In a narrow band only a few percent of a padded block's
// points are visited, and those fit the second-level cache. The size does not depend on the number of threads, so
// results do not.
inline constexpr int block_size = 64;

// By how much the padding is wider than the band, in grid steps.
inline constexpr int beside = 5;

// Calls f for the interface points in the padded block, in the order of the field: that of distances.interface, so the
// points of a plane stand together, and those of a plane's rows too.
template <class Real, class F>
void for_interface_of(const Distances<Real>& distances, const Block& block, const F& f) {
  const auto first_of = [&](int y, int z) {
    const auto before = [](const Point& a, const Point& b) { return a.z < b.z || (a.z == b.z && a.y < b.y); };
    return std::lower_bound(distances.interface.begin(), distances.interface.end(), Point{0, y, z}, before);
  };
  const Extent x = block.padded_x, y = block.padded_y, z = block.padded_z;
  for (int k = z.begin; k < z.end; ++k) {
    const auto end = first_of(y.end, k);
    for (auto p = first_of(y.begin, k); p != end; ++p)
      if (x.begin <= p->x && p->x < x.end) f(*p);
  }
}

// The blocks with an interface point in themselves or in their padding, in the order of the grid; in all others,
// distances are `far`, and stay so. A band as wide as the grid makes one block. for_each as in reach.h: a block picks
// its own points, so blocks can be made side by side.
template <class Real, class ForEach = InOrder>
std::vector<Block> make_blocks(const Distances<Real>& distances, Real band, int size, const ForEach& for_each = {}) {
  const Field<Real>& d = distances.distance;
  const int most = std::max({d.nx, d.ny, d.nz});
  const int padding = static_cast<int>(std::min<Real>(std::ceil(band / d.spacing) + beside, static_cast<Real>(most)));
  if (padding == most) size = most;
  const auto blocks_along = [&](int n) { return (n + size - 1) / size; };
  const int bx = blocks_along(d.nx), by = blocks_along(d.ny), bz = blocks_along(d.nz);

  const auto own = [&](int b, int n) -> Extent { return {b * size, std::min((b + 1) * size, n)}; };
  const auto pad = [&](Extent e, int n) -> Extent {
    return {std::max(e.begin - padding, 0), std::min(e.end + padding, n)};
  };
  std::vector<Block> blocks;
  for (int k = 0; k < bz; ++k)
    for (int j = 0; j < by; ++j)
      for (int i = 0; i < bx; ++i) {
        const Extent x = own(i, d.nx), y = own(j, d.ny), z = own(k, d.nz);
        blocks.push_back({x, y, z, pad(x, d.nx), pad(y, d.ny), pad(z, d.nz), {}});
      }
  // Points are counted first, so that one thread allocates all memory, outside for_each.
  const int count = static_cast<int>(blocks.size());
  std::vector<std::size_t> points(blocks.size());
  for_each(count, [&](int b) {
    std::size_t own = 0;
    for_interface_of(distances, blocks[b], [&](const Point&) { ++own; });
    points[b] = own;
  });
  for (int b = 0; b < count; ++b) blocks[b].interface.reserve(points[b]);
  for_each(count, [&](int b) {
    for_interface_of(distances, blocks[b], [&](const Point& p) { blocks[b].interface.push_back(p); });
  });
  std::erase_if(blocks, [](const Block& block) { return block.interface.empty(); });
  return blocks;
}

// The padded block as a grid of its own, with the interface points in it and their distances; all other points are
// `far`.
template <class Real>
Distances<Real> cut_out(const Distances<Real>& distances, const Block& block) {
  const Extent bx = block.padded_x, by = block.padded_y, bz = block.padded_z;
  Distances<Real> padded{.distance = make_field<Real>(bx.end - bx.begin, by.end - by.begin, bz.end - bz.begin,
                                                      distances.distance.spacing, far<Real>),
                         .interface = {}};
  for (const auto& [x, y, z] : block.interface) {
    padded.interface.push_back({x - bx.begin, y - by.begin, z - bz.begin});
    padded.distance(x - bx.begin, y - by.begin, z - bz.begin) = distances.distance(x, y, z);
  }
  return padded;
}

// The block's own points, back to the grid.
template <class Real>
void put_back(const Distances<Real>& padded, const Block& block, Distances<Real>& distances) {
  for (int z = block.z.begin; z < block.z.end; ++z)
    for (int y = block.y.begin; y < block.y.end; ++y) {
      const Real* const from =
          &padded.distance(block.x.begin - block.padded_x.begin, y - block.padded_y.begin, z - block.padded_z.begin);
      std::copy(from, from + (block.x.end - block.x.begin), &distances.distance(block.x.begin, y, z));
    }
}

}  // namespace lockstep::levelset
