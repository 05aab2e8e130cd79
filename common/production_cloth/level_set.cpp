#include "common/production_cloth/level_set.h"

#include <algorithm>
#include <cmath>

#include "common/input_error.h"
#include "common/levelset/mesh.h"
#include "common/memory.h"
#include "common/mesh_file.h"
#include "common/scene_reader.h"

namespace lockstep::production_cloth {
namespace {

constexpr double most_points = 1 << 28;  // with padding; they are counted in int32
// The distance in double and in float, and a byte for the inside.
constexpr double bytes_per_point = 8 + 4 + 1;

// A cube around each point of the grid; the mesh has room_of_level_set of them on each side.
levelset::Grid grid_around(const Mesh& mesh, double spacing, const std::string& where) {
  Vector3<double> low = mesh.points[0], high = low;
  for (const Vector3<double>& p : mesh.points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const auto points = [&](double extent) { return std::ceil(extent / spacing) + 2 * room_of_level_set + 1; };
  const double nx = points(high.x - low.x), ny = points(high.y - low.y), nz = points(high.z - low.z);
  const double padded = (nx + 16 + 2 * levelset::Field<float>::padding) * ny * nz;
  if (!(padded <= most_points)) throw InputError(where + ": expected a greater spacing, of at most 2^28 points");
  require_memory(bytes_per_point * padded, where);
  const Vector3<double> room = {room_of_level_set, room_of_level_set, room_of_level_set};
  return {.nx = static_cast<int>(nx),
          .ny = static_cast<int>(ny),
          .nz = static_cast<int>(nz),
          .spacing = spacing,
          .origin = low - spacing * room};
}

}  // namespace

LevelSet<double> make_level_set(const Mesh& mesh, double spacing, const std::string& where) {
  require_closed(mesh, where);
  const auto solid = std::make_shared<Solid>();
  solid->mesh = mesh, solid->grid = grid_around(mesh, spacing, where);
  const levelset::Grid& grid = solid->grid;
  const levelset::Field<double> exact = levelset::signed_distance(mesh, grid, reach_of_level_set);
  levelset::Field<float>& distance = solid->distance;
  distance = levelset::make_field<float>(grid.nx, grid.ny, grid.nz, static_cast<float>(spacing), 0);
  std::ranges::transform(exact.value, distance.value.begin(), [](double d) { return static_cast<float>(d); });
  return {.solid = solid, .origin = grid.position(0, 0, 0), .turn = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .larger_by = 0};
}

LevelSet<double> read_level_set(const toml::table& table, const std::string& scene, double thickness) {
  const double scale = number_between(table, "scale", 1e-6, 1e6, "").value_or(1);
  const Vector3<double> shift = vector_between(table, "shift", -1e6, 1e6, "m").value_or(Vector3<double>{0, 0, 0});
  const double spacing = *number_between(table, "spacing", 1e-6, 1e6, "m");
  // The room is for the thickness and the cell beside the sides.
  if (!(thickness <= .5 * room_of_level_set * spacing))
    refuse_value(*table.get("spacing"), "spacing", "at least a third of the contact's thickness");
  Mesh mesh = read_mesh(beside(scene, *text(table, "file")));
  for (Vector3<double>& p : mesh.points) p = scale * p + shift;
  return make_level_set(mesh, spacing, position(table.source()));
}

}  // namespace lockstep::production_cloth
