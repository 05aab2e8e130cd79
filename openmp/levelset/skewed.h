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
// way along both x and y goes through the same vectors backwards. Sweeps along x and against y go through another
// layout, mirrored in y. Its tiles are of the same lines, so the two layouts share their memory, and one becomes the
// other tile by tile.
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
  // for_each(n, f) calls f(0) .. f(n - 1) in any order, and may share them among threads.
  template <class ForEach>
  Skewed(const Distances<float>& distances, const Reach& reach, bool mirrored, const ForEach& for_each);

  int tiles() const { return tiles_; }
  int planes() const { return nz_; }
  int vectors_of_line() const { return nx_ + lanes - 1; }  // 0 .. that less 1, where a sweep visits them all

  // The vectors of a tile in a plane that a sweep visits: runs begin .. end - 1, in order and apart.
  std::span<const Extent> runs(int tile, int z) const {
    const int line = z * tiles_ + tile;
    return {visited_.extents.data() + visited_.begin[line], visited_.extents.data() + visited_.begin[line + 1]};
  }

  // Vector t of a tile, and which of its lanes are fixed: interface points, and lanes beyond the field. What the sweep
  // of a run reads is stored, too: the vectors before and after it, those fifteen ahead in the tile before and fifteen
  // back in the tile after, and the same vectors of the planes before and after; beyond the field they are `far`.
  float* vector(int tile, int z, int t) const { return values_ + offset(tile, z, t) * lanes; }
  const std::uint16_t* fixed(int tile, int z, int t) const { return fixed_ + offset(tile, z, t); }

  // Finds room for two layouts of one field in the same memory. They take so many floats, aligned for lanes.
  friend std::size_t share(Skewed& a, Skewed& b);
  // Takes the caller's memory, of as many floats as `share` says.
  void place(float* values);

  // What follows is done plane by plane, z from 0 to planes() - 1, in any order.
  void find_fixed(const std::vector<Point>& interface, int z);
  // Interface points get their distances, all else is `far`. Of one of the two layouts, placed.
  void begin(const Distances<float>& distances, int z);
  // Takes over from the other layout. `lines` are lines_to_take() floats, all `far`, and are left so.
  void take(const Skewed& other, int z, float* lines);
  std::size_t lines_to_take() const { return static_cast<std::size_t>(lanes) * line_to_take(); }
  void write(Field<float>& field, int z) const;  // what a sweep visits, back to the field

 private:
  // Lines are the tiles of all planes, with one tile more on either side and one plane more on either side.
  int lines() const { return (nz_ + 2) * (tiles_ + 2); }
  int line(int tile, int z) const { return (z + 1) * (tiles_ + 2) + (mirrored_ ? tiles_ - tile : tile + 1); }
  std::ptrdiff_t offset(int tile, int z, int t) const { return start_[line(tile, z)] + t; }
  // Which of all tiles' lanes line y of the field is, and the other way round.
  int mirror(int y) const { return mirrored_ ? tiles_ * lanes - 1 - y : y; }
  bool is_there(int tile, int l) const {
    const int y = mirror(tile * lanes + l);
    return y >= 0 && y < ny_;
  }

  Reach visited_of_plane(const Reach& reach, int z) const;
  Reach stored_of_plane(int z) const;
  void make_far(int z);
  int line_to_take() const { return nx_ + lanes + 3 * Field<float>::padding; }  // floats

  int nx_, ny_, nz_, tiles_;
  bool mirrored_;
  Reach visited_, stored_;             // by tile: vectors that a sweep visits; by line: those that it visits or reads
  std::vector<std::ptrdiff_t> start_;  // [line]: where its vector 0 is, or would be
  std::vector<std::ptrdiff_t> room_;   // [line]: where its room begins; and where that of the last one ends
  std::uint16_t* fixed_ = nullptr;     // [vector]: a bit a lane
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

template <class ForEach>
Skewed::Skewed(const Distances<float>& distances, const Reach& reach, bool mirrored, const ForEach& for_each)
    : nx_(distances.distance.nx),
      ny_(distances.distance.ny),
      nz_(distances.distance.nz),
      tiles_((ny_ + lanes - 1) / lanes),
      mirrored_(mirrored) {
  std::vector<Reach> planes(nz_);
  for_each(nz_, [&](int z) { planes[z] = visited_of_plane(reach, z); });
  visited_ = join_planes(planes, tiles_, for_each);
  planes.resize(nz_ + 2);
  for_each(nz_ + 2, [&](int i) { planes[i] = stored_of_plane(i - 1); });
  stored_ = join_planes(planes, tiles_ + 2, for_each);
}

// Lane l visits point x at time x + l.
inline Reach Skewed::visited_of_plane(const Reach& reach, int z) const {
  Reach plane;
  Marks marks(nx_);
  for (int tile = 0; tile < tiles_; ++tile) {
    for (int l = 0; l < lanes; ++l)
      if (is_there(tile, l)) {
        const int line = z * ny_ + mirror(tile * lanes + l);
        for (int e = reach.begin[line]; e < reach.begin[line + 1]; ++e)
          marks.mark(reach.extents[e].begin + l, reach.extents[e].end + l);
      }
    marks.close_line(plane);
  }
  return plane;
}

inline Reach Skewed::stored_of_plane(int z) const {
  Reach plane;
  Marks marks(nx_);
  const auto mark_runs_of = [&](int tile, int z, int before, int after) {
    if (tile >= 0 && tile < tiles_ && z >= 0 && z < nz_)
      for (const auto& [begin, end] : runs(tile, z)) marks.mark(begin + before, end + after);
  };
  for (int i = -1; i <= tiles_; ++i) {
    const int tile = mirrored_ ? tiles_ - 1 - i : i;
    constexpr int aside = lanes - 1;
    mark_runs_of(tile, z, -1, 1), mark_runs_of(tile + 1, z, aside, aside), mark_runs_of(tile - 1, z, -aside, -aside);
    mark_runs_of(tile, z - 1, 0, 0), mark_runs_of(tile, z + 1, 0, 0);
    marks.close_line(plane);
  }
  return plane;
}

inline std::size_t share(Skewed& a, Skewed& b) {
  std::ptrdiff_t vectors = 0;
  for (int line = 0; line < a.lines(); ++line) {
    std::ptrdiff_t room = 0;
    for (Skewed* d : {&a, &b}) {
      d->room_.push_back(vectors);
      const Extent* const extents = d->stored_.extents.data();
      const Extent *const first = extents + d->stored_.begin[line], *const end = extents + d->stored_.begin[line + 1];
      d->start_.push_back(first < end ? vectors - first->begin : vectors);
      // Sixteen vectors are taken at a time, up to fifteen beyond a line's last.
      if (first < end) room = std::max(room, std::ptrdiff_t(end[-1].end - first->begin + lanes));
    }
    vectors += room;
  }
  for (Skewed* d : {&a, &b}) d->room_.push_back(vectors);
  return vectors * (lanes + 1);  // values, and the bits of both layouts
}

inline void Skewed::place(float* values) {
  values_ = values;
  fixed_ = reinterpret_cast<std::uint16_t*>(values + room_.back() * lanes) + (mirrored_ ? room_.back() : 0);
}

inline void Skewed::find_fixed(const std::vector<Point>& interface, int z) {
  for (int tile = 0; tile < tiles_; ++tile) {
    unsigned lines = 0;
    for (int l = 0; l < lanes; ++l) lines |= unsigned(is_there(tile, l)) << l;
    for (const auto& [begin, end] : runs(tile, z))
      for (int t = begin; t < end; ++t) {
        const intv x = intv(t) - lane_index();
        const maskv there = (x >= 0) & (x < nx_) & lanes_of(lines);
        fixed_[offset(tile, z, t)] = static_cast<std::uint16_t>(~bits(there));
      }
  }
  for (const auto& [x, y, _] : points_of_plane(interface, z)) {
    const int l = mirror(y) % lanes;
    fixed_[offset(mirror(y) / lanes, z, x + l)] |= static_cast<std::uint16_t>(1 << l);
  }
}

inline void Skewed::make_far(int z) {
  const auto plane = room_.begin() + (z + 1) * (tiles_ + 2);
  std::fill(values_ + plane[0] * lanes, values_ + plane[tiles_ + 2] * lanes, far<float>);
}

inline void Skewed::begin(const Distances<float>& distances, int z) {
  make_far(z);
  if (z == 0) make_far(-1);
  if (z == nz_ - 1) make_far(nz_);
  for (const auto& [x, y, _] : points_of_plane(distances.interface, z)) {
    const int l = mirror(y) % lanes;
    vector(mirror(y) / lanes, z, x + l)[l] = distances.distance(x, y, z);
  }
}

// Lane l of vectors t .. t + 15 is sixteen points of its line from x = t - l on: sixteen loads, and a transpose.
inline void Skewed::take(const Skewed& other, int z, float* lines) {
  const std::ptrdiff_t line_floats = line_to_take();
  const auto line_of = [&](int l) { return lines + Field<float>::padding + l * line_floats; };
  for (int tile = 0; tile < tiles_; ++tile) {
    const int of_other = tiles_ - 1 - tile;
    for (const auto& [begin, end] : other.runs(of_other, z))
      for (int t = begin; t < end; t += lanes) {
        floatv square[lanes];
        for (int i = 0; i < lanes; ++i) square[i] = load(other.vector(of_other, z, t + i));
        transpose(square);
        for (int l = 0; l < lanes; ++l) store(line_of(lanes - 1 - l) + t - l, square[l], first_lanes(end - t));
      }
    for (int e = stored_.begin[line(tile, z)]; e < stored_.begin[line(tile, z) + 1]; ++e)
      for (int t = stored_.extents[e].begin; t < stored_.extents[e].end; t += lanes) {
        floatv square[lanes];
        for (int l = 0; l < lanes; ++l) square[l] = load(line_of(l) + t - l);
        transpose(square);
        for (int i = 0; i < lanes; ++i) store(vector(tile, z, t + i), square[i]);
      }
    for (const auto& [begin, end] : other.runs(of_other, z))
      for (int l = 0; l < lanes; ++l) std::fill_n(line_of(lanes - 1 - l) + begin - l, end - begin, far<float>);
  }
}

inline void Skewed::write(Field<float>& field, int z) const {
  for (int tile = 0; tile < tiles_; ++tile)
    for (const auto& [begin, end] : runs(tile, z))
      for (int t = begin; t < end; t += lanes) {
        floatv square[lanes];
        for (int i = 0; i < lanes; ++i) square[i] = load(vector(tile, z, t + i));
        transpose(square);
        const maskv in_run = first_lanes(end - t);
        for (int l = 0; l < lanes; ++l)
          if (is_there(tile, l))
            store(&field.value[field.index(t - l, mirror(tile * lanes + l), z)], square[l], in_run);
      }
}

}  // namespace lockstep::levelset::openmp
