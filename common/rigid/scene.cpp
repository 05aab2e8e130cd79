#include "common/rigid/scene.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "common/input_error.h"
#include "common/mesh_file.h"
#include "common/rigid/contact_solver.h"
#include "common/rigid/make.h"
#include "common/rigid/scene_values.h"
#include "common/scene_reader.h"

namespace lockstep::rigid {
namespace {

using Vector = Vector3<double>;

// The rotation that takes y to a normal.
Quaternion<double> turn_to(const Vector& normal) {
  const double length = std::sqrt(dot(normal, normal));
  const Vector n = 1 / length * normal;
  const double off = n.x * n.x + n.z * n.z;
  if (n.y < 0 && off == 0) return {1, 0, 0, 0};
  const double w = n.y < 0 ? off / (1 - n.y) : 1 + n.y;  // 1 + n.y either way, and no digits lost
  const double scale = 1 / std::sqrt(2 * w);
  return {scale * n.z, 0, -scale * n.x, scale * w};
}

// --- Files

void require_near(const Mesh& mesh, const std::string& path) {
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    for (const double x : {mesh.points[i].x, mesh.points[i].y, mesh.points[i].z})
      if (!(std::abs(x) <= longest))
        throw InputError(path + ": point " + std::to_string(i + 1) + " is not within 1e5 m of the origin");
}

// --- Hulls

std::vector<Vector> read_points(const toml::table& table) {
  const toml::node& value = *table.get("points");
  const toml::array* array = value.as_array();
  if (!array) refuse_value(value, "points", "an array of points [x, y, z], in m");
  std::vector<Vector> points;
  for (const toml::node& element : *array) {
    const toml::array* point = element.as_array();
    double xyz[3];
    for (int axis = 0; axis < 3; ++axis) {
      const std::optional<double> x = point && point->size() == 3 ? as_number((*point)[axis]) : std::nullopt;
      if (!x || !(std::abs(*x) <= longest))
        refuse_value(element, "points", "three numbers [x, y, z] from -1e5 to 1e5, in m");
      xyz[axis] = *x;
    }
    points.push_back({xyz[0], xyz[1], xyz[2]});
  }
  return points;
}

// Refuses points that float could not tell apart.
void require_extent(const std::vector<Vector>& points, const std::string& where) {
  double extent = 0, out = 0;
  for (const Vector& p : points) {
    for (const double x : {p.x - points[0].x, p.y - points[0].y, p.z - points[0].z})
      extent = std::max(extent, std::abs(x));
    for (const double x : {p.x, p.y, p.z}) out = std::max(out, std::abs(x));
  }
  if (!(extent >= shortest)) throw InputError(where + ": expected points 1e-4 m apart, or more");
  if (!(out <= 1e3 * extent))
    throw InputError(where + ": expected points around the origin, not farther from it than 1000 times their extent");
}

void read_hull(const toml::table& table, World<double>& world, Defaults& defaults) {
  check_keys(table, {"name"}, {"points", "file"});
  const std::string name = *text(table, "name");
  if (defaults.hull.contains(name))
    refuse_value(*table.get("name"), "name", "another: there is a hull \"" + name + "\" above");
  const toml::node* listed = table.get("points");
  const std::optional<std::string> file = text(table, "file");
  if (!listed && !file) refuse(table.source(), "points or file is missing");
  if (listed && file) refuse_value(*table.get("file"), "file", "either points or file");
  const std::string file_path = file ? beside(defaults.path, *file) : "";
  const std::string where = file ? file_path : position(listed->source()) + ": points";
  std::vector<Vector> points;
  if (file) {
    const Mesh mesh = read_mesh(file_path);
    require_near(mesh, file_path);
    points = mesh.points;
  } else {
    points = read_points(table);
  }
  if (!points.empty()) require_extent(points, where);
  require_room(world, 0, most_hull_vertices, where);
  try {
    defaults.hull[name] = make_hull(world.hulls, points);
  } catch (const std::invalid_argument& error) {
    throw InputError(where + ": " + error.what());
  }
}

// --- Bodies

constexpr std::string_view shapes[] = {"sphere", "capsule", "box", "hull", "plane", "mesh"};

void add_mesh_file(const toml::table& table, World<double>& world, const Pose<double>& local,
                   const Defaults& defaults) {
  const std::string path = beside(defaults.path, *text(table, "mesh"));
  const Mesh mesh = read_mesh(path);
  require_closed(mesh, path);
  require_near(mesh, path);
  require_room(world, 0, static_cast<double>(mesh.triangles.size()), path);
  try {
    add_mesh(world, mesh, local);
  } catch (const std::invalid_argument& error) {
    throw InputError(path + ": " + error.what());
  }
}

// The shape of a body, or of a part of one; keys are checked.
void read_shape(const toml::table& table, World<double>& world, const Pose<double>& local, const Defaults& defaults) {
  if (const auto radius = read_length(table, "sphere")) add_sphere(world, *radius, local);
  if (const toml::node* value = table.get("capsule")) {
    const toml::table* capsule = value->as_table();
    if (!capsule) refuse_value(*value, "capsule", "{ half = ..., radius = ... }, in m");
    check_keys(*capsule, {"half", "radius"}, {});
    add_capsule(world, *read_length(*capsule, "half"), *read_length(*capsule, "radius"), local);
  }
  if (table.contains("box")) add_box(world, read_box(table), local);
  if (const auto name = text(table, "hull")) {
    const auto hull = defaults.hull.find(*name);
    if (hull == defaults.hull.end()) refuse_value(*table.get("hull"), "hull", "the name of a [[hull]]");
    add_hull(world, hull->second, local);
  }
  if (const auto normal = vector(table, "plane", "any unit")) {
    if (!(dot(*normal, *normal) > 0)) refuse_value(*table.get("plane"), "plane", "a normal that is not zero");
    add_plane(world, {local.position, local.orientation * turn_to(*normal), 0});
  }
  if (table.contains("mesh")) add_mesh_file(table, world, local, defaults);
}

// Refuses a table without a shape, and one with several.
void check_shape(const toml::table& table, bool or_parts) {
  const toml::node* found = or_parts ? table.get("part") : nullptr;
  for (const std::string_view shape : shapes) {
    const toml::node* value = table.get(shape);
    if (value && found) refuse_value(*value, shape, "one shape");
    if (value) found = value;
  }
  if (!found)
    refuse(table.source(), std::string("sphere, capsule, box, hull, plane") +
                               (or_parts ? ", mesh or part" : " or mesh") + " is missing");
}

Heaviness read_heaviness(const toml::table& body, const std::vector<const toml::table*>& parts) {
  const std::optional<double> kilograms = read_mass(body);
  const std::optional<double> density = number_between(body, "density", 1e-3, 1e6, "kg/m^3");
  if (kilograms && density) refuse_value(*body.get("density"), "density", "either mass or density");
  const std::string_view key = kilograms ? "mass" : "density";
  if (kilograms || density)
    for (const toml::table* part : parts)
      if (part->contains("plane") || part->contains("mesh"))
        refuse_value(*body.get(key), key, "none of a body with a plane or a mesh, which never moves");
  if (!kilograms && !density)
    for (const std::string_view velocity : {"velocity", "angular_velocity"})
      if (const toml::node* value = body.get(velocity))
        refuse_value(*value, velocity, "none of a body without mass or density, which never moves");
  return kilograms ? of_mass(*kilograms) : density ? of_density(*density) : immovable;
}

void read_body(const toml::table& table, World<double>& world, const Defaults& defaults) {
  check_keys(table, {},
             {"sphere", "capsule", "box", "hull", "plane", "mesh", "part", "position", "orientation", "velocity",
              "angular_velocity", "mass", "density", "friction", "restitution"});
  check_shape(table, true);
  std::vector<const toml::table*> parts = subtables(table, "part");
  for (const toml::table* part : parts) {
    check_keys(*part, {}, {"sphere", "capsule", "box", "hull", "plane", "mesh", "position", "orientation"});
    check_shape(*part, false);
  }
  const bool is_compound = !parts.empty();
  if (!is_compound) parts = {&table};
  const Heaviness heaviness = read_heaviness(table, parts);
  const int body =
      begin_body(world, read_pose(table),
                 {near_vector(table, "velocity", "m/s"), near_vector(table, "angular_velocity", "rad/s"), {}},
                 read_surface(table, defaults.surface));
  for (const toml::table* part : parts) read_shape(*part, world, is_compound ? read_pose(*part) : no_offset, defaults);
  finish_body(world, heaviness);
  require_floats(world, body, position(table.source()));
}

}  // namespace

Scene load_scene(const std::string& path) {
  const toml::table scene =
      read_scene(path, "rigid", {"kind", "frames"},
                 {"rest", "settle", "time_step", "iterations", "gravity", "friction", "restitution", "hull", "body",
                  "pyramid", "stack", "wall", "castle", "dominoes", "pit", "soup"});
  const int frames = *whole_int(scene, "frames", 1);
  const int rest = whole_int(scene, "rest", 0).value_or(0), settle = whole_int(scene, "settle", 0).value_or(0);
  const int iterations = whole_int(scene, "iterations", 1).value_or(SolverSettings{}.substeps);
  const double time_step = number_between(scene, "time_step", 1e-6, 1, "s").value_or(1. / 60);
  const Vector gravity = scene.contains("gravity") ? near_vector(scene, "gravity", "m/s^2") : Vector{0, -9.81, 0};

  Defaults defaults{.surface = read_surface(scene, {}), .path = path, .hull = {}};
  World<double> world = make_world();
  for (const toml::table* table : subtables(scene, "hull")) read_hull(*table, world, defaults);
  const std::vector<const toml::table*> bodies = subtables(scene, "body");
  if (!bodies.empty()) require_room(world, static_cast<double>(bodies.size()), 0, position(bodies[0]->source()));
  for (const toml::table* table : bodies) read_body(*table, world, defaults);
  read_generators(scene, world, defaults);
  if (world.bodies.count == 0) refuse(scene.source(), "no body in it");
  return {.name = scene_name(path),
          .path = path,
          .world = convert<float>(world),
          .time_step = time_step,
          .gravity = gravity,
          .iterations = iterations,
          .frames = frames,
          .rest = rest,
          .settle = settle};
}

}  // namespace lockstep::rigid
