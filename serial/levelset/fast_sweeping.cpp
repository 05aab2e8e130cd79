// The Fast Sweeping Method: Gauss-Seidel over the grid, in all eight directions.
//
// The distance comes to a point from nearer points. A sweep that goes along x, y and z as the distance grows brings it
// there in one go, however far; every straight path away from the interface fits one of the eight sweeps. There is no
// heap and no order to find, only loops; the price is that every point within reach of the band
// (common/levelset/reach.h) is visited eight times a round.
//
// Source: [ITJ07] Figure 8; Zhao, Math. Comp. 74 (2005). The contract stands in common/levelset/fast_sweeping.h.
#include "common/levelset/fast_sweeping.h"

#include <algorithm>
#include <utility>

#include "common/levelset/blocks.h"
#include "common/levelset/eikonal.h"
#include "common/levelset/reach.h"
#include "common/real.h"

namespace lockstep::levelset::serial {
namespace {

// 1 at the points of the interface, whose distances are fixed.
using Fixed = Field<std::uint8_t>;

Fixed fixed_points(const Distances<Real>& distances) {
  const Field<Real>& d = distances.distance;
  Fixed fixed = make_field<std::uint8_t>(d.nx, d.ny, d.nz, 0, 0);
  for (const auto& [x, y, z] : distances.interface) fixed(x, y, z) = 1;
  return fixed;
}

// The distance of the nearer of the two neighbours along an axis of n points, `stride` values apart; `far` beyond the
// grid. `here` is the value at a point whose coordinate along the axis is i.
Real nearer(const Real* here, int i, int n, std::ptrdiff_t stride) {
  return min(i > 0 ? here[-stride] : far<Real>, i < n - 1 ? here[stride] : far<Real>);
}

// One sweep; says whether it changed anything.
bool sweep(Field<Real>& d, const Fixed& fixed, const Reach& reach, Real band, int step_x, int step_y, int step_z) {
  const std::ptrdiff_t line = d.pitch, plane = d.ny * line;  // values from one to the next
  bool changed = false;
  for (int z = step_z > 0 ? 0 : d.nz - 1; z >= 0 && z < d.nz; z += step_z)
    for (int y = step_y > 0 ? 0 : d.ny - 1; y >= 0 && y < d.ny; y += step_y) {
      const int first = reach.begin[z * d.ny + y], last = reach.begin[z * d.ny + y + 1] - 1;
      for (int e = step_x > 0 ? first : last; e >= first && e <= last; e += step_x) {
        const auto [begin, end] = reach.extents[e];
        for (int x = step_x > 0 ? begin : end - 1; x >= begin && x < end; x += step_x) {
          if (fixed(x, y, z)) continue;
          Real& here = d(x, y, z);
          const Real u = upwind(nearer(&here, x, d.nx, 1), nearer(&here, y, d.ny, line), nearer(&here, z, d.nz, plane),
                                d.spacing);
          if (u < here && u <= band) {
            here = u;
            changed = true;
          }
        }
      }
    }
  return changed;
}

}  // namespace

int fast_sweeping_sweeps(Distances<Real>& distances, Real band, int rounds) {
  const Fixed fixed = fixed_points(distances);
  const Reach reach = make_reach(distances, band);
  for (int round = 1; round <= rounds; ++round) {
    bool changed = false;
    for (const auto& [x, y] : {std::pair{1, 1}, {-1, -1}, {1, -1}, {-1, 1}})
      for (const int z : {1, -1}) changed |= sweep(distances.distance, fixed, reach, band, x, y, z);
    if (!changed) return round;
  }
  return rounds;
}

int fast_sweeping_blocks(Distances<Real>& distances, Real band, int rounds, int size) {
  int most = 0;
  for (const Block& block : make_blocks(distances, band, size)) {
    Distances<Real> padded = cut_out(distances, block);
    most = std::max(most, fast_sweeping_sweeps(padded, band, rounds));
    put_back(padded, block, distances);
  }
  return most;
}

}  // namespace lockstep::levelset::serial
