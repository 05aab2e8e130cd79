#include "common/production_fluid/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string_view>
#include <utility>
#include <vector>

#include "common/digits.h"
#include "common/levelset/grid.h"
#include "common/levelset/mesh.h"
#include "common/levelset/shapes.h"
#include "common/memory.h"
#include "common/mesh_file.h"
#include "common/scene_reader.h"

namespace lockstep::production_fluid {
namespace {

using levelset::Grid;
constexpr double pi = 3.14159265358979323846;
constexpr int most = std::numeric_limits<int>::max();

// Fields of phi, solid, velocities, of the system and of a solve, in float and in double; twice what a step changes.
constexpr double bytes_per_cell = 200;

// --- The grid

Grid read_grid(const toml::table& scene) {
  const toml::node& value = *scene.get("cells");
  const std::string expected = "three whole numbers [x, y, z] from 1 to " + std::to_string(most);
  const toml::array* array = value.as_array();
  if (!array || array->size() != 3) refuse_value(value, "cells", expected);
  const auto along = [&](int axis) {
    const std::optional<std::int64_t> n = (*array)[axis].value_exact<std::int64_t>();
    if (!n || *n < 1 || *n > most) refuse_value((*array)[axis], "cells", expected);
    return static_cast<int>(*n);
  };
  const int nx = along(0), ny = along(1), nz = along(2);
  // With one face more along each axis.
  const double padded = (std::ceil((nx + 1.) / 16) * 16 + 2 * Field<float>::padding) * (ny + 1.) * (nz + 1.);
  if (padded > most)
    refuse_value(value, "cells", "at most " + digits_of(most) + " with padding, not " + digits_of(padded));
  require_memory(bytes_per_cell * padded,
                 position(value.source()) + ": a grid of " + digits_of(1. * nx * ny * nz) + " cells");
  const double spacing = number_between(scene, "spacing", 1e-6, 1e6, "m").value_or(1. / nx);
  return {.nx = nx, .ny = ny, .nz = nz, .spacing = spacing, .origin = {0, 0, 0}};
}

// --- Liquid and obstacles

// Liquid up to a height that may be waved.
struct Pool {
  double height = -1e9, amplitude = 0;  // m
  double half_waves_x = 1, half_waves_z = 0;
  double shift = 0;                   // rad, along x
  double length_x = 1, length_z = 1;  // m, of the box

  double signed_distance(const Vector3<double>& p) const {
    const double wave =
        std::cos(half_waves_x * pi * p.x / length_x - shift) * std::cos(half_waves_z * pi * p.z / length_z);
    return p.y - height - amplitude * wave;
  }
};

Pool read_pool(const toml::table& table, const Grid& grid) {
  check_keys(table, {"height"}, {"amplitude", "half_waves", "shift"});
  Pool pool{.height = *number_between(table, "height", 0, 1e6, "m"),
            .amplitude = number_between(table, "amplitude", 0, 1e6, "m").value_or(0),
            .half_waves_x = 1,
            .half_waves_z = 0,
            .shift = number_between(table, "shift", -7, 7, "rad").value_or(0),
            .length_x = grid.nx * grid.spacing,
            .length_z = grid.nz * grid.spacing};
  if (const toml::node* value = table.get("half_waves")) {
    const std::string expected = "two numbers [x, z] from 0 to 1000";
    const toml::array* array = value->as_array();
    if (!array || array->size() != 2) refuse_value(*value, "half_waves", expected);
    for (double* of : {&pool.half_waves_x, &pool.half_waves_z}) {
      const std::optional<double> n = as_number((*array)[of == &pool.half_waves_z]);
      if (!n || !(*n >= 0 && *n <= 1000)) refuse_value(*value, "half_waves", expected);
      *of = *n;
    }
  }
  return pool;
}

double length(const toml::table& table, std::string_view key) { return *number_between(table, key, 1e-9, 1e9, "m"); }

// A sphere or a box, by the key that is there.
levelset::Shape read_shape(const toml::table& table) {
  check_keys(table, {"centre"}, {"radius", "half"});
  const Vector3<double> centre = *vector(table, "centre", "m");
  if (table.contains("radius") == table.contains("half")) refuse(table.source(), "expected one of radius and half");
  if (table.contains("radius")) return levelset::Sphere{.centre = centre, .radius = length(table, "radius")};
  return levelset::Box{.centre = centre, .half = *vector_between(table, "half", 1e-9, 1e9, "m")};
}

std::vector<levelset::Shape> read_shapes(const toml::table& scene, std::string_view key) {
  std::vector<levelset::Shape> shapes;
  for (const toml::table* table : subtables(scene, key)) shapes.push_back(read_shape(*table));
  return shapes;
}

// The field of a distance at the centres of cells, and another value in the padding.
template <class Distance>
Field<float> field_of(const Grid& grid, float padding, const Distance& distance) {
  Field<float> field =
      levelset::make_field<float>(grid.nx, grid.ny, grid.nz, static_cast<float>(grid.spacing), padding);
  for (int z = 0; z < grid.nz; ++z)
    for (int y = 0; y < grid.ny; ++y)
      for (int x = 0; x < grid.nx; ++x) field(x, y, z) = static_cast<float>(distance(x, y, z));
  return field;
}

Field<float> read_liquid(const toml::table& scene, const Grid& grid) {
  const std::vector<levelset::Shape> shapes = read_shapes(scene, "liquid");
  const toml::table* pool_table = subtable(scene, "pool");
  if (shapes.empty() && !pool_table && !scene.contains("source"))
    refuse(scene.source(), "liquid, pool or source is missing");
  const Pool pool = pool_table ? read_pool(*pool_table, grid) : Pool{};
  const std::vector<levelset::Shape> air = read_shapes(scene, "air");
  return field_of(grid, 0, [&](int x, int y, int z) {
    const Vector3<double> p = grid.position(x, y, z);
    const double of_shapes = shapes.empty() ? 1e9 : levelset::signed_distance(shapes, p);
    const double of_air = air.empty() ? 1e9 : levelset::signed_distance(air, p);
    return std::max(std::min(of_shapes, pool.signed_distance(p)), -of_air);
  });
}

// Distances from obstacles; 1e9 m where there are none.
Field<float> read_obstacles(const toml::table& scene, const Grid& grid, const std::string& path) {
  const std::vector<levelset::Shape> shapes = read_shapes(scene, "obstacle");
  Field<double> of_mesh;
  if (const toml::table* table = subtable(scene, "mesh")) {
    check_keys(*table, {"file"}, {"scale"});
    const std::string file = beside(path, *text(*table, "file"));
    const double scale = table->contains("scale") ? length(*table, "scale") : 1;
    Mesh mesh = read_mesh(file);
    require_closed(mesh, file);
    for (Vector3<double>& p : mesh.points) p = scale * p;
    of_mesh = levelset::signed_distance(mesh, grid);
  }
  return field_of(grid, -1, [&](int x, int y, int z) {
    const double of_shapes = shapes.empty() ? 1e9 : levelset::signed_distance(shapes, grid.position(x, y, z));
    return of_mesh.nx > 0 ? std::min(of_shapes, of_mesh(x, y, z)) : of_shapes;
  });
}

// --- Velocities

// Velocities, m/s, at positions in units of the box: x / (length of the box along x) and so on.
Vector3<double> rest(const Vector3<double>&) { return {0, 0, 0}; }

// Cells of flow that have divergence everywhere, so that pressure has work to do.
Vector3<double> swirl(const Vector3<double>& p) {
  return {std::sin(pi * p.x) * std::cos(3 * pi * p.y) * std::cos(pi * p.z),
          std::sin(pi * p.y) * (std::cos(2 * pi * p.x) - .3),
          std::sin(pi * p.z) * std::cos(5 * pi * p.x) * std::cos(2 * pi * p.y)};
}

// A turn about the middle of the box, along z, once in 2 pi s.
Vector3<double> turn(const Vector3<double>& p) { return {.5 - p.y, p.x - .5, 0}; }

// LeVeque, High-resolution conservative algorithms for advection in incompressible flow, SIAM J. Numer. Anal. 33
// (1996), 9.5.
Vector3<double> enright(const Vector3<double>& p) {
  const auto square = [](double x) { return std::sin(pi * x) * std::sin(pi * x); };
  const auto twice = [](double x) { return std::sin(2 * pi * x); };
  return {2 * square(p.x) * twice(p.y) * twice(p.z), -twice(p.x) * square(p.y) * twice(p.z),
          -twice(p.x) * twice(p.y) * square(p.z)};
}

// Liquid drawn out along y from the middle of the box, in a plane.
Vector3<double> strain(const Vector3<double>& p) { return {-(p.x - .5), p.y - .5, 0}; }

using Flow = Vector3<double>(const Vector3<double>&);

Flow* read_flow(const toml::table& scene) {
  constexpr std::pair<std::string_view, Flow*> flows[] = {
      {"rest", rest}, {"swirl", swirl}, {"turn", turn}, {"enright", enright}, {"strain", strain}};
  const std::string name = text(scene, "flow").value_or("rest");
  const auto found = std::ranges::find(flows, name, &std::pair<std::string_view, Flow*>::first);
  if (found == std::end(flows))
    refuse_value(*scene.get("flow"), "flow", R"("rest", "swirl", "turn", "enright" or "strain")");
  return found->second;
}

Faces<float> faces_of(const Grid& grid, Flow* flow) {
  Faces<float> faces = make_faces<float>(grid.nx, grid.ny, grid.nz, static_cast<float>(grid.spacing));
  const auto fill = [&](Field<float>& field, double dx, double dy, double dz, auto component) {
    for (int z = 0; z < field.nz; ++z)
      for (int y = 0; y < field.ny; ++y)
        for (int x = 0; x < field.nx; ++x)
          field(x, y, z) =
              static_cast<float>(flow({(x + dx) / grid.nx, (y + dy) / grid.ny, (z + dz) / grid.nz}).*component);
  };
  fill(faces.u, 0, .5, .5, &Vector3<double>::x);
  fill(faces.v, .5, 0, .5, &Vector3<double>::y);
  fill(faces.w, .5, .5, 0, &Vector3<double>::z);
  return faces;
}

void require_liquid(const Fluid<float>& fluid, const toml::table& scene) {
  for (int z = 0; z < fluid.nz; ++z)
    for (int y = 0; y < fluid.ny; ++y)
      for (int x = 0; x < fluid.nx; ++x)
        if (is_liquid(fluid.phi(x, y, z), fluid.solid(x, y, z))) return;
  refuse(scene.source(), "no liquid: every cell is air or solid");
}

Source read_source(const toml::table& table) {
  check_keys(table, {"centre", "radius"}, {"velocity", "until"});
  Source source{.centre = *vector_between(table, "centre", -1e6, 1e6, "m"), .radius = length(table, "radius")};
  source.velocity = vector_between(table, "velocity", -1e6, 1e6, "m/s").value_or(source.velocity);
  source.until = number_between(table, "until", 0, 1e9, "s").value_or(source.until);
  return source;
}

Model read_model(const toml::table& scene) {
  Model model;
  model.frame = number_between(scene, "frame_time", 1e-6, 1, "s").value_or(model.frame);
  model.gravity = vector_between(scene, "gravity", -1e6, 1e6, "m/s^2").value_or(model.gravity);
  model.per_block = whole_int(scene, "particles", 0, 1000).value_or(model.per_block);
  model.given = truth(scene, "given").value_or(false);
  model.period = number_between(scene, "period", 0, 1e6, "s").value_or(0);
  for (const toml::table* table : subtables(scene, "source")) model.sources.push_back(read_source(*table));
  return model;
}

}  // namespace

Scene load_scene(const std::string& path) {
  const toml::table scene = read_scene(path, "production_fluid", {"kind", "cells"},
                                       {"spacing", "open_top", "flow", "given", "period", "gravity", "particles",
                                        "frames", "frame_time", "volume_bound", "pool", "liquid", "air", "obstacle",
                                        "mesh", "source"});
  const Grid grid = read_grid(scene);
  Flow* const flow = read_flow(scene);
  Scene made{.name = scene_name(path),
             .path = path,
             .fluid = {.nx = grid.nx,
                       .ny = grid.ny,
                       .nz = grid.nz,
                       .spacing = static_cast<float>(grid.spacing),
                       .open_top = truth(scene, "open_top").value_or(false),
                       .phi = read_liquid(scene, grid),
                       .solid = read_obstacles(scene, grid, path),
                       .velocity = faces_of(grid, flow)},
             .model = read_model(scene),
             .frames = whole_int(scene, "frames", 1).value_or(100),
             .volume_bound = number_between(scene, "volume_bound", 0, 1, "").value_or(1)};
  if (made.model.sources.empty()) require_liquid(made.fluid, scene);
  return made;
}

}  // namespace lockstep::production_fluid
