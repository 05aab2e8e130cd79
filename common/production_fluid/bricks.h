// Bricks: boxes of 16 x 4 x 4 points, a vector of lanes wide, that fill a grid. Advection skips whole bricks: far from
// the surface the level set is the same everywhere, and far out in the air the velocity is zero.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/production_fluid/state.h"

namespace lockstep::production_fluid {

// Points begin .. end - 1.
struct Span {
  int begin, end;
};
struct Box {
  Span x, y, z;
};

// The part of a box that is in a field.
template <class Real>
inline Box inside(const Field<Real>& field, const Box& box) {
  const auto cut = [](const Span& span, int n) { return Span{std::max(span.begin, 0), std::min(span.end, n)}; };
  return {cut(box.x, field.nx), cut(box.y, field.ny), cut(box.z, field.nz)};
}

// The points of a box and those beside them.
inline Box around(const Box& box) {
  const auto wider = [](const Span& span) { return Span{span.begin - 1, span.end + 1}; };
  return {wider(box.x), wider(box.y), wider(box.z)};
}

// The bricks of a grid of nx x ny x nz cells, in rows along x, and which of them are left to do. The last brick along
// an axis has the cells that are left, and the last face. Work goes along the lines of a row, as memory does: brick by
// brick, advection took up to 1.6 times as long.
class Bricks {
 public:
  // All are left.
  Bricks(int nx, int ny, int nz) : nx_(nx), ny_(ny), nz_(nz), is_left_(std::size_t(rows()) * along_x(), 1) {}

  int rows() const { return bricks(ny_, 4) * bricks(nz_, 4); }
  int along_x() const { return bricks(nx_, 16); }

  Box row(int row) const {
    return {{0, nx_ + 1}, span(row % bricks(ny_, 4), ny_, 4), span(row / bricks(ny_, 4), nz_, 4)};
  }
  Box brick(int row, int k) const {
    const Box whole = this->row(row);
    return {span(k, nx_, 16), whole.y, whole.z};
  }

  // Marks brick k of a row as done.
  void settle(int row, int k) { is_left_[row * along_x() + k] = 0; }
  bool is_left(int row, int k) const { return is_left_[row * along_x() + k]; }
  bool all_are_left() const { return std::find(is_left_.begin(), is_left_.end(), 0) == is_left_.end(); }

  // Calls f(span along x, y, z) for each line of a row and each stretch of bricks that are left.
  template <class Real, class F>
  void for_each_span(const Field<Real>& field, int row, const F& f) const {
    const std::uint8_t* const is_left = &is_left_[row * along_x()];
    if (std::find(is_left, is_left + along_x(), 1) == is_left + along_x()) return;
    const Box lines = inside(field, this->row(row));
    for (int z = lines.z.begin; z < lines.z.end; ++z)
      for (int y = lines.y.begin; y < lines.y.end; ++y)
        for (int k = 0, end; k < along_x(); k = end + 1) {
          for (end = k; end < along_x() && is_left[end];) ++end;
          if (end > k) f(Span{k * 16, end == along_x() ? lines.x.end : end * 16}, y, z);
        }
  }

 private:
  static int bricks(int n, int side) { return (n + side - 1) / side; }
  static Span span(int i, int n, int side) { return {i * side, i + 1 == bricks(n, side) ? n + 1 : (i + 1) * side}; }

  int nx_, ny_, nz_;
  std::vector<std::uint8_t> is_left_;
};

}  // namespace lockstep::production_fluid
