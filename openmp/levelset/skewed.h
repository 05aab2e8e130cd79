// A field of distances laid out so that sixteen points which do not wait for one another in a sweep stand side by side.
//
// In a sweep along x and y, a point waits for its neighbours before it along x and along y. So in sixteen lines along x, one above the
// other, line l may work on point x = t - l at time t: all sixteen at once, each one step behind the line before. Lane l of vector t
// is that point. Then the neighbours along x are the same lanes of vectors t - 1 and t + 1, those along y the lanes beside in
// the same two vectors, and those along z the same lanes of vector t, a plane up or down: a sweep loads no lane twice.
//
// Sixteen lines are a tile; the first and last lane find their outer neighbours in the tiles beside. A sweep the other way along both x
// and y goes through the same vectors backwards. For sweeps along x and against y, the field is mirrored in y first.
//
// In a narrow band only the vectors that a sweep goes through, or looks at, are there at all.
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

  // The vectors of a tile in a plane that a sweep goes through: runs begin .. end - 1, in order and apart.
  std::span<const Extent> runs(int tile, int z) const {
    const int line = z * tiles_ + tile;
    return {sweep_.extents.data() + sweep_.begin[line], sweep_.extents.data() + sweep_.begin[line + 1]};
  }

  int vectors(int tile, int z) const {  // in all its runs
    int n = 0;
    for (const auto& [begin, end] : runs(tile, z)) n += end - begin;
    return n;
  }

  // Vector t of a tile, and which of its lanes must stay as they are: interface points, and lanes beyond the field. What a run looks at
  // is there, too: the vectors before and after it, those fifteen ahead in the tile before and fifteen back in the tile after, and the
  // same vectors of the planes before and after; beyond the field they are `far`.
  float* vector(int tile, int z, int t) const { return values_ + place(tile, z, t) * lanes; }
  const std::uint16_t* standing(int tile, int z, int t) const { return standing_.data() + place(tile, z, t); }

  std::size_t size() const { return standing_.size() * lanes; }  // floats that it takes
  void take(const Field<float>& field, float* values);           // from the plain layout, into the caller's `values`, aligned for lanes
  void give_back(Field<float>& field) const;                     // to it

 private:
  // Lines are the tiles of all planes, with one tile more on either side and one plane more on either side.
  int line(int tile, int z) const { return (z + 1) * (tiles_ + 2) + (tile + 1); }
  std::ptrdiff_t place(int tile, int z, int t) const { return start_[line(tile, z)] + t; }
  // The field's line that lane l of a tile is, or -1 where there is none.
  int y_of(int tile, int z, int l) const {
    const int y = tile * lanes + l;
    if (tile < 0 || y >= ny_ || z < 0 || z >= nz_) return -1;
    return mirrored_ ? ny_ - 1 - y : y;
  }

  int nx_, ny_, nz_, tiles_;
  bool mirrored_;
  Reach sweep_, taken_;                // by tile: what a sweep goes through; by line: what it goes through or looks at
  std::vector<std::ptrdiff_t> start_;  // [line]: where its vector 0 is, or would be
  std::vector<std::uint16_t> standing_;
  float* values_ = nullptr;
};

inline Skewed::Skewed(const Distances<float>& distances, const Reach& reach, bool mirrored)
    : nx_(distances.distance.nx),
      ny_(distances.distance.ny),
      nz_(distances.distance.nz),
      tiles_((ny_ + lanes - 1) / lanes),
      mirrored_(mirrored) {
  // Marks on the vectors of a line, turned into runs; `margin` vectors before 0 have room.
  constexpr int margin = 2 * lanes;
  std::vector<char> marks(nx_ + lanes + 2 * margin);
  int first_mark = static_cast<int>(marks.size()), last_mark = 0;
  const auto mark = [&](int begin, int end) {
    std::fill(marks.begin() + begin + margin, marks.begin() + end + margin, true);
    first_mark = std::min(first_mark, begin + margin), last_mark = std::max(last_mark, end + margin);
  };
  const auto close_line = [&](Reach& runs) {
    runs.begin.push_back(static_cast<int>(runs.extents.size()));
    const auto last = marks.begin() + last_mark;
    for (auto from = marks.begin() + std::min(first_mark, last_mark); from != last;) {
      const auto begin = std::find(from, last, true), end = std::find(begin, last, false);
      if (begin != last) runs.extents.push_back({int(begin - marks.begin()) - margin, int(end - marks.begin()) - margin});
      from = end;
    }
    std::fill(marks.begin(), marks.begin() + last_mark, false);
    first_mark = static_cast<int>(marks.size()), last_mark = 0;
  };
  for (int z = 0; z < nz_; ++z)
    for (int tile = 0; tile < tiles_; ++tile) {
      for (int l = 0; l < lanes; ++l)
        if (const int y = y_of(tile, z, l); y >= 0)
          for (int e = reach.begin[z * ny_ + y]; e < reach.begin[z * ny_ + y + 1]; ++e)
            mark(reach.extents[e].begin + l, reach.extents[e].end + l);
      close_line(sweep_);
    }
  sweep_.begin.push_back(static_cast<int>(sweep_.extents.size()));

  const auto mark_runs_of = [&](int tile, int z, int before, int after) {
    if (tile >= 0 && tile < tiles_ && z >= 0 && z < nz_)
      for (const auto& [begin, end] : runs(tile, z)) mark(begin + before, end + after);
  };
  std::ptrdiff_t vectors = 0;
  for (int z = -1; z <= nz_; ++z)
    for (int tile = -1; tile <= tiles_; ++tile) {
      constexpr int aside = lanes - 1;
      mark_runs_of(tile, z, -1, 1), mark_runs_of(tile + 1, z, aside, aside), mark_runs_of(tile - 1, z, -aside, -aside);
      mark_runs_of(tile, z - 1, 0, 0), mark_runs_of(tile, z + 1, 0, 0);
      const std::size_t first = taken_.extents.size();
      close_line(taken_);
      // A line has room from its first vector on to its last, which is taken with up to fifteen more.
      const bool any = taken_.extents.size() > first;
      start_.push_back(any ? vectors - taken_.extents[first].begin : vectors);
      if (any) vectors += taken_.extents.back().end - taken_.extents[first].begin + lanes;
    }
  taken_.begin.push_back(static_cast<int>(taken_.extents.size()));

  standing_.assign(vectors, 0);
  for (int z = 0; z < nz_; ++z)
    for (int tile = 0; tile < tiles_; ++tile)
      for (const auto& [begin, end] : runs(tile, z))
        for (int t = begin; t < end; ++t) {
          const intv x = intv(t) - lane_index();
          const maskv there = (x >= 0) & (x < nx_) & first_lanes(ny_ - tile * lanes);
          standing_[place(tile, z, t)] = static_cast<std::uint16_t>(~bits(there));
        }
  for (const auto& [x, plain_y, z] : distances.interface) {
    const int y = mirrored_ ? ny_ - 1 - plain_y : plain_y, l = y % lanes;
    standing_[place(y / lanes, z, x + l)] |= static_cast<std::uint16_t>(1 << l);
  }
}

// Lane l of vectors t .. t + 15 is sixteen points of its line from x = t - l on: sixteen loads, and rows and columns change places.
inline void Skewed::take(const Field<float>& field, float* values) {
  values_ = values;
  // Every tile is one thread's.
#pragma omp parallel for collapse(2) schedule(dynamic, 16)
  for (int z = -1; z <= nz_; ++z)
    for (int tile = -1; tile <= tiles_; ++tile) {
      for (int e = taken_.begin[line(tile, z)]; e < taken_.begin[line(tile, z) + 1]; ++e)
        for (int t = taken_.extents[e].begin; t < taken_.extents[e].end; t += lanes) {
          floatv square[lanes];
          for (int l = 0; l < lanes; ++l) {
            const int y = y_of(tile, z, l);
            square[l] = y >= 0 ? load(&field.value[field.index(t - l, y, z)]) : floatv(far<float>);
          }
          transpose(square);
          for (int i = 0; i < lanes; ++i) store(vector(tile, z, t + i), square[i]);
        }
    }
}

inline void Skewed::give_back(Field<float>& field) const {
  // Every tile is one thread's, and so are the lines that it is.
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
            if (const int y = y_of(tile, z, l); y >= 0) store(&field.value[field.index(t - l, y, z)], square[l], in_run);
        }
}

}  // namespace lockstep::levelset::openmp
