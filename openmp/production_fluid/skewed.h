// Vectors over the cells of a system, laid out along wavefronts: sixteen cells that do not wait for one another in a
// triangular solve stand side by side.
//
// A solve works on a cell once its neighbours along -x, -y and -z are done. So in sixteen lines along x, one above the
// other, lane l is cell x = s - l of line l in vector s. Its neighbours along x are the same lane of vectors s - 1 and
// s + 1, those along y the lanes beside in the same two vectors, and those along z the same lane of vector s a plane up
// or down. Solves against x, y and z go through the same vectors backwards. Sixteen lines of `depth` planes are a tile;
// the outer neighbours of its first and last lane are in the tiles beside.
//
// Lanes without a row of the system hold 0, lanes beyond the box among them. A tile more on either side, and planes
// more, are all 0. So are the vectors between two tiles, where loads of outer neighbours end that have no row.
//
// No serial twin: serial vectors are in the order of the cells.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "common/array.h"
#include "common/production_fluid/pressure_solve.h"
#include "common/production_fluid/system.h"
#include "common/simd.h"

namespace lockstep::production_fluid::openmp {

// Passes take so many planes at once. Two threads then take .94 of the time that they take with one plane
// (notes/production_fluid.md).
inline constexpr int depth = 2;

// Vectors begin .. end - 1 of a tile in planes z .. z + depth - 1.
struct Stretch {
  int tile, z, begin, end;
  int of;  // the tile's number in Skewed::tiles
};

class Skewed {
 public:
  explicit Skewed(const System<float>& system);

  // The tiles that have rows, in steps of `depth` planes, and their vectors from the first to the last with a row; by
  // z, then by tile.
  const std::vector<Stretch>& tiles() const { return tiles_; }

  // The same in parts, stage by stage. In a solve along x, y and z, a part waits only for parts of earlier stages; in
  // one backwards, only for parts of later stages. Neighbours are at most `stages_between` stages apart. Parts of a
  // stage are in order of x + y: where threads take runs of them, few neighbours are another thread's.
  const std::vector<std::vector<Stretch>>& stages() const { return stages_; }

  // The tiles by blocks, each of one tile along y and `side_of_a_block` planes, in ascending order of z.
  const std::vector<std::vector<Stretch>>& blocks() const { return blocks_; }

  std::size_t size() const {  // elements of a vector
    return padded(static_cast<std::size_t>(stride()) * lanes * (tiles_along_y_ + 2) * (steps_along_z() * depth + 2) +
                  2 * margin());
  }
  // Where lane 0 of vector s stands.
  std::ptrdiff_t at(int tile, int z, int s) const {
    return margin() + (((z + 1) * std::ptrdiff_t(tiles_along_y_ + 2) + tile + 1) * stride() + s) * lanes;
  }
  // From a vector to the one with its neighbours along +x, and along +z.
  static constexpr std::ptrdiff_t along_x = lanes;
  std::ptrdiff_t along_z() const { return stride() * lanes * (tiles_along_y_ + 2); }
  // From a vector to the one whose last lane is the neighbour along -y of its first lane.
  std::ptrdiff_t to_low_tile() const { return (lanes - 1 - stride()) * lanes; }
  // From a vector to the one whose first lane is the neighbour along +y of its last lane.
  std::ptrdiff_t to_high_tile() const { return -to_low_tile(); }

  const Bordered& cells() const { return cells_; }

 private:
  int steps_along_z() const { return (cells_.nz + depth - 1) / depth; }
  // Vectors of a tile in a plane, and as many that stay 0 as lead from a vector to its outer neighbours.
  std::ptrdiff_t stride() const { return cells_.nx + 2 * lanes - 1; }
  static constexpr std::ptrdiff_t margin() { return 2 * lanes * lanes; }

  Bordered cells_;
  int tiles_along_y_;
  std::vector<Stretch> tiles_;
  std::vector<std::vector<Stretch>> stages_, blocks_;
};

// The parts of a tile end where x + y is a multiple of this: small enough for many parts a stage, large enough for few
// stages.
inline constexpr int part_length = 16;
inline constexpr int stages_between = 2;  // along y: one tile further, and at most one multiple of x + y

inline Skewed::Skewed(const System<float>& system)
    : cells_(system.cells), tiles_along_y_((cells_.ny + lanes - 1) / lanes) {
  for (int z = 0; z < cells_.nz; z += depth)
    for (int tile = 0; tile < tiles_along_y_; ++tile) {
      Stretch all = {tile, z, cells_.nx + lanes, 0, static_cast<int>(tiles_.size())};
      for (int k = 0; k < std::min(depth, cells_.nz - z); ++k)
        for (int l = 0; l < std::min(lanes, cells_.ny - tile * lanes); ++l) {
          const int line = tile * lanes + l + cells_.ny * (z + k), first = system.first_run[line],
                    last = system.first_run[line + 1] - 1;
          if (first > last) continue;
          all.begin = std::min(all.begin, system.runs[first].begin + l);
          all.end = std::max(all.end, system.runs[last].end + l);
        }
      if (all.begin < all.end) tiles_.push_back(all);
    }
  // Vector s of a tile has cells of x + y = s + 16 tile. A part waits for vectors of lesser x + y in the tile before,
  // and for the same vectors in the planes before.
  const int chunks = (cells_.nx + (tiles_along_y_ + 1) * lanes) / part_length + 1;
  stages_.resize(tiles_along_y_ + steps_along_z() + chunks);
  for (int chunk = 0; chunk < chunks; ++chunk)
    for (const Stretch& all : tiles_) {
      const int skew = all.tile * lanes, begin = std::max(all.begin, chunk * part_length - skew),
                end = std::min(all.end, (chunk + 1) * part_length - skew);
      if (begin < end) stages_[all.tile + all.z / depth + chunk].push_back({all.tile, all.z, begin, end, all.of});
    }
  std::erase_if(stages_, [](const std::vector<Stretch>& parts) { return parts.empty(); });

  const int slabs = (cells_.nz + side_of_a_block - 1) / side_of_a_block;
  blocks_.resize(std::size_t(slabs) * tiles_along_y_);
  for (const Stretch& all : tiles_) blocks_[all.z / side_of_a_block * tiles_along_y_ + all.tile].push_back(all);
}

// Neighbours of the sixteen cells at `at`.
LOCKSTEP_INLINE floatv low_x(const Real* at) { return load(at - Skewed::along_x); }
LOCKSTEP_INLINE floatv high_x(const Real* at) { return load(at + Skewed::along_x); }
LOCKSTEP_INLINE floatv low_y(const Skewed& skewed, const Real* at) {
  return shift_up(low_x(at), at[skewed.to_low_tile() + lanes - 1]);
}
LOCKSTEP_INLINE floatv high_y(const Skewed& skewed, const Real* at) {
  return shift_down(high_x(at), at[skewed.to_high_tile()]);
}
LOCKSTEP_INLINE floatv low_z(const Skewed& skewed, const Real* at) { return load(at - skewed.along_z()); }
LOCKSTEP_INLINE floatv high_z(const Skewed& skewed, const Real* at) { return load(at + skewed.along_z()); }

}  // namespace lockstep::production_fluid::openmp
