#include "common/production_cloth/scene.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/cloth/read_bodies.h"
#include "common/convert.h"
#include "common/input_error.h"
#include "common/memory.h"
#include "common/mesh_file.h"
#include "common/production_cloth/intersections.h"
#include "common/production_cloth/level_set.h"
#include "common/production_cloth/sheets.h"
#include "common/scene_reader.h"

namespace lockstep::production_cloth {
namespace {

// Of loading, with half a vertex and one and a half edges a triangle: three meshes of 24 bytes, sides of triangles
// (60), topology (12 + 12 + 12 + 24), codes and orders (6), positions (12); doubled, since vectors grow so. Then boxes
// (26) and positions (6) for the test for intersections.
constexpr double bytes_per_triangle = 2 * (3 * 24 + 60 + 60 + 6 + 12) + 26 + 6;
constexpr double max_triangles = 1 << 26;

constexpr double far = 1e6;  // m: no cloth reaches so far

void require_size(double triangles, const toml::table& table) {
  if (triangles > max_triangles) refuse(table.source(), "expected at most " + std::to_string(1 << 26) + " triangles");
  require_memory(bytes_per_triangle * triangles,
                 position(table.source()) + ": " + std::to_string(static_cast<long long>(triangles)) + " triangles");
}

// --- Cloths

std::array<int, 2> read_squares(const toml::table& table, int least) {
  const toml::array* list = table.get_as<toml::array>("squares");
  std::array<int, 2> squares = {};
  bool valid = list && list->size() == 2;
  for (std::size_t k = 0; valid && k < 2; ++k) {
    const std::optional<std::int64_t> n = (*list)[k].value_exact<std::int64_t>();
    valid = n && *n >= (k == 0 ? least : 1) && *n <= 10'000;
    if (valid) squares[k] = static_cast<int>(*n);
  }
  if (!valid)
    refuse_value(*table.get("squares"), "squares",
                 "two whole numbers, " + std::to_string(least) + " .. 10000 and 1 .. 10000");
  require_size(2. * squares[0] * squares[1], table);
  return squares;
}

Vector3<double> read_side(const toml::table& table, std::string_view key) {
  const Vector3<double> side = *vector_between(table, key, -far, far, "m");
  if (!(dot(side, side) >= 1e-12)) refuse_value(*table.get(key), key, "a side of at least 1e-6 m");
  return side;
}

Mesh read_sheet(const toml::table& table) {
  check_keys(table, {"origin", "across", "down", "squares"}, {});
  const SheetPlan plan = {.origin = *vector_between(table, "origin", -far, far, "m"),
                          .across = read_side(table, "across"),
                          .down = read_side(table, "down"),
                          .squares = read_squares(table, 1)};
  const Vector3<double> normal = cross(plan.across, plan.down);
  if (!(dot(normal, normal) > 1e-6 * dot(plan.across, plan.across) * dot(plan.down, plan.down)))
    refuse_value(*table.get("down"), "down", "another direction than `across`");
  return make_sheet(plan);
}

Mesh read_tube(const toml::table& table) {
  check_keys(table, {"from", "to", "radius", "squares"}, {});
  const TubePlan plan = {.from = *vector_between(table, "from", -far, far, "m"),
                         .to = *vector_between(table, "to", -far, far, "m"),
                         .radius = *number_between(table, "radius", 1e-6, far, "m"),
                         .squares = read_squares(table, 3)};
  const Vector3<double> axis = plan.to - plan.from;
  if (!(dot(axis, axis) >= 1e-12)) refuse_value(*table.get("to"), "to", "another point than `from`");
  return make_tube(plan);
}

Mesh read_file(const toml::table& table, const std::string& scene) {
  check_keys(table, {"file"}, {"scale", "shift"});
  const double scale = number_between(table, "scale", 1e-6, 1e6, "").value_or(1);
  const Vector3<double> shift = vector_between(table, "shift", -far, far, "m").value_or(Vector3<double>{0, 0, 0});
  Mesh mesh = read_mesh(beside(scene, *text(table, "file")));
  require_size(static_cast<double>(mesh.triangles.size()), table);
  for (Vector3<double>& p : mesh.points) p = scale * p + shift;
  return mesh;
}

void append(Mesh& to, const Mesh& mesh) {
  const auto first = static_cast<std::int32_t>(to.points.size());
  to.points.insert(to.points.end(), mesh.points.begin(), mesh.points.end());
  for (const Triangle& t : mesh.triangles) to.triangles.push_back({t.a + first, t.b + first, t.c + first});
}

Mesh read_cloths(const toml::table& scene, const std::string& path) {
  Mesh mesh;
  for (const toml::table* table : subtables(scene, "sheet")) append(mesh, renumbered(read_sheet(*table)));
  for (const toml::table* table : subtables(scene, "tube")) append(mesh, renumbered(read_tube(*table)));
  for (const toml::table* table : subtables(scene, "mesh")) append(mesh, renumbered(read_file(*table, path)));
  if (mesh.triangles.empty()) refuse(scene.source(), "expected at least one of sheet, tube and mesh");
  require_size(static_cast<double>(mesh.triangles.size()), scene);
  return mesh;
}

// --- What it is made of, and contact

Material read_material(const toml::table& scene) {
  Material m;
  const toml::table* const table = subtable(scene, "material");
  if (!table) return m;
  check_keys(
      *table, {},
      {"density", "stretch", "stiffness", "membrane", "poisson", "stretch_damping", "bend", "bending", "bend_damping"});
  const auto choose = [&](const char* key, auto otherwise, std::initializer_list<const char*> names) {
    const std::optional<std::string> name = text(*table, key);
    if (!name) return otherwise;
    std::string expected;
    int k = 0;
    for (const char* const known : names) {
      if (*name == known) return static_cast<decltype(otherwise)>(k);
      expected += (k++ ? ", " : "one of: ") + std::string(known);
    }
    refuse_value(*table->get(key), key, expected);
  };
  const auto value = [&](const char* key, double low, double high, const char* unit, double& of) {
    of = number_between(*table, key, low, high, unit).value_or(of);
  };
  value("density", 1e-3, 1e3, "kg/m^2", m.density);
  m.stretch = choose("stretch", m.stretch, {"springs", "stvk", "corotated"});
  value("stiffness", 0, 1e9, "N", m.stiffness);
  value("membrane", 0, 1e9, "N/m", m.membrane);
  value("poisson", -.9, .49, "", m.poisson);
  value("stretch_damping", 0, 1e3, "", m.stretch_damping);
  m.bend = choose("bend", m.bend, {"none", "hinges", "quadratic"});
  value("bending", 0, 1e6, "", m.bending);
  value("bend_damping", 0, 1e3, "", m.bend_damping);
  return m;
}

Contact read_contact(const toml::table& scene) {
  Contact c;
  const toml::table* const table = subtable(scene, "contact");
  if (!table) return c;
  check_keys(*table, {}, {"thickness", "stiffness", "friction", "zones"});
  const std::string zones = text(*table, "zones").value_or("rigid");
  if (zones != "rigid" && zones != "inelastic") refuse_value(*table->get("zones"), "zones", "one of: rigid, inelastic");
  return {.thickness = number_between(*table, "thickness", 1e-6, 1, "m").value_or(c.thickness),
          .stiffness = number_between(*table, "stiffness", 0, 1e9, "N/m").value_or(c.stiffness),
          .friction = number_between(*table, "friction", 0, 100, "").value_or(c.friction),
          .zones = zones == "rigid" ? ZoneForm::rigid : ZoneForm::inelastic};
}

// --- What moves

Path read_path(const toml::table& table) {
  Path path;
  path.pivot = vector_between(table, "pivot", -far, far, "m").value_or(path.pivot);
  for (const toml::table* key : subtables(table, "key")) {
    check_keys(*key, {"time"}, {"turn", "shift"});
    const Vector3<double> zero = {0, 0, 0};
    path.keys.push_back({.time = *number_between(*key, "time", 0, 1e6, "s"),
                         .placement = {vector_between(*key, "turn", -1e6, 1e6, "rad").value_or(zero),
                                       vector_between(*key, "shift", -far, far, "m").value_or(zero)}});
    if (path.keys.size() > 1 && !(path.keys.back().time > path.keys[path.keys.size() - 2].time))
      refuse_value(*key->get("time"), "time", "a later time than the key's before");
  }
  return path;
}

Body read_body(const toml::table& table, const Shape& shape) {
  return {
      .shape = shape, .friction = number_between(table, "friction", 0, 100, "").value_or(.3), .path = read_path(table)};
}

std::vector<Body> read_bodies(const toml::table& scene, const std::string& path, double thickness) {
  std::vector<Body> bodies;
  for (const toml::table* t : subtables(scene, "plane")) {
    check_keys(*t, {"normal", "point"}, {"friction", "pivot", "key"});
    bodies.push_back(read_body(*t, cloth::plane_of(*t)));
  }
  for (const toml::table* t : subtables(scene, "sphere")) {
    check_keys(*t, {"centre", "radius"}, {"friction", "pivot", "key"});
    bodies.push_back(read_body(*t, cloth::sphere_of(*t)));
  }
  for (const toml::table* t : subtables(scene, "capsule")) {
    check_keys(*t, {"from", "to", "radius"}, {"friction", "pivot", "key"});
    bodies.push_back(read_body(*t, cloth::capsule_of(*t)));
  }
  for (const toml::table* t : subtables(scene, "box")) {
    check_keys(*t, {"centre", "half"}, {"turn", "friction", "pivot", "key"});
    bodies.push_back(read_body(*t, cloth::box_of(*t)));
  }
  for (const toml::table* t : subtables(scene, "solid")) {
    check_keys(*t, {"file", "spacing"}, {"scale", "shift", "friction", "pivot", "key"});
    bodies.push_back(read_body(*t, read_level_set(*t, path, thickness)));
  }
  return bodies;
}

// A vertex in several boxes is the first hold's.
std::vector<Hold> read_holds(const toml::table& scene, const Mesh& mesh) {
  std::vector<Hold> holds;
  std::vector<bool> is_held(mesh.points.size());
  for (const toml::table* table : subtables(scene, "hold")) {
    check_keys(*table, {"from", "to"}, {"pivot", "key"});
    const Vector3<double> low = *vector_between(*table, "from", -far, far, "m"),
                          high = *vector_between(*table, "to", -far, far, "m");
    Hold hold = {.vertices = {}, .path = read_path(*table)};
    for (std::size_t i = 0; i < mesh.points.size(); ++i) {
      const Vector3<double>& p = mesh.points[i];
      if (is_held[i] || p.x < low.x || p.x > high.x || p.y < low.y || p.y > high.y || p.z < low.z || p.z > high.z)
        continue;
      is_held[i] = true;
      hold.vertices.push_back(static_cast<std::int32_t>(i));
    }
    if (hold.vertices.empty()) refuse(table->source(), "no vertex is in the box of the hold");
    holds.push_back(std::move(hold));
  }
  return holds;
}

// --- What is refused

std::string name_of(const Topology& topology, std::size_t triangle) {
  const auto [a, b, c] = topology.corners(triangle);
  return std::to_string(triangle + 1) + " of vertices " + std::to_string(a + 1) + ", " + std::to_string(b + 1) + ", " +
         std::to_string(c + 1);
}

// Triangles have an area, and edges are longer than the cloth is thick: else neighbours would repel each other at rest.
void require_shape(const Topology& topology, const Vectors<double>& rest, const Contact& contact,
                   const std::string& where) {
  for (std::size_t t = 0; t < topology.triangles.size(); ++t) {
    const auto [a, b, c] = topology.corners(t);
    const Vector3<double> u = load(rest, b) - load(rest, a), v = load(rest, c) - load(rest, a), w = v - u;
    const Vector3<double> normal = cross(u, v);
    const double longest = std::max({dot(u, u), dot(v, v), dot(w, w)}),
                 shortest = std::min({dot(u, u), dot(v, v), dot(w, w)});
    const std::string triangle = where + ": triangle " + name_of(topology, t);
    if (!(dot(normal, normal) > 1e-8 * longest * longest))
      throw InputError(triangle + " is degenerate: its height is below 1e-4 of its longest edge");
    if (!(std::sqrt(shortest) > contact.thickness))
      throw InputError(triangle + " has an edge of " + std::to_string(std::sqrt(shortest)) +
                       " m, expected longer than the thickness of " + std::to_string(contact.thickness) + " m");
  }
}

// Where a cloth intersects itself at the start, nothing tells on which side of itself it belongs.
void require_no_intersection(const Topology& topology, const Vectors<double>& rest, const std::string& where) {
  const auto found = first_intersection(topology, convert<float>(rest));
  if (!found) return;
  const Vector3<double> at = load(rest, topology.corners((*found)[0])[0]);
  char place[80];
  std::snprintf(place, sizeof place, ", near (%.6g, %.6g, %.6g) m", at.x, at.y, at.z);
  throw InputError(where + ": triangle " + name_of(topology, (*found)[0]) + " and triangle " +
                   name_of(topology, (*found)[1]) + " intersect or touch" + place);
}

}  // namespace

Scene load_scene(const std::string& path) {
  const toml::table scene =
      read_scene(path, "production_cloth", {"kind"},
                 {"frames", "frame_time", "substeps", "gravity", "tolerance", "iterations", "sheet", "tube", "mesh",
                  "material", "contact", "hold", "plane", "sphere", "capsule", "box", "solid"});
  const Mesh mesh = read_cloths(scene, path);
  Scene made{.name = scene_name(path),
             .path = path,
             .topology = make_topology(static_cast<int>(mesh.points.size()), mesh.triangles, path),
             .rest = {},
             .material = read_material(scene),
             .contact = read_contact(scene),
             .holds = read_holds(scene, mesh),
             .bodies = {},
             .gravity = vector_between(scene, "gravity", -1e6, 1e6, "m/s^2").value_or(Vector3<double>{0, -9.81, 0}),
             .frame_time = number_between(scene, "frame_time", 1e-6, 1, "s").value_or(1. / 60),
             .substeps = whole_int(scene, "substeps", 1, 1'000'000).value_or(20),
             .tolerance = number_between(scene, "tolerance", 1e-6, 1, "").value_or(1e-2),
             .iterations = whole_int(scene, "iterations", 1, 1'000'000).value_or(200),
             .frames = whole_int(scene, "frames", 1).value_or(120)};
  made.bodies = read_bodies(scene, path, made.contact.thickness);
  made.rest.resize(mesh.points.size());
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    store(made.rest, i, convert<double>(convert<float>(mesh.points[i])));
  require_shape(made.topology, made.rest, made.contact, path);
  require_no_intersection(made.topology, made.rest, path);
  return made;
}

}  // namespace lockstep::production_cloth
