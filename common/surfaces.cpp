#include "common/surfaces.h"

#include <array>
#include <cmath>
#include <numbers>

namespace lockstep {

using Vector = Vector3<float>;

int Surfaces::add_point(const Vector& p) {
  points.push_back(p);
  return static_cast<int>(points.size()) - 1;
}

void Surfaces::add_polygon(std::span<const std::int32_t> corners) {
  polygons.push_back(static_cast<std::int32_t>(corners.size()));
  polygons.insert(polygons.end(), corners.begin(), corners.end());
  ++count;
}

Axes axes_along(const Vector& y, const Vector& origin) {
  // The axis of the world that y is farthest from gives a product far from zero.
  const float ax = std::abs(y.x), ay = std::abs(y.y), az = std::abs(y.z);
  const Vector far = az <= ax && az <= ay ? Vector{0, 0, 1} : ax <= ay ? Vector{1, 0, 0} : Vector{0, 1, 0};
  const Vector across = cross(y, far), x = (1 / std::sqrt(dot(across, across))) * across;
  return {origin, x, y, cross(x, y)};
}

// Rings around y from the south to the north. A sphere has its equator once.
void add_capsule(Surfaces& to, const Axes& axes, float half, float radius, int sides) {
  const int quarter = sides / 4;
  const int south = to.add_point(axes({0, -half - radius, 0}));
  int rings = 0;
  const auto add_ring = [&](float middle, int steps) {
    const float latitude = std::numbers::pi_v<float> / 2 * steps / quarter;
    const float y = middle + radius * std::sin(latitude), r = radius * std::cos(latitude);
    for (int k = 0; k < sides; ++k) {
      const float angle = 2 * std::numbers::pi_v<float> / sides * k;
      to.add_point(axes({r * std::sin(angle), y, r * std::cos(angle)}));
    }
    ++rings;
  };
  for (int steps = 1 - quarter; steps <= 0; ++steps) add_ring(-half, steps);
  for (int steps = half > 0 ? 0 : 1; steps < quarter; ++steps) add_ring(half, steps);
  const int north = to.add_point(axes({0, half + radius, 0}));

  const auto at = [&](int ring, int k) { return south + 1 + ring * sides + k % sides; };
  for (int k = 0; k < sides; ++k) {
    to.add_polygon(std::array{south, at(0, k + 1), at(0, k)});
    for (int ring = 0; ring + 1 < rings; ++ring)
      to.add_polygon(std::array{at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)});
    to.add_polygon(std::array{at(rings - 1, k), at(rings - 1, k + 1), north});
  }
}

void add_box(Surfaces& to, const Axes& axes, const Vector& half) {
  const int first = static_cast<int>(to.points.size());  // of the corners, 4 z + 2 y + x, from - to +
  for (const float z : {-half.z, half.z})
    for (const float y : {-half.y, half.y})
      for (const float x : {-half.x, half.x}) to.add_point(axes({x, y, z}));
  constexpr int faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& [a, b, c, d] : faces) to.add_polygon(std::array{first + a, first + b, first + c, first + d});
}

void add_square(Surfaces& to, const Axes& axes, float half) {
  const int first = static_cast<int>(to.points.size());
  for (const auto& [x, z] : {std::array{-half, -half}, {-half, half}, {half, half}, {half, -half}})
    to.add_point(axes({x, 0, z}));
  to.add_polygon(std::array{first, first + 1, first + 2, first + 3});
}

void add_plane(Surfaces& to, const Vector& normal, const Vector& on, const Vector& low, const Vector& high) {
  const bool alone = !(low.x <= high.x);
  const Vector from_plane = alone ? Vector{0, 0, 0} : .5f * (low + high) - on;
  const Vector diagonal = alone ? Vector{0, 0, 0} : high - low;
  const Vector foot = on + (from_plane - dot(from_plane, normal) * normal);
  add_square(to, axes_along(normal, foot), 1 + .6f * std::sqrt(dot(diagonal, diagonal)));
}

}  // namespace lockstep
