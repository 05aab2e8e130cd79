#include "common/levelset/fit.h"

#include <algorithm>
#include <cmath>

#include "common/digits.h"
#include "common/input_error.h"

namespace lockstep::levelset {
namespace {

using Vector = Vector3<double>;

struct Corners {
  Vector low, high;  // m
};

Corners corners_of(const Mesh& mesh) {
  Corners box{mesh.points[0], mesh.points[0]};
  for (const Vector& p : mesh.points)
    box = {{min(box.low.x, p.x), min(box.low.y, p.y), min(box.low.z, p.z)},
           {max(box.high.x, p.x), max(box.high.y, p.y), max(box.high.z, p.z)}};
  return box;
}

Corners corners_of(const Grid& grid) {
  return {grid.origin, grid.origin + grid.spacing * Vector{double(grid.nx), double(grid.ny), double(grid.nz)}};
}

std::string words_of(const Corners& box) {
  const auto point = [](const Vector& p) {
    return '(' + digits_of(p.x, 6) + ", " + digits_of(p.y, 6) + ", " + digits_of(p.z, 6) + ')';
  };
  return point(box.low) + " to " + point(box.high);
}

}  // namespace

Grid fit_grid(const Mesh& mesh, const std::array<int, 3>& points, double room, const std::string& where) {
  const auto [nx, ny, nz] = points;
  if (!(std::min({nx, ny, nz}) > 2 * room))
    throw InputError(where + ": expected more than " + digits_of(2 * room) +
                     " points along each axis, for the mesh and " + digits_of(room) + " spacings around it");
  const auto [low, high] = corners_of(mesh);
  const Vector size = high - low;
  const double spacing = std::max({size.x / (nx - 2 * room), size.y / (ny - 2 * room), size.z / (nz - 2 * room)});
  // Farther from zero, rounding would move points.
  const double farthest = 1e9 * spacing;
  const auto is_near = [&](const Vector& p) {
    return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) <= farthest;
  };
  if (!(spacing >= 1e-6 && spacing <= 1e6 && is_near(low) && is_near(high)))
    throw InputError(where + ": a spacing of " + digits_of(spacing) + " m fits the mesh, which reaches from " +
                     words_of({low, high}) + "; expected 1e-6 to 1e6, and coordinates of at most 1e9 spacings");
  const Vector half = .5 * spacing * Vector{double(nx), double(ny), double(nz)};
  return {.nx = nx, .ny = ny, .nz = nz, .spacing = spacing, .origin = .5 * (low + high) - half};
}

void require_inside(const Mesh& mesh, const Grid& grid, const std::string& where) {
  const Corners inner = corners_of(mesh), outer = corners_of(grid);
  const auto is_inside = [&](double Vector::*axis) {
    return inner.low.*axis >= outer.low.*axis && inner.high.*axis <= outer.high.*axis;
  };
  if (!is_inside(&Vector::x) || !is_inside(&Vector::y) || !is_inside(&Vector::z))
    throw InputError(where + ": the mesh, from " + words_of(inner) + ", reaches beyond the grid, from " +
                     words_of(outer) + ", in m; without spacing and origin the grid fits the mesh");
}

}  // namespace lockstep::levelset
