// Vectors over the cells of a system, laid out along wavefronts: sixteen cells that do not wait for one another in a
// triangular solve stand side by side.
//
// A solve works on a cell once its neighbours along -x, -y and -z are done. A plane z of a bordered array (system.h) is
// one sequence of cells, in which neighbours are a cell or a line apart. Sixteen planes are a tile. Each runs one cell
// behind the plane below: lane l of vector s is cell s - l of plane l. Its neighbours along x are the same lane of
// vectors s - 1 and s + 1, those along y the same lane of the vectors a line before and after, and those along z the
// lanes beside in vectors s - 1 and s + 1. The outer neighbours of the first and last lane are in the tiles beside.
// Solves against x, y and z go through the same vectors backwards.
//
// Lanes without a row of the system hold 0.
//
// No serial twin: serial vectors are in the order of the cells.
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "common/array.h"
#include "common/production_fluid/pressure_solve.h"
#include "common/production_fluid/system.h"
#include "common/real.h"
#include "common/simd.h"

namespace lockstep::production_fluid::openmp {

static_assert(planes_of_a_sum == lanes && planes_of_a_block == lanes);

// Vectors begin .. end - 1 of a tile; none if both are the same.
struct Stretch {
  int tile = 0, begin = 0, end = 0;
};

class Skewed {
 public:
  explicit Skewed(const System<float>& system);

  int tiles() const { return tiles_; }

  // All vectors with a row are in parts of the tiles, as many of each tile, some of them empty. In a solve along x, y
  // and z, a part waits for parts of its tile before it, and for the same part of the tile before; in one backwards,
  // for those behind. What it waits for is at most `parts_between` parts away.
  int parts_of_a_tile() const { return parts_of_a_tile_; }
  int parts_between() const {  // along y; and 2, so that the product of a part does not wait for a later solve
    return std::max(static_cast<int>((cells_.line() + part_length - 1) / part_length), 2);
  }
  // By tile, in ascending order.
  const std::vector<Stretch>& parts() const { return parts_; }
  std::span<const Stretch> parts(int tile) const {
    return std::span(parts_).subspan(std::size_t(tile) * parts_of_a_tile_, parts_of_a_tile_);
  }
  // Empty if there is no such part.
  Stretch part(int tile, int k) const {
    return k >= 0 && k < parts_of_a_tile_ ? parts_[std::size_t(tile) * parts_of_a_tile_ + k] : Stretch{};
  }

  // The tiles of a thread: from `begin` to `end` - 1, so that threads have about as many vectors.
  struct Tiles {
    int begin, end;
  };
  Tiles run_of_tiles(int thread, int threads) const {
    const auto first_of = [&](std::ptrdiff_t thread) {
      int tile = 0;
      while (tile < tiles_ &&
             (vectors_before_[tile] + vectors_before_[tile + 1]) * threads < 2 * thread * vectors_before_[tiles_])
        ++tile;
      return tile;
    };
    return {first_of(thread), thread + 1 < threads ? first_of(thread + 1) : tiles_};
  }

  // Elements of an array of vectors, and of its outer lanes.
  std::size_t size() const { return padded(stride_ * lanes * tiles_); }
  std::size_t outer_size() const { return padded(2 * stride_ * (tiles_ + 2)); }
  // Where lane 0 of vector s stands.
  std::ptrdiff_t at(int tile, int s) const { return (tile * stride_ + s) * lanes; }
  // From a cell to its neighbour along +y. Along +x, that is `lanes`.
  std::ptrdiff_t along_y() const { return along_y_; }
  // From a vector to the one whose first lane is the neighbour along +z of its last lane; in vectors.
  std::ptrdiff_t to_high_tile() const { return stride_ - (lanes - 1); }

  std::ptrdiff_t vectors_of_a_tile() const { return stride_; }

  const Bordered& cells() const { return cells_; }

 private:
  // The parts of a tile end where s + 16 tile is a multiple of this: small enough for many parts, large enough for few
  // flags.
  static constexpr int part_length = 96;

  Bordered cells_;
  int tiles_;
  std::ptrdiff_t along_y_;
  std::ptrdiff_t stride_;  // vectors of a tile; and a line more, so that no tile has neighbours along y in another
  int parts_of_a_tile_;
  std::vector<Stretch> parts_;
  std::vector<std::ptrdiff_t> vectors_before_;  // [tile] in parts of tiles before; and of all, behind the last
};

inline Skewed::Skewed(const System<float>& system)
    : cells_(system.cells),
      tiles_((cells_.nz + lanes - 1) / lanes),
      along_y_(cells_.line() * lanes),
      stride_(cells_.plane() + cells_.line() + lanes - 1),
      parts_of_a_tile_(static_cast<int>((stride_ + tiles_ * lanes) / part_length) + 1),
      parts_(std::size_t(tiles_) * parts_of_a_tile_),
      vectors_before_{0} {
  for (int tile = 0; tile < tiles_; ++tile) {
    const int skew = tile * lanes, last_plane = std::min(skew + lanes, cells_.nz);
    Stretch* const parts_of_tile = &parts_[std::size_t(tile) * parts_of_a_tile_];
    std::fill_n(parts_of_tile, parts_of_a_tile_, Stretch{tile, 0, 0});
    for (int y = 0; y < cells_.ny; ++y) {
      int begin = cells_.nx + lanes, end = 0;
      for (int z = skew; z < last_plane; ++z) {
        const int line = y + cells_.ny * z, first = system.first_run[line], last = system.first_run[line + 1] - 1;
        if (first > last) continue;
        begin = std::min(begin, system.runs[first].begin + z - skew);
        end = std::max(end, system.runs[last].end + z - skew);
      }
      const int from = static_cast<int>((y + 1) * cells_.line());
      for (int s = from + begin, next; s < from + end; s = next) {
        const int k = (s + skew) / part_length;
        next = std::min(from + end, (k + 1) * part_length - skew);
        Stretch& part = parts_of_tile[k];
        part.begin = part.begin == part.end ? s : std::min(part.begin, s);
        part.end = std::max(part.end, next);
      }
    }
    std::ptrdiff_t vectors = vectors_before_.back();
    for (const Stretch& part : parts(tile)) vectors += part.end - part.begin;
    vectors_before_.push_back(vectors);
  }
}

// Lane 0 and lane 15 of all vectors, 0 beyond the tiles. Tiles read of one another only these, so that a thread fetches
// one cache line for sixteen vectors of another thread's.
class OuterLanes {
 public:
  // The caller owns `lanes_of_all`, of Skewed::outer_size elements.
  OuterLanes(const Skewed& skewed, Array<Real>& lanes_of_all)
      : first_(lanes_of_all.data() + skewed.vectors_of_a_tile()),
        last_(first_ + skewed.vectors_of_a_tile() * (skewed.tiles() + 2)),
        to_high_tile_(skewed.to_high_tile()) {}

  // i is where a vector stands, v the vector.
  LOCKSTEP_INLINE void set_first(std::size_t i, const Real* v) const { first_[i / lanes] = v[0]; }
  LOCKSTEP_INLINE void set_last(std::size_t i, const Real* v) const { last_[i / lanes] = v[lanes - 1]; }
  // Neighbours along z of its cells; those along x are given.
  LOCKSTEP_INLINE floatv low_z(std::size_t i, floatv low_x) const {
    return shift_up(low_x, last_[static_cast<std::ptrdiff_t>(i / lanes) - to_high_tile_]);
  }
  LOCKSTEP_INLINE floatv high_z(std::size_t i, floatv high_x) const {
    return shift_down(high_x, first_[static_cast<std::ptrdiff_t>(i / lanes) + to_high_tile_]);
  }

 private:
  Real *first_, *last_;  // of the vector that stands at 0
  std::ptrdiff_t to_high_tile_;
};

}  // namespace lockstep::production_fluid::openmp
