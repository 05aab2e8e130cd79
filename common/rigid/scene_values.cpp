#include "common/rigid/scene_values.h"

#include <algorithm>
#include <cmath>

#include "common/digits.h"
#include "common/input_error.h"
#include "common/memory.h"
#include "common/rigid/scene.h"

namespace lockstep::rigid {
namespace {

using Vector = Vector3<double>;

Quaternion<double> read_orientation(const toml::table& table) {
  const toml::node* value = table.get("orientation");
  if (!value) return no_rotation;
  const std::string expected = "a unit quaternion [x, y, z, w], its square 1 to within 0.001";
  const toml::array* array = value->as_array();
  if (!array || array->size() != 4) refuse_value(*value, "orientation", expected);
  double q[4], square = 0;
  for (int k = 0; k < 4; ++k) {
    const std::optional<double> x = as_number((*array)[k]);
    if (!x) refuse_value((*array)[k], "orientation", expected);
    q[k] = *x;
    square += q[k] * q[k];
  }
  if (!(std::abs(square - 1) <= 1e-3)) refuse_value(*value, "orientation", expected);
  const double scale = 1 / std::sqrt(square);
  return {scale * q[0], scale * q[1], scale * q[2], scale * q[3]};
}

}  // namespace

std::optional<double> read_length(const toml::table& table, std::string_view key) {
  return number_between(table, key, shortest, longest, "m");
}

Vector near_vector(const toml::table& table, std::string_view key, std::string_view unit) {
  const Vector v = vector(table, key, unit).value_or(Vector{0, 0, 0});
  for (const double x : {v.x, v.y, v.z})
    if (!(std::abs(x) <= farthest))
      refuse_value(*table.get(key), key, "numbers of at most 1e6, in " + std::string(unit));
  return v;
}

Vector read_box(const toml::table& table) { return *vector_between(table, "box", shortest, longest, "m"); }

std::optional<double> read_mass(const toml::table& table) { return number_between(table, "mass", 1e-6, 1e9, "kg"); }

Surface read_surface(const toml::table& table, const Surface& otherwise) {
  return {.friction = number_between(table, "friction", 0, 100, "").value_or(otherwise.friction),
          .restitution = number_between(table, "restitution", 0, 1, "").value_or(otherwise.restitution)};
}

Pose<double> read_pose(const toml::table& table) {
  return {near_vector(table, "position", "m"), read_orientation(table), 0};
}

double making_bytes(double bodies, double triangles) {
  const auto bytes_of = [&](double reals, double indices) {
    return reals * (sizeof(double) + sizeof(float)) + indices * sizeof(int);
  };
  const double collider = bytes_of(8 + 4, 2 * 3);  // place and size; kind, body and group, of both worlds
  const double body = bytes_of(8 + 8 + 4 + 2, 0);  // pose, motion, mass, surface
  const double hull =
      bytes_of(4 * 3 + 4 * 2 + 4 * 2, 2 * (6 + 3 + 2));  // vertices, planes, box; corners and beginnings
  constexpr double growing = 3;  // an array that grows is held twice, the new one twice as large
  return growing * (bodies * (body + collider) + triangles * (collider + hull));
}

void require_room(const World<double>& world, double bodies, double triangles, const std::string& where) {
  const std::string what = bodies > 0 ? digits_of(bodies) + " bodies" : digits_of(triangles) + " triangles";
  if (std::max<double>(world.bodies.count, world.colliders.count) + bodies + triangles > most_bodies)
    throw InputError(where + ": " + what + ", expected at most " + digits_of(most_bodies) + " in all");
  // Bodies that are there already count again: an array that grows is copied.
  const double others = world.bodies.count, faces = world.hulls.first_face[world.hulls.count];
  require_memory(making_bytes(others + bodies, .5 * faces + triangles),
                 where + ": " + what + (others > 0 ? ", after " + digits_of(others) + " bodies," : ""));
}

void require_floats(const World<double>& world, int body, const std::string& where) {
  const auto [x, y, z, w] = world.bodies.inverse_mass[body];
  for (const double inverse : {x, y, z, w})
    if (inverse != 0 && !std::isnormal(static_cast<float>(inverse)))
      throw InputError(where + ": a mass or an inertia of " + digits_of(1 / inverse) + ", which float cannot hold");
}

}  // namespace lockstep::rigid
