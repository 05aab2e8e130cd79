#include "common/rigid/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <utility>
#include <vector>

#include "common/digits.h"
#include "common/input_error.h"
#include "common/memory.h"
#include "common/obj.h"
#include "common/rigid/generators.h"
#include "common/rigid/make.h"
#include "common/scene_reader.h"

namespace lockstep::rigid {
namespace {

using Vector = Vector3<double>;

constexpr double most_bodies = 1 << 26;  // bodies and colliders are counted in int32, and three vertices and six corners of each triangle
constexpr double shortest = 1e-4, longest = 1e5;  // m; with the masses below, all that is computed stays in the range of float
constexpr double farthest = 1e6;                  // m, m/s, rad/s

struct Defaults {
  Surface surface;
  std::string path;                 // of the scene
  std::map<std::string, int> hull;  // by name
};

// --- Values

std::optional<double> length(const toml::table& table, std::string_view key) {
  return number_between(table, key, shortest, longest, "m");
}

// m, m/s or rad/s
Vector near_vector(const toml::table& table, std::string_view key, std::string_view unit) {
  const Vector v = vector(table, key, unit).value_or(Vector{0, 0, 0});
  for (const double x : {v.x, v.y, v.z})
    if (!(std::abs(x) <= farthest)) refuse_value(*table.get(key), key, "numbers of at most 1e6, in " + std::string(unit));
  return v;
}

// Half the sides.
Vector box(const toml::table& table) { return *vector_between(table, "box", shortest, longest, "m"); }

std::optional<double> mass(const toml::table& table) { return number_between(table, "mass", 1e-6, 1e9, "kg"); }

Surface read_surface(const toml::table& table, const Surface& otherwise) {
  return {.friction = number_between(table, "friction", 0, 100, "").value_or(otherwise.friction),
          .restitution = number_between(table, "restitution", 0, 1, "").value_or(otherwise.restitution)};
}

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

Pose<double> read_pose(const toml::table& table) { return {near_vector(table, "position", "m"), read_orientation(table), 0}; }

// The turn that takes y to a normal.
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

void require_room(const World<double>& world, double bodies, double triangles, const std::string& where) {
  const std::string what = bodies > 0 ? digits_of(bodies) + " bodies" : digits_of(triangles) + " triangles";
  if (std::max<double>(world.bodies.count, world.colliders.count) + bodies + triangles > most_bodies)
    throw InputError(where + ": " + what + ", expected at most " + digits_of(most_bodies) + " in all");
  // What is there already grows with the arrays that it is in.
  const double others = world.bodies.count, faces = world.hulls.first_face[world.hulls.count];
  require_memory(making_bytes(others + bodies, .5 * faces + triangles),
                 where + ": " + what + (others > 0 ? ", after " + digits_of(others) + " bodies," : ""));
}

void require_near(const Mesh& mesh, const std::string& path) {
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    for (const double x : {mesh.points[i].x, mesh.points[i].y, mesh.points[i].z})
      if (!(std::abs(x) <= longest)) throw InputError(path + ": point " + std::to_string(i + 1) + " is not within 1e5 m of the origin");
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
      if (!x || !(std::abs(*x) <= longest)) refuse_value(element, "points", "three numbers [x, y, z] from -1e5 to 1e5, in m");
      xyz[axis] = *x;
    }
    points.push_back({xyz[0], xyz[1], xyz[2]});
  }
  return points;
}

// Where float could not tell points apart.
void require_extent(const std::vector<Vector>& points, const std::string& where) {
  double extent = 0, out = 0;
  for (const Vector& p : points) {
    for (const double x : {p.x - points[0].x, p.y - points[0].y, p.z - points[0].z}) extent = std::max(extent, std::abs(x));
    for (const double x : {p.x, p.y, p.z}) out = std::max(out, std::abs(x));
  }
  if (!(extent >= shortest)) throw InputError(where + ": expected points 1e-4 m apart, or more");
  if (!(out <= 1e3 * extent))
    throw InputError(where + ": expected points around the origin, not farther from it than 1000 times their extent");
}

void read_hull(const toml::table& table, World<double>& world, Defaults& defaults) {
  check_keys(table, {"name"}, {"points", "file"});
  const std::string name = *text(table, "name");
  if (defaults.hull.contains(name)) refuse_value(*table.get("name"), "name", "another: there is a hull \"" + name + "\" above");
  const toml::node* listed = table.get("points");
  const std::optional<std::string> file = text(table, "file");
  if (!listed && !file) refuse(table.source(), "points or file is missing");
  if (listed && file) refuse_value(*table.get("file"), "file", "either points or file");
  const std::string file_path = file ? beside(defaults.path, *file) : "";
  const std::string where = file ? file_path : position(listed->source()) + ": points";
  std::vector<Vector> points;
  if (file) {
    const Mesh mesh = read_obj(file_path);
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

void add_mesh_file(const toml::table& table, World<double>& world, const Pose<double>& local, const Defaults& defaults) {
  const std::string path = beside(defaults.path, *text(table, "mesh"));
  const Mesh mesh = read_obj(path);
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
  if (const auto radius = length(table, "sphere")) add_sphere(world, *radius, local);
  if (const toml::node* value = table.get("capsule")) {
    const toml::table* capsule = value->as_table();
    if (!capsule) refuse_value(*value, "capsule", "{ half = ..., radius = ... }, in m");
    check_keys(*capsule, {"half", "radius"}, {});
    add_capsule(world, *length(*capsule, "half"), *length(*capsule, "radius"), local);
  }
  if (table.contains("box")) add_box(world, box(table), local);
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

// Refuses any number of shapes but one.
void check_shape(const toml::table& table, bool or_parts) {
  const toml::node* found = or_parts ? table.get("part") : nullptr;
  for (const std::string_view shape : shapes) {
    const toml::node* value = table.get(shape);
    if (value && found) refuse_value(*value, shape, "one shape");
    if (value) found = value;
  }
  if (!found)
    refuse(table.source(), std::string("sphere, capsule, box, hull, plane") + (or_parts ? ", mesh or part" : " or mesh") + " is missing");
}

Heaviness read_heaviness(const toml::table& body, const std::vector<const toml::table*>& parts) {
  const std::optional<double> kilograms = mass(body);
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

// Sizes and masses that are each in range may still have an inertia that is not.
void require_floats(const World<double>& world, int body, const std::string& where) {
  const auto [x, y, z, w] = world.bodies.inverse_mass[body];
  for (const double inverse : {x, y, z, w})
    if (inverse != 0 && !std::isnormal(static_cast<float>(inverse)))
      throw InputError(where + ": a mass or an inertia of " + digits_of(1 / inverse) + ", which float cannot hold");
}

void read_body(const toml::table& table, World<double>& world, const Defaults& defaults) {
  check_keys(table, {},
             {"sphere", "capsule", "box", "hull", "plane", "mesh", "part", "position", "orientation", "velocity", "angular_velocity",
              "mass", "density", "friction", "restitution"});
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
      begin_body(world, read_pose(table), {near_vector(table, "velocity", "m/s"), near_vector(table, "angular_velocity", "rad/s"), {}},
                 read_surface(table, defaults.surface));
  for (const toml::table* part : parts) read_shape(*part, world, is_compound ? read_pose(*part) : no_offset, defaults);
  finish_body(world, heaviness);
  require_floats(world, body, position(table.source()));
}

// --- Generators

// Counts of bodies that are made one by one; more are refused in require_room.
constexpr int most_whole = 1 << 26;

int count_of(const toml::table& table, std::string_view key) { return *whole_int(table, key, 1, most_whole); }

Assortment read_assortment(const toml::table& table) {
  const std::map<std::string, Assortment> named = {
      {"boxes", Assortment::boxes}, {"rounds", Assortment::rounds}, {"hulls", Assortment::hulls}, {"mixed", Assortment::mixed}};
  const auto found = named.find(table.get("of")->value_exact<std::string>().value_or(""));
  if (found == named.end()) refuse_value(*table.get("of"), "of", "\"boxes\", \"rounds\", \"hulls\" or \"mixed\"");
  return found->second;
}

std::uint64_t read_seed(const toml::table& table) {
  return static_cast<std::uint64_t>(whole(table, "seed", 0, std::numeric_limits<std::int64_t>::max()).value_or(1));
}

void read_generators(const toml::table& scene, World<double>& world, const Defaults& defaults) {
  const auto kit_of = [&](const toml::table& table, double bodies, double triangles = 0) {
    require_room(world, bodies, triangles, position(table.source()));
    return Kit{near_vector(table, "position", "m"), mass(table).value_or(1), defaults.surface};
  };
  // Each of one key; its bodies are made by action(table).
  const auto each = [&](std::string_view key, auto action) {
    for (const toml::table* table : subtables(scene, key)) {
      const int first = world.bodies.count;
      action(*table);
      for (int body = first; body < world.bodies.count; ++body) require_floats(world, body, position(table->source()));
    }
  };
  each("pyramid", [&](const toml::table& table) {
    check_keys(table, {"layers"}, {"position", "mass"});
    const int layers = count_of(table, "layers");
    add_pyramid(world, kit_of(table, pyramid_bodies(layers)), layers);
  });
  each("stack", [&](const toml::table& table) {
    check_keys(table, {"count", "box"}, {"position", "mass"});
    const int count = count_of(table, "count");
    add_stack(world, kit_of(table, count), count, box(table));
  });
  each("wall", [&](const toml::table& table) {
    check_keys(table, {"courses", "bricks"}, {"position", "mass"});
    const int courses = count_of(table, "courses"), bricks = count_of(table, "bricks");
    add_wall(world, kit_of(table, static_cast<double>(courses) * bricks), courses, bricks);
  });
  each("castle", [&](const toml::table& table) {
    check_keys(table, {}, {"courses", "bricks", "position", "mass"});
    const int courses = whole_int(table, "courses", 1, most_whole).value_or(16);
    const int bricks = whole_int(table, "bricks", 15, most_whole).value_or(42);  // fewer leave no room for the keep
    add_castle(world, kit_of(table, castle_bodies(courses, bricks)), courses, bricks);
  });
  each("dominoes", [&](const toml::table& table) {
    check_keys(table, {"count"}, {"position", "mass"});
    const int count = count_of(table, "count");
    add_dominoes(world, kit_of(table, count), count);
  });
  each("pit", [&](const toml::table& table) {
    check_keys(table, {"of", "count"}, {"across", "from", "seed", "position", "mass"});
    const Assortment assortment = read_assortment(table);
    const int count = count_of(table, "count"), across = whole_int(table, "across", 1, 10'000).value_or(11);
    const double from = length(table, "from").value_or(1.2);
    const std::uint64_t seed = read_seed(table);
    add_pit(world, kit_of(table, count + pit_walls, assortment_triangles(assortment)), assortment, count, across, from, seed);
  });
  each("soup", [&](const toml::table& table) {
    check_keys(table, {"of", "count", "overlapping"}, {"seed", "position", "mass"});
    const Assortment assortment = read_assortment(table);
    const int count = count_of(table, "count");
    const double overlapping = *number_between(table, "overlapping", 1e-6, .999, "");
    const std::uint64_t seed = read_seed(table);
    add_soup(world, kit_of(table, count, assortment_triangles(assortment)), assortment, count, overlapping, seed);
  });
}

}  // namespace

double making_bytes(double bodies, double triangles) {
  const auto bytes_of = [&](double reals, double indices) { return reals * (sizeof(double) + sizeof(float)) + indices * sizeof(int); };
  const double collider = bytes_of(8 + 4, 2 * 3);                        // place and size; kind, body and group, of both worlds
  const double body = bytes_of(8 + 8 + 4 + 2, 0);                        // pose, motion, mass, surface
  const double hull = bytes_of(4 * 3 + 4 * 2 + 4 * 2, 2 * (6 + 3 + 2));  // vertices, planes, box; corners and beginnings
  constexpr double growing = 3;                                          // an array that grows is held twice, the new one twice as large
  return growing * (bodies * (body + collider) + triangles * (collider + hull));
}

Scene load_scene(const std::string& path) {
  const toml::table scene =
      read_scene(path, "rigid", {"kind", "frames"},
                 {"settle", "time_step", "iterations", "gravity", "friction", "restitution", "hull", "body", "pyramid",
                  "stack", "wall", "castle", "dominoes", "pit", "soup"});
  const int frames = *whole_int(scene, "frames", 1);
  const int settle = whole_int(scene, "settle", 0).value_or(0);
  const int iterations = whole_int(scene, "iterations", 1).value_or(10);
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
          .settle = settle};
}

}  // namespace lockstep::rigid
