// Small production cloths for tests: sheets, tubes, a closed surface, of every material, and deformed.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "common/convert.h"
#include "common/production_cloth/elastic.h"
#include "common/production_cloth/masses.h"
#include "common/production_cloth/sheets.h"

namespace lockstep::production_cloth {

struct SmallCloth {
  Topology topology;
  Vectors<double> rest;  // floats
  Material material;
};

inline SmallCloth cloth_of(const Mesh& mesh, const Material& material) {
  SmallCloth cloth = {make_topology(static_cast<int>(mesh.points.size()), mesh.triangles, "mesh"), {}, material};
  cloth.rest.resize(mesh.points.size());
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    store(cloth.rest, i, convert<double>(convert<float>(mesh.points[i])));
  return cloth;
}

// Squares of 2 cm.
inline SmallCloth sheet_of(int columns, int rows, const Material& material) {
  return cloth_of(make_sheet({.origin = {0, 0, 0},
                              .across = {.02 * columns, 0, 0},
                              .down = {0, 0, .02 * rows},
                              .squares = {columns, rows}}),
                  material);
}
inline SmallCloth tube_of(int around, int along, const Material& material) {
  return cloth_of(make_tube({{0, 0, 0}, {.02 * along, 0, 0}, .02 * around / 6, {around, along}}), material);
}
// A tetrahedron's surface: the far vertices of each of its hinges are an edge.
inline SmallCloth closed_of(const Material& material) {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {.02, 0, 0}, {0, .03, 0}, {0, 0, .025}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};
  return cloth_of(mesh, material);
}

inline std::vector<Material> all_materials() {
  std::vector<Material> materials;
  for (const Stretch stretch : {Stretch::springs, Stretch::stvk, Stretch::corotated})
    for (const Bend bend : {Bend::none, Bend::hinges, Bend::quadratic})
      materials.push_back({.stretch = stretch,
                           .stiffness = 3,
                           .membrane = 50,
                           .stretch_damping = stretch == Stretch::springs ? .2 : 1e-3,
                           .bend = bend,
                           .bending = 1e-4,
                           .bend_damping = bend == Bend::hinges ? .3 : 1e-3});
  return materials;
}

// Each component moved by up to `by`, m.
inline Vectors<double> shaken(const Vectors<double>& at, int vertices, double by, unsigned seed = 1) {
  Vectors<double> moved = at;
  std::mt19937 random(seed);
  const auto shake = [&] { return by * (2 * static_cast<double>(random() >> 8) / (1 << 24) - 1); };
  for (int i = 0; i < vertices; ++i) {
    const double x = shake(), y = shake(), z = shake();
    store(moved, i, convert<double>(convert<float>(load(moved, i) + Vector3<double>{x, y, z})));
  }
  return moved;
}

}  // namespace lockstep::production_cloth
