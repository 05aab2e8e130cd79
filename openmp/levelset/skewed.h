// A field of distances laid out along wavefronts: sixteen points that do not wait for one another in a sweep stand side
// by side.
//
// In a sweep along x and y, a point waits for its neighbours before it along x and along y. So in sixteen lines along
// x, one above the other, line l may work on point x = t - l at time t: all sixteen at once, each one step behind the
// line before. Lane l of vector t is that point. Then the neighbours along x are the same lanes of vectors t - 1 and t
// + 1, those along y the lanes beside in the same two vectors, and those along z the same lanes of vector t, a plane up
// or down: a sweep loads no lane twice.
//
// Sixteen lines are a tile; the first and last lane find their outer neighbours in the tiles beside. A sweep the other
// way along both x and y goes through the same vectors backwards. For sweeps along x and against y, the field is
// mirrored in y first.
//
// In a narrow band only the vectors that a sweep visits or reads are stored.
//
// No serial twin: a serial sweep visits points in the order of the field.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/levelset/field.h"
#include "common/levelset/reach.h"
#include "common/simd.h"

namespace lockstep::levelset::openmp {

class Skewed {
 public:
  Skewed(const Distances<float>& distances, const Reach& reach, bool mirrored);

  int tiles() const { return tiles_; }
  int planes() const { return nz_; }

  // The vectors of a tile in a plane that a sweep visits: runs begin .. end - 1, in order and apart.
  std::span<const Extent> runs(int tile, int z) const {
    const int line = z * tiles_ + tile;
    return {visited_.extents.data() + visited_.begin[line], visited_.extents.data() + visited_.begin[line + 1]};
  }

  int vectors(int tile, int z) const {  // in all its runs
    int n = 0;
    for (const auto& [begin, end] : runs(tile, z)) n += end - begin;
    return n;
  }

  // No diagonal of the (tile, plane) grid has more runs than this.
  std::size_t most_runs() const { return most_runs_; }

  // Vector t of a tile, and which of its lanes are fixed: interface points, and lanes beyond the field. What the sweep
  // of a run reads is stored, too: the vectors before and after it, those fifteen ahead in the tile before and fifteen
  // back in the tile after, and the same vectors of the planes before and after; beyond the field they are `far`.
  float* vector(int tile, int z, int t) const { return values_ + offset(tile, z, t) * lanes; }
  const std::uint16_t* fixed(int tile, int z, int t) const { return fixed_.data() + offset(tile, z, t); }

  std::size_t size() const { return fixed_.size() * lanes; }  // floats to store all vectors
  void read(const Field<float>& field, float* values);        // into the caller's `values`, aligned for lanes
  void write(Field<float>& field) const;                      // what a sweep visits, back to the field

 private:
  // Lines are the tiles of all planes, with one tile more on either side and one plane more on either side.
  int line(int tile, int z) const { return (z + 1) * (tiles_ + 2) + (tile + 1); }
  std::ptrdiff_t offset(int tile, int z, int t) const { return start_[line(tile, z)] + t; }
  // The field's line that lane l of a tile is, or -1 where there is none.
  int y_of(int tile, int z, int l) const {
    const int y = tile * lanes + l;
    if (tile < 0 || y >= ny_ || z < 0 || z >= nz_) return -1;
    return mirrored_ ? ny_ - 1 - y : y;
  }

  void find_visited(const Reach& reach);
  std::ptrdiff_t find_stored();
  void find_fixed(const std::vector<Point>& interface);

  int nx_, ny_, nz_, tiles_;
  bool mirrored_;
  Reach visited_, stored_;             // by tile: vectors that a sweep visits; by line: those that it visits or reads
  std::vector<std::ptrdiff_t> start_;  // [line]: where its vector 0 is, or would be
  std::vector<std::uint16_t> fixed_;   // [vector]: a bit a lane
  std::size_t most_runs_;
  float* values_ = nullptr;
};

// Marks on the vectors of one line after another, turned into runs.
class Marks {
 public:
  explicit Marks(int nx) : marks_(nx + lanes + 2 * margin), first_(static_cast<int>(marks_.size())) {}

  void mark(int begin, int end) {
    std::fill(marks_.begin() + begin + margin, marks_.begin() + end + margin, true);
    first_ = std::min(first_, begin + margin), last_ = std::max(last_, end + margin);
  }

  // Appends the line's runs, and forgets its marks.
  void close_line(Reach& runs) {
    runs.begin.push_back(static_cast<int>(runs.extents.size()));
    const auto last = marks_.begin() + last_;
    for (auto from = marks_.begin() + std::min(first_, last_); from != last;) {
      const auto begin = std::find(from, last, true), end = std::find(begin, last, false);
      if (begin != last)
        runs.extents.push_back({int(begin - marks_.begin()) - margin, int(end - marks_.begin()) - margin});
      from = end;
    }
    std::fill(marks_.begin(), marks_.begin() + last_, false);
    first_ = static_cast<int>(marks_.size()), last_ = 0;
  }

 private:
  static constexpr int margin = 2 * lanes;  // vectors with room before vector 0
  std::vector<char> marks_;
  int first_, last_ = 0;
};

inline Skewed::Skewed(const Distances<float>& distances, const Reach& reach, bool mirrored)
    : nx_(distances.distance.nx),
      ny_(distances.distance.ny),
      nz_(distances.distance.nz),
      tiles_((ny_ + lanes - 1) / lanes),
      mirrored_(mirrored) {
  find_visited(reach);
  fixed_.assign(find_stored(), 0);
  find_fixed(distances.interface);
}

// Lane l visits point x at time x + l.
inline void Skewed::find_visited(const Reach& reach) {
  Marks marks(nx_);
  std::size_t most = 0;  // of a tile in a plane
  for (int z = 0; z < nz_; ++z)
    for (int tile = 0; tile < tiles_; ++tile) {
      for (int l = 0; l < lanes; ++l)
        if (const int y = y_of(tile, z, l); y >= 0)
          for (int e = reach.begin[z * ny_ + y]; e < reach.begin[z * ny_ + y + 1]; ++e)
            marks.mark(reach.extents[e].begin + l, reach.extents[e].end + l);
      marks.close_line(visited_);
      most = std::max(most, visited_.extents.size() - visited_.begin.back());
    }
  visited_.begin.push_back(static_cast<int>(visited_.extents.size()));
  most_runs_ = most * std::min(tiles_, nz_);
}

// Returns how many vectors are stored.
inline std::ptrdiff_t Skewed::find_stored() {
  Marks marks(nx_);
  const auto mark_runs_of = [&](int tile, int z, int before, int after) {
    if (tile >= 0 && tile < tiles_ && z >= 0 && z < nz_)
      for (const auto& [begin, end] : runs(tile, z)) marks.mark(begin + before, end + after);
  };
  std::ptrdiff_t vectors = 0;
  for (int z = -1; z <= nz_; ++z)
    for (int tile = -1; tile <= tiles_; ++tile) {
      constexpr int aside = lanes - 1;
      mark_runs_of(tile, z, -1, 1), mark_runs_of(tile + 1, z, aside, aside), mark_runs_of(tile - 1, z, -aside, -aside);
      mark_runs_of(tile, z - 1, 0, 0), mark_runs_of(tile, z + 1, 0, 0);
      const std::size_t first = stored_.extents.size();
      marks.close_line(stored_);
      // `read` and `write` take sixteen vectors at a time, up to fifteen beyond a line's last: room for them, too.
      const bool any = stored_.extents.size() > first;
      start_.push_back(any ? vectors - stored_.extents[first].begin : vectors);
      if (any) vectors += stored_.extents.back().end - stored_.extents[first].begin + lanes;
    }
  stored_.begin.push_back(static_cast<int>(stored_.extents.size()));
  return vectors;
}

inline void Skewed::find_fixed(const std::vector<Point>& interface) {
  for (int z = 0; z < nz_; ++z)
    for (int tile = 0; tile < tiles_; ++tile)
      for (const auto& [begin, end] : runs(tile, z))
        for (int t = begin; t < end; ++t) {
          const intv x = intv(t) - lane_index();
          const maskv there = (x >= 0) & (x < nx_) & first_lanes(ny_ - tile * lanes);
          fixed_[offset(tile, z, t)] = static_cast<std::uint16_t>(~bits(there));
        }
  for (const auto& [x, plain_y, z] : interface) {
    const int y = mirrored_ ? ny_ - 1 - plain_y : plain_y, l = y % lanes;
    fixed_[offset(y / lanes, z, x + l)] |= static_cast<std::uint16_t>(1 << l);
  }
}

// Lane l of vectors t .. t + 15 is sixteen points of its line from x = t - l on: sixteen loads, and a transpose. The
// same points of the next tile are prefetched: a band goes on there, and the processor does not foresee sixteen short
// lines.
inline void Skewed::read(const Field<float>& field, float* values) {
  values_ = values;
  const std::ptrdiff_t next_tile = (mirrored_ ? -lanes : lanes) * field.pitch;
  // An iteration writes the vectors of its own tile, and the field is only read.
#pragma omp parallel for collapse(2) schedule(dynamic, 16)
  for (int z = -1; z <= nz_; ++z)
    for (int tile = -1; tile <= tiles_; ++tile) {
      for (int e = stored_.begin[line(tile, z)]; e < stored_.begin[line(tile, z) + 1]; ++e)
        for (int t = stored_.extents[e].begin; t < stored_.extents[e].end; t += lanes) {
          floatv square[lanes];
          for (int l = 0; l < lanes; ++l) {
            const int y = y_of(tile, z, l);
            if (y < 0) {
              square[l] = far<float>;
              continue;
            }
            const float* const at = &field.value[field.index(t - l, y, z)];
            square[l] = load(at);
            __builtin_prefetch(at + next_tile);
          }
          transpose(square);
          for (int i = 0; i < lanes; ++i) store(vector(tile, z, t + i), square[i]);
        }
    }
}

inline void Skewed::write(Field<float>& field) const {
  // An iteration reads its own tile, and writes the field's lines that are in it.
#pragma omp parallel for collapse(2) schedule(dynamic, 16)
  for (int z = 0; z < nz_; ++z)
    for (int tile = 0; tile < tiles_; ++tile)
      for (const auto& [begin, end] : runs(tile, z))
        for (int t = begin; t < end; t += lanes) {
          floatv square[lanes];
          for (int i = 0; i < lanes; ++i) square[i] = load(vector(tile, z, t + i));
          transpose(square);
          const maskv in_run = first_lanes(end - t);
          for (int l = 0; l < lanes; ++l)
            if (const int y = y_of(tile, z, l); y >= 0)
              store(&field.value[field.index(t - l, y, z)], square[l], in_run);
        }
}

}  // namespace lockstep::levelset::openmp
