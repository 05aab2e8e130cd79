#include "common/cloth/read_bodies.h"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "common/cloth/limits.h"
#include "common/scene_reader.h"

namespace lockstep::cloth {
namespace {

double radius_of(const toml::table& table) { return *number_between(table, "radius", smallest, largest, "m"); }

// The axes after rotations about x, then y, then z.
std::array<Vector3<double>, 3> turned_axes(Vector3<double> degrees) {
  const auto sine_and_cosine = [](double angle) {
    const double radians = angle * (std::numbers::pi / 180);
    return std::pair(std::sin(radians), std::cos(radians));
  };
  const auto [sx, cx] = sine_and_cosine(degrees.x);
  const auto [sy, cy] = sine_and_cosine(degrees.y);
  const auto [sz, cz] = sine_and_cosine(degrees.z);
  return {Vector3<double>{cz * cy, sz * cy, -sy},
          {cz * sy * sx - sz * cx, sz * sy * sx + cz * cx, cy * sx},
          {cz * sy * cx + sz * sx, sz * sy * cx - cz * sx, cy * cx}};
}

}  // namespace

Plane<double> plane_of(const toml::table& table) {
  const Vector3<double> n = *vector(table, "normal", "any unit"), p = *vector(table, "point", "m");
  const double length = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
  if (!(length >= smallest)) refuse_value(*table.get("normal"), "normal", "a direction, not zero");
  const Vector3<double> normal = {n.x / length, n.y / length, n.z / length};
  return {.normal = normal, .offset = normal.x * p.x + normal.y * p.y + normal.z * p.z};
}

Capsule<double> sphere_of(const toml::table& table) {
  const Vector3<double> centre = *vector(table, "centre", "m");
  return {.from = centre, .to = centre, .radius = radius_of(table)};
}

Capsule<double> capsule_of(const toml::table& table) {
  return {.from = *vector(table, "from", "m"), .to = *vector(table, "to", "m"), .radius = radius_of(table)};
}

Box<double> box_of(const toml::table& table) {
  return {.centre = *vector(table, "centre", "m"),
          .half = *vector_between(table, "half", smallest, largest, "m"),
          .axis = turned_axes(vector(table, "turn", "degrees").value_or(Vector3<double>{0, 0, 0}))};
}

}  // namespace lockstep::cloth
