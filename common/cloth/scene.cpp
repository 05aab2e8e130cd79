#include "common/cloth/scene.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

#include "common/cloth/limits.h"
#include "common/cloth/make.h"
#include "common/cloth/read_bodies.h"
#include "common/mesh_file.h"
#include "common/scene_reader.h"

namespace lockstep::cloth {
namespace {

std::optional<double> positive(const toml::table& table, std::string_view key, std::string_view unit) {
  return number_between(table, key, smallest, largest, unit);
}

double not_negative(const toml::table& table, std::string_view key, std::string_view unit) {
  return number_between(table, key, 0, largest, unit).value_or(0);
}

Model<double> read_model(const toml::table& scene) {
  const int substeps = whole_int(scene, "substeps", 1, 1'000'000).value_or(1);
  const double time_step = number_between(scene, "time_step", 1e-6, 1, "s").value_or(1. / 60) / substeps;
  return {.time_step = time_step,
          .substeps = substeps,
          .iterations = whole_int(scene, "iterations", 0).value_or(20),
          .gravity = vector(scene, "gravity", "m/s^2").value_or(Vector3<double>{0, -9.81, 0}),
          .wind = vector(scene, "wind", "m/s").value_or(Vector3<double>{0, 0, 0}),
          .drag = not_negative(scene, "drag", "kg/m^3"),
          .velocity_factor = std::exp(-not_negative(scene, "damping", "1/s") * time_step)};
}

// --- Bodies

Plane<double> read_plane(const toml::table& table) {
  check_keys(table, {"normal", "point"}, {});
  return plane_of(table);
}

Capsule<double> read_sphere(const toml::table& table) {
  check_keys(table, {"centre", "radius"}, {});
  return sphere_of(table);
}

Capsule<double> read_capsule(const toml::table& table) {
  check_keys(table, {"from", "to", "radius"}, {});
  return capsule_of(table);
}

Box<double> read_box(const toml::table& table) {
  check_keys(table, {"centre", "half"}, {"turn"});
  return box_of(table);
}

Bodies<double> read_bodies(const toml::table& scene) {
  Bodies<double> bodies;
  for (const toml::table* table : subtables(scene, "plane")) bodies.planes.push_back(read_plane(*table));
  for (const toml::table* table : subtables(scene, "sphere")) bodies.capsules.push_back(read_sphere(*table));
  for (const toml::table* table : subtables(scene, "capsule")) bodies.capsules.push_back(read_capsule(*table));
  for (const toml::table* table : subtables(scene, "box")) bodies.boxes.push_back(read_box(*table));
  bodies.friction = not_negative(scene, "friction", "");
  return bodies;
}

// Bodies that keep a cloth of this thickness off their surfaces.
Bodies<double> thickened(Bodies<double> bodies, double thickness) {
  for (Plane<double>& plane : bodies.planes) plane.offset += thickness;
  for (Capsule<double>& capsule : bodies.capsules) capsule.radius += thickness;
  for (Box<double>& box : bodies.boxes)
    box.half = {box.half.x + thickness, box.half.y + thickness, box.half.z + thickness};
  return bodies;
}

// --- Cloths

int copies_of(const toml::table& table) { return whole_int(table, "copies", 1).value_or(1); }

void move(Cloth<double>& cloth, int i, const Vector3<double>& by) {
  for (Vectors<double>* points : {&cloth.position, &cloth.previous})
    points->x[i] += by.x, points->y[i] += by.y, points->z[i] += by.z;
}

// A cloth and its copies, each `shift` away from the one before.
void add_copies(const toml::table& table, Cloth<double> cloth, std::vector<Cloth<double>>& cloths) {
  const Vector3<double> shift = vector(table, "shift", "m").value_or(Vector3<double>{0, 0, 0});
  for (int copy = 0; copy < copies_of(table); ++copy) {
    cloths.push_back(cloth);
    for (int i = 0; i < cloth.count; ++i)
      if (cloth.sheet.rows == 0 || i % cloth.sheet.pitch < cloth.sheet.columns) move(cloth, i, shift);
  }
}

// --- Sheets

// The particles of an edge or a corner, numbered row * columns + column, by its name; none by another name.
std::vector<int> named_particles(std::string_view name, int rows, int columns) {
  struct Part {
    std::string_view name;
    int first_row, last_row, first_column, last_column;
  };
  const int r = rows - 1, c = columns - 1;
  const Part parts[] = {
      {"top", 0, 0, 0, c},      {"bottom", r, r, 0, c},    {"left", 0, r, 0, 0},        {"right", 0, r, c, c},
      {"top_left", 0, 0, 0, 0}, {"top_right", 0, 0, c, c}, {"bottom_left", r, r, 0, 0}, {"bottom_right", r, r, c, c},
  };
  std::vector<int> particles;
  for (const Part& part : parts)
    if (part.name == name)
      for (int row = part.first_row; row <= part.last_row; ++row)
        for (int column = part.first_column; column <= part.last_column; ++column)
          particles.push_back(row * columns + column);
  return particles;
}

std::vector<int> read_pin(const toml::node& pin, int rows, int columns) {
  const toml::array* pair = pin.as_array();
  if (pair && pair->size() == 2) {
    const auto row = (*pair)[0].value_exact<std::int64_t>(), column = (*pair)[1].value_exact<std::int64_t>();
    if (row && *row >= 0 && *row < rows && column && *column >= 0 && *column < columns)
      return {static_cast<int>(*row * columns + *column)};
  }
  const std::vector<int> particles = named_particles(pin.value_exact<std::string>().value_or(""), rows, columns);
  if (particles.empty())
    refuse_value(pin, "pins",
                 "an edge (\"top\", \"bottom\", \"left\", \"right\"), a corner (\"top_left\", ...) or [row, column] of "
                 "a particle, [0, 0] to [" +
                     std::to_string(rows - 1) + ", " + std::to_string(columns - 1) + ']');
  return particles;
}

std::vector<int> read_pins(const toml::table& table, int rows, int columns) {
  const toml::node* value = table.get("pins");
  if (!value) return {};
  if (!value->is_array()) refuse_value(*value, "pins", "a list of edges, corners and particles [row, column]");
  std::vector<int> pinned;
  std::set<std::string> named;
  for (const toml::node& pin : *value->as_array()) {
    const std::vector<int> particles = read_pin(pin, rows, columns);
    if (const auto name = pin.value<std::string>(); name && !named.insert(*name).second)
      refuse_value(pin, "pins", "\"" + *name + "\" once");
    pinned.insert(pinned.end(), particles.begin(), particles.end());
  }
  return pinned;
}

// An edge that is moved away at the start.
struct Pull {
  std::vector<int> particles;  // row * columns + column
  Vector3<double> by;          // m
};

Pull read_pull(const toml::table& table, int rows, int columns) {
  const toml::node* value = table.get("pull");
  if (!value) return {};
  const toml::table* pull = value->as_table();
  if (!pull) refuse_value(*value, "pull", "{ edge = ..., by = [x, y, z] }");
  check_keys(*pull, {"edge", "by"}, {});
  const std::string edge = text(*pull, "edge").value_or("");
  if (edge != "top" && edge != "bottom" && edge != "left" && edge != "right")
    refuse_value(*pull->get("edge"), "edge", "\"top\", \"bottom\", \"left\" or \"right\"");
  return {.particles = named_particles(edge, rows, columns), .by = *vector(*pull, "by", "m")};
}

Cloth<double> load_sheet(const toml::table& table, const Model<double>& model, const Bodies<double>& bodies) {
  check_keys(table, {"rows", "columns", "origin", "width", "height", "mass"},
             {"bending", "pins", "pull", "copies", "shift"});
  const std::string where = position(table.source());
  const int rows = *whole_int(table, "rows", 1), columns = *whole_int(table, "columns", 1);
  require_sheet_size(rows, columns, copies_of(table), where);

  // From one particle to the next along a side of the sheet.
  const auto spacing = [&](std::string_view side, int particles) -> Vector3<double> {
    const Vector3<double> v = *vector(table, side, "m");
    const int spacings = std::max(1, particles - 1);
    return {v.x / spacings, v.y / spacings, v.z / spacings};
  };
  SheetPlan plan{.rows = rows,
                 .columns = columns,
                 .origin = *vector(table, "origin", "m"),
                 .across = spacing("width", columns),
                 .down = spacing("height", rows),
                 .mass = *positive(table, "mass", "kg"),
                 .bending = truth(table, "bending").value_or(false),
                 .pinned = read_pins(table, rows, columns)};
  const Pull pull = read_pull(table, rows, columns);
  plan.pinned.insert(plan.pinned.end(), pull.particles.begin(), pull.particles.end());

  Cloth<double> cloth = make_sheet(model, bodies, plan);
  require_lengths(cloth, where);
  for (const int particle : pull.particles)
    move(cloth, cloth.sheet.index(particle / columns, particle % columns), pull.by);
  return cloth;
}

// --- Meshes

Cloth<double> load_mesh(const toml::table& table, const std::string& scene_path, const Model<double>& model,
                        const Bodies<double>& bodies) {
  check_keys(table, {"file", "mass"}, {"scale", "bending", "pins_above", "copies", "shift"});
  const std::string path = beside(scene_path, *text(table, "file"));
  const double scale = positive(table, "scale", "").value_or(1);
  const double mass = *positive(table, "mass", "kg");
  const bool bending = truth(table, "bending").value_or(false);
  const std::optional<double> pins_above =
      number(table, "pins_above", "a finite number, in m", [](double) { return true; });

  Mesh mesh = read_mesh(path);
  std::vector<int> triangles_around(mesh.points.size()), pinned;
  for (const Triangle& t : mesh.triangles)
    for (const int i : {t.a, t.b, t.c}) ++triangles_around[i];
  require_mesh_size(mesh.points.size(), mesh.triangles.size(), *std::ranges::max_element(triangles_around),
                    copies_of(table), path);
  for (Vector3<double>& p : mesh.points) {
    p = {scale * p.x, scale * p.y, scale * p.z};
    if (pins_above && p.y > *pins_above) pinned.push_back(static_cast<int>(&p - mesh.points.data()));
  }
  Cloth<double> cloth = make_mesh(model, bodies,
                                  {.points = std::move(mesh.points),
                                   .triangles = std::move(mesh.triangles),
                                   .mass = mass,
                                   .bending = bending,
                                   .pinned = std::move(pinned)});
  require_lengths(cloth, path);
  return cloth;
}

// [key] or [[key]]; none if it is absent.
std::vector<const toml::table*> one_or_more(const toml::table& scene, std::string_view key) {
  const toml::node* node = scene.get(key);
  if (node && node->is_table()) return {node->as_table()};
  return subtables(scene, key);
}

}  // namespace

Scene load_scene(const std::string& path) {
  const toml::table scene =
      read_scene(path, "cloth", {"kind"},
                 {"frames", "time_step", "substeps", "iterations", "gravity", "wind", "drag", "damping", "friction",
                  "thickness", "sheet", "mesh", "plane", "sphere", "capsule", "box"});
  const int frames = whole_int(scene, "frames", 1).value_or(300);
  const Model<double> model = read_model(scene);
  const Bodies<double> bodies = read_bodies(scene);
  const Bodies<double> kept_off = thickened(bodies, not_negative(scene, "thickness", "m"));
  std::vector<Cloth<double>> cloths;
  for (const toml::table* table : one_or_more(scene, "sheet"))
    add_copies(*table, load_sheet(*table, model, kept_off), cloths);
  for (const toml::table* table : one_or_more(scene, "mesh"))
    add_copies(*table, load_mesh(*table, path, model, kept_off), cloths);
  if (cloths.empty()) refuse(scene.source(), "sheet or mesh is missing");
  return {.name = scene_name(path),
          .path = path,
          .cloth = std::move(cloths.front()),
          .others = {std::move_iterator(cloths.begin() + 1), std::move_iterator(cloths.end())},
          .bodies = bodies,
          .frames = frames};
}

}  // namespace lockstep::cloth
