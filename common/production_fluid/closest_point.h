// How far a cell is from the closest point of the surface, where the surface is smooth. Formulas; of numbers or of
// lanes.
//
// Through four values along each axis goes a cubic, which passes through the surface with an error of fourth order. Of
// its points with phi = 0, p is closest to a cell's centre c if c - p has the direction of the slope g. Newton's method
// finds p:
//
//   p <- p - (phi / g^2) g + (c - p) - ((c - p) . g / g^2) g
//
// It begins at c - phi n, n the direction of phi's central differences, which is p already where phi is a distance. So
// two steps are enough: what is left of the way along the surface falls by distance / radius in each, and its square
// counts in the distance.
//
// A cubic that passes through both sides of a thin sheet has no kink in its middle, as distances have, and its zeros
// lie too far out: redistanced so, sheets grow. So p counts only where phi does not bend by more than `largest_bend` at
// the eight centres around p. Bend is a second difference along an axis. Of a distance it is the curvature, 1 / R
// beside a ball of R cells; at a centre d cells from a kink it is up to 2 (1 - d).
//
// Source: Chopp, Some improvements of the fast marching method, SIAM J. Sci. Comput. 23 (2001). The rule is ours.
#pragma once

#include "common/math.h"
#include "common/production_fluid/state.h"
#include "common/vector3.h"

namespace lockstep::production_fluid {

inline constexpr float largest_bend = .5f;  // per cell: the curvature of a ball of two cells' radius

// What the four values along an axis count at t of the way from the second to the third. A cubic is the straight line
// between these two, less shares of the second differences at both: so equal values have no slope, to the bit.
template <class Number>
struct CubicWeights {
  Number t, value[2], slope[2];
};
template <class Number>
inline CubicWeights<Number> cubic_weights(const Number& t) {
  const Number one(1), sixth(1 / 6.f), v = sixth * (t * (one - t)), square = Number(.5f) * (t * t);
  return {t, {v * (Number(2) - t), v * (one + t)}, {Number(1 / 3.f) - t + square, sixth - square}};
}

template <class Number>
struct AlongAxis {
  Number value, slope;
};
template <class Number>
inline AlongAxis<Number> along_axis(const Number& a, const Number& b, const Number& c, const Number& d,
                                    const CubicWeights<Number>& weights) {
  const Number rise = c - b, low = (a - b) + rise, high = (d - c) - rise;
  return {b + weights.t * rise - (weights.value[0] * low + weights.value[1] * high),
          rise - (weights.slope[0] * low + weights.slope[1] * high)};
}

// Values at four by four by four centres, by [z][y][x].
template <class Number>
struct Stencil {
  Number value[4][4][4];
};

// The cubic at a position, in cells from the second centre along each axis.
template <class Number>
struct Cubic {
  Number value;
  Vector3<Number> slope;  // per cell
};
template <class Number>
inline Cubic<Number> cubic_at(const Stencil<Number>& stencil, const Vector3<Number>& at) {
  const CubicWeights<Number> x = cubic_weights(at.x), y = cubic_weights(at.y), z = cubic_weights(at.z);
  const auto along = [](const auto& of, const CubicWeights<Number>& weights) {
    return along_axis(of(0), of(1), of(2), of(3), weights);
  };
  AlongAxis<Number> plane[4];
  Number plane_slope_x[4];
  for (int k = 0; k < 4; ++k) {
    AlongAxis<Number> line[4];
    for (int j = 0; j < 4; ++j) line[j] = along([&](int i) { return stencil.value[k][j][i]; }, x);
    plane[k] = along([&](int j) { return line[j].value; }, y);
    plane_slope_x[k] = along([&](int j) { return line[j].slope; }, y).value;
  }
  const AlongAxis<Number> all = along([&](int k) { return plane[k].value; }, z);
  return {all.value,
          {along([&](int k) { return plane_slope_x[k]; }, z).value,
           along([&](int k) { return plane[k].slope; }, z).value, all.slope}};
}

// The greatest second difference at the middle eight, along any axis.
template <class Number>
inline Number bend_of(const Stencil<Number>& stencil) {
  const auto& v = stencil.value;
  Number greatest(0);
  for (int k = 1; k < 3; ++k)
    for (int j = 1; j < 3; ++j)
      for (int i = 1; i < 3; ++i) {
        const Number here = v[k][j][i];
        const auto add = [&](const Number& a, const Number& b) {
          greatest = max(greatest, abs((a - here) + (b - here)));
        };
        add(v[k][j][i - 1], v[k][j][i + 1]), add(v[k][j - 1][i], v[k][j + 1][i]), add(v[k - 1][j][i], v[k + 1][j][i]);
      }
  return greatest;
}

// A number of a line of n; beyond its ends the nearest one.
template <class Index>
inline Index within_line(const Index& i, int n) {
  const Index below = select(i < Index(n - 1), i, Index(n - 1));
  return select(below > Index(0), below, Index(0));
}

// Loads the values of a stencil in one line, which begins at `line`: those at x[0], x[1] and so on, each the one before
// or one more. A loader that can do better has a load_row of its own.
template <class Load, class Index, class Number>
inline void load_row(const Load& load, const Index& line, const Index (&x)[4], Number (&row)[4]) {
  for (int a = 0; a < 4; ++a) row[a] = load(line + x[a]);
}

template <class Number>
struct ClosestPoint {
  Number distance;                            // m
  decltype(Number(0) < Number(0)) is_smooth;  // by bend, slope, the last move, and the box; else distance means nothing
};

// Of cell (x, y, z). Beyond the box, phi is what it is at its side. load(index) is an element of phi, counted from
// cell (0, 0, 0).
template <class Index, class Real, class Load>
inline auto closest_point(const Field<Real>& phi, const Index& x, const Index& y, const Index& z, const Load& load) {
  const Vector3<int> size = {phi.nx, phi.ny, phi.nz};
  const int to_plane = phi.pitch * phi.ny;
  const auto line_of = [&](const Index& j, const Index& k) {
    return within_line(k, size.z) * Index(to_plane) + within_line(j, size.y) * Index(phi.pitch);
  };
  const auto value = [&](const Index& i, const Index& j, const Index& k) {
    return load(line_of(j, k) + within_line(i, size.x));
  };
  using Number = decltype(value(x, y, z));
  const Number h(phi.spacing), tiny(1e-30f);

  // From the centre to p, in cells.
  const Index one(1);
  const Vector3<Number> rise = {value(x + one, y, z) - value(x - one, y, z),
                                value(x, y + one, z) - value(x, y - one, z),
                                value(x, y, z + one) - value(x, y, z - one)};
  Vector3<Number> way = (Number(0) - value(x, y, z) / (h * max(sqrt(dot(rise, rise)), tiny))) * rise;
  Number steepness(0), bend(0), left(0);
  for (int step = 0; step < 2; ++step) {
    // The second centre of the stencil, counted from the cell.
    const auto below = [](Number& along) {
      along = min(max(along, Number(-5)), Number(5));
      return to_int(along + Number(8)) - Index(8);
    };
    const Index i = below(way.x), j = below(way.y), k = below(way.z);
    Index along_x[4];
    for (int a = 0; a < 4; ++a) along_x[a] = within_line(x + i + Index(a - 1), size.x);
    Stencil<Number> stencil;
    for (int c = 0; c < 4; ++c)
      for (int b = 0; b < 4; ++b)
        load_row(load, line_of(y + j + Index(b - 1), z + k + Index(c - 1)), along_x, stencil.value[c][b]);
    const Cubic<Number> at =
        cubic_at(stencil, {way.x - Number(to_float(i)), way.y - Number(to_float(j)), way.z - Number(to_float(k))});
    const Number square = max(dot(at.slope, at.slope), tiny);
    // (c - p) is -way, so all but the part along the slope goes.
    const Vector3<Number> to = ((dot(way, at.slope) - at.value) / square) * at.slope, move = to - way;
    way = to;
    steepness = sqrt(square), bend = bend_of(stencil), left = dot(move, move);
  }
  const auto inside = [](const Number& at, int n) {
    return (at >= Number(-.5f)) & (at <= Number(static_cast<float>(n) - .5f));
  };
  const decltype(bend < bend) is_smooth =
      (bend <= Number(largest_bend) * h) & (steepness >= Number(.5f) * h) & (steepness <= Number(2) * h) &
      (left <= Number(.01f)) & inside(Number(to_float(x)) + way.x, size.x) &
      inside(Number(to_float(y)) + way.y, size.y) & inside(Number(to_float(z)) + way.z, size.z);
  return ClosestPoint<Number>{h * sqrt(dot(way, way)), is_smooth};
}

}  // namespace lockstep::production_fluid
