#include "common/levelset/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>

#include "common/digits.h"
#include "common/levelset/fit.h"
#include "common/levelset/mesh.h"
#include "common/memory.h"
#include "common/mesh_file.h"
#include "common/scene_reader.h"

namespace lockstep::levelset {
namespace {

constexpr int most = std::numeric_limits<int>::max();

// A field in float and in double, distances in both, and what fast marching keeps of a point.
constexpr double bytes_per_point = 40;

std::optional<double> positive(const toml::table& table, std::string_view key, std::string_view unit) {
  return number_between(table, key, 1e-9, 1e9, unit);
}

// --- The grid

std::array<int, 3> read_points(const toml::table& scene) {
  const toml::node& value = *scene.get("points");
  const std::string expected = "three whole numbers [x, y, z] from 2 to " + std::to_string(most);
  const toml::array* array = value.as_array();
  if (!array || array->size() != 3) refuse_value(value, "points", expected);
  const auto along = [&](int axis) {
    const std::optional<std::int64_t> n = (*array)[axis].value_exact<std::int64_t>();
    if (!n || *n < 2 || *n > most) refuse_value((*array)[axis], "points", expected);
    return static_cast<int>(*n);
  };
  return {along(0), along(1), along(2)};
}

void require_size(double nx, double ny, double nz, const toml::node& points) {
  const double padded = (std::ceil(nx / 16) * 16 + 2 * Field<float>::padding) * ny * nz;
  // Points are counted in int32.
  if (padded > most)
    refuse_value(points, "points", "at most " + digits_of(most) + " with padding, not " + digits_of(padded));
  require_memory(bytes_per_point * padded,
                 position(points.source()) + ": a grid of " + digits_of(nx * ny * nz) + " points");
}

// The grid of the scene's keys; without them, the spacing is 1 / points.x and the origin zero.
Grid read_grid(const toml::table& scene, const std::array<int, 3>& points) {
  const auto [nx, ny, nz] = points;
  const Grid grid{.nx = nx,
                  .ny = ny,
                  .nz = nz,
                  .spacing = number_between(scene, "spacing", 1e-6, 1e6, "m").value_or(1. / nx),
                  .origin = vector(scene, "origin", "m").value_or(Vector3<double>{0, 0, 0})};
  // Farther from zero, rounding would move points.
  for (const double x : {grid.origin.x, grid.origin.y, grid.origin.z})
    if (!(std::abs(x) <= 1e9 * grid.spacing))
      refuse_value(*scene.get("origin"), "origin", "numbers of at most 1e9 spacings");
  return grid;
}

// In spacings; nothing where all points are wanted.
std::optional<double> read_band(const toml::table& scene, const std::array<int, 3>& points) {
  const double diagonal = std::hypot(points[0] - 1., points[1] - 1., points[2] - 1.);
  return number(scene, "band",
                "a number from 1e-9 to " + digits_of(diagonal) + ", the diagonal of the grid, in spacings",
                [&](double x) { return x >= 1e-9 && x <= diagonal; });
}

// --- The inside

Sphere read_sphere(const toml::table& table) {
  check_keys(table, {"centre", "radius"}, {});
  return {.centre = *vector(table, "centre", "m"), .radius = *positive(table, "radius", "m")};
}

Box read_box(const toml::table& table) {
  check_keys(table, {"centre", "half"}, {});
  return {.centre = *vector(table, "centre", "m"), .half = *vector_between(table, "half", 1e-9, 1e9, "m")};
}

Torus read_torus(const toml::table& table) {
  check_keys(table, {"centre", "ring", "tube"}, {});
  const Torus torus{.centre = *vector(table, "centre", "m"),
                    .ring = *positive(table, "ring", "m"),
                    .tube = *positive(table, "tube", "m")};
  if (!(torus.tube < torus.ring)) refuse_value(*table.get("tube"), "tube", "less than the ring's radius");
  return torus;
}

std::vector<Shape> read_shapes(const toml::table& scene) {
  std::vector<Shape> shapes;
  for (const toml::table* table : subtables(scene, "sphere")) shapes.push_back(read_sphere(*table));
  for (const toml::table* table : subtables(scene, "box")) shapes.push_back(read_box(*table));
  for (const toml::table* table : subtables(scene, "torus")) shapes.push_back(read_torus(*table));
  return shapes;
}

Mesh load_mesh(const toml::table& table, const std::string& scene_path) {
  check_keys(table, {"file"}, {"scale"});
  const std::string path = beside(scene_path, *text(table, "file"));
  const double scale = positive(table, "scale", "").value_or(1);
  Mesh mesh = read_mesh(path);
  require_closed(mesh, path);
  for (Vector3<double>& p : mesh.points) p = scale * p;
  return mesh;
}

Field<double> distance_from(const std::vector<Shape>& shapes, const Grid& grid) {
  Field<double> distance = make_field<double>(grid.nx, grid.ny, grid.nz, grid.spacing, 0);
  for (int z = 0; z < grid.nz; ++z)
    for (int y = 0; y < grid.ny; ++y)
      for (int x = 0; x < grid.nx; ++x) distance(x, y, z) = signed_distance(shapes, grid.position(x, y, z));
  return distance;
}

Field<float> distorted(const Field<double>& distance, const Grid& grid, double distort) {
  Field<float> phi = make_field<float>(grid.nx, grid.ny, grid.nz, static_cast<float>(grid.spacing), 0);
  for (int k = 0; k < grid.nz; ++k)
    for (int j = 0; j < grid.ny; ++j) {
      const auto [first_x, y, z] = grid.position(0, j, k);
      const double along_line = distort * std::cos(7 * y) * std::sin(8 * z + 1);
      for (int i = 0; i < grid.nx; ++i) {
        const double factor = distort > 0 ? 1 + along_line * std::sin(9 * (first_x + i * grid.spacing)) : 1;
        phi(i, j, k) = static_cast<float>(distance(i, j, k) * factor);
      }
    }
  return phi;
}

void require_interface(const Field<float>& phi, const toml::table& scene) {
  bool any_inside = false, any_outside = false;
  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y)
      for (int x = 0; x < phi.nx; ++x) any_inside |= phi(x, y, z) <= 0, any_outside |= phi(x, y, z) >= 0;
  if (!any_inside || !any_outside)
    refuse(scene.source(), std::string("no interface: all points are ") + (any_inside ? "inside" : "outside"));
}

}  // namespace

Scene load_scene(const std::string& path) {
  const toml::table scene =
      read_scene(path, "levelset", {"kind", "points"},
                 {"spacing", "origin", "band", "rounds", "distort", "sphere", "box", "torus", "mesh"});
  const toml::node& points_value = *scene.get("points");
  const std::array<int, 3> points = read_points(scene);
  require_size(points[0], points[1], points[2], points_value);
  const std::optional<double> band = read_band(scene, points);
  const int rounds = whole_int(scene, "rounds", 1).value_or(1);
  const double distort = number_between(scene, "distort", 0, .9, "").value_or(0);
  Grid grid = read_grid(scene, points);
  std::vector<Shape> shapes = read_shapes(scene);
  const toml::table* mesh_table = subtable(scene, "mesh");
  if (shapes.empty() && !mesh_table) refuse(scene.source(), "sphere, box, torus or mesh is missing");
  if (!shapes.empty() && mesh_table) refuse_value(*mesh_table, "mesh", "either shapes or [mesh]");

  Field<double> distance;
  if (mesh_table) {
    const Mesh mesh = load_mesh(*mesh_table, path);
    // One spacing more than the band, or than exact_spacings without one, so that the grid's outermost points are
    // beyond it.
    const double room = band.value_or(exact_spacings) + 1;
    if (!scene.contains("spacing") && !scene.contains("origin"))
      grid = fit_grid(mesh, points, room, position(points_value.source()) + ": points");
    require_inside(mesh, grid, position(mesh_table->source()));
    distance = signed_distance(mesh, grid);
  } else {
    distance = distance_from(shapes, grid);
  }
  Field<float> phi = distorted(distance, grid, distort);
  require_interface(phi, scene);
  return {.name = scene_name(path),
          .path = path,
          .grid = grid,
          .phi = std::move(phi),
          .band = band ? *band * grid.spacing : std::numeric_limits<double>::infinity(),
          .rounds = rounds,
          .shapes = std::move(shapes)};
}

}  // namespace lockstep::levelset
