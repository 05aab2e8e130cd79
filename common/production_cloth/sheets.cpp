#include "common/production_cloth/sheets.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "common/spatial/morton.h"

namespace lockstep::production_cloth {
namespace {

// Adds the two triangles of a square with corners a b / c d.
void add_square(Mesh& mesh, int a, int b, int c, int d, bool rises) {
  if (rises)
    mesh.triangles.insert(mesh.triangles.end(), {{a, c, b}, {b, c, d}});
  else
    mesh.triangles.insert(mesh.triangles.end(), {{a, c, d}, {a, d, b}});
}

}  // namespace

Mesh make_sheet(const SheetPlan& plan) {
  const auto [columns, rows] = plan.squares;
  Mesh mesh;
  for (int r = 0; r <= rows; ++r)
    for (int c = 0; c <= columns; ++c)
      mesh.points.push_back(plan.origin + (double(c) / columns) * plan.across + (double(r) / rows) * plan.down);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const int a = r * (columns + 1) + c, below = a + columns + 1;
      add_square(mesh, a, a + 1, below, below + 1, r % 2 == 0);
    }
  return mesh;
}

Mesh make_tube(const TubePlan& plan) {
  const auto [around, along] = plan.squares;
  const Vector3<double> axis = plan.to - plan.from;
  const Vector3<double> unit = (1 / std::sqrt(dot(axis, axis))) * axis;
  const Vector3<double> helper = std::abs(unit.x) < .5 ? Vector3<double>{1, 0, 0} : Vector3<double>{0, 1, 0};
  const Vector3<double> beside = cross(unit, helper), u = (1 / std::sqrt(dot(beside, beside))) * beside,
                        v = cross(unit, u);
  Mesh mesh;
  for (int r = 0; r <= along; ++r)
    for (int c = 0; c < around; ++c) {
      const double angle = 2 * std::numbers::pi * c / around;
      mesh.points.push_back(plan.from + (double(r) / along) * axis + (plan.radius * std::cos(angle)) * u +
                            (plan.radius * std::sin(angle)) * v);
    }
  for (int r = 0; r < along; ++r)
    for (int c = 0; c < around; ++c) {
      const int next = (c + 1) % around, row = r * around, below = row + around;
      add_square(mesh, row + c, row + next, below + c, below + next, r % 2 == 0);
    }
  return mesh;
}

Mesh renumbered(const Mesh& mesh) {
  const int n = static_cast<int>(mesh.points.size());
  spatial::Box<double> extent = spatial::empty_box<double>;
  for (const Vector3<double>& p : mesh.points) extent = spatial::around(extent, {p, p});
  const double scale = spatial::morton_scale(extent);
  std::vector<std::int32_t> code(n), order(n), number(n);
  for (int i = 0; i < n; ++i) code[i] = spatial::morton_code(mesh.points[i], extent.low, scale);
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, {}, [&](std::int32_t i) { return code[i]; });
  Mesh sorted;
  for (int k = 0; k < n; ++k) {
    number[order[k]] = k;
    sorted.points.push_back(mesh.points[order[k]]);
  }
  for (const Triangle& t : mesh.triangles) sorted.triangles.push_back({number[t.a], number[t.b], number[t.c]});
  std::ranges::stable_sort(sorted.triangles, {}, [](const Triangle& t) { return std::min({t.a, t.b, t.c}); });
  return sorted;
}

}  // namespace lockstep::production_cloth
