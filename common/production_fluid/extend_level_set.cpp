#include "common/production_fluid/extend_level_set.h"

#include <algorithm>
#include <vector>

#include "common/counting_sort.h"

namespace lockstep::production_fluid {
namespace {

struct Cell3 {
  std::int32_t x, y, z;
};

// Solid cells near the open, the nearest first.
template <class Real>
std::vector<Cell3> solid_cells(const Field<Real>& solid) {
  const Real deepest = -Real(depth_of_extension) * solid.spacing;
  std::vector<Cell3> cells;
  for (int z = 0; z < solid.nz; ++z)
    for (int y = 0; y < solid.ny; ++y)
      for (int x = 0; x < solid.nx; ++x)
        if (is_solid(solid(x, y, z)) && solid(x, y, z) >= deepest) cells.push_back({x, y, z});
  std::ranges::stable_sort(cells, std::greater{}, [&](const Cell3& c) { return solid(c.x, c.y, c.z); });
  return cells;
}

// A cell that gets a value, and the neighbours whose values make it.
template <class Real>
struct Made {
  std::int32_t cell, level, neighbour[3];
  Real share[3];
};

template <class Real>
std::vector<Made<Real>> made_cells(const Field<Real>& solid) {
  constexpr std::int32_t unknown = -1;
  std::vector<std::int32_t> level(solid.value.size(), unknown);  // 0 in the open
  for (int z = 0; z < solid.nz; ++z)
    for (int y = 0; y < solid.ny; ++y)
      for (int x = 0; x < solid.nx; ++x)
        if (!is_solid(solid(x, y, z))) level[solid.index(x, y, z)] = 0;

  std::vector<Made<Real>> made;
  for (const auto& [x, y, z] : solid_cells(solid)) {
    const std::int32_t here = static_cast<std::int32_t>(solid.index(x, y, z));
    Made<Real> cell{.cell = here, .level = 0, .neighbour = {here, here, here}, .share = {}};
    const auto nearer = [&](int along, int n, std::int32_t step) {  // of the neighbours along an axis
      std::int32_t best = here;
      for (const bool up : {false, true}) {
        if (up ? along + 1 == n : along == 0) continue;
        const std::int32_t other = up ? here + step : here - step;
        if (level[other] != unknown && solid.value[other] > solid.value[best]) best = other;
      }
      return best;
    };
    const std::int32_t best[] = {nearer(x, solid.nx, 1), nearer(y, solid.ny, solid.pitch),
                                 nearer(z, solid.nz, solid.pitch * solid.ny)};
    Real sum = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (best[axis] == here) continue;
      const Real weight = solid.value[best[axis]] - solid.value[here];
      sum += weight;
      cell.neighbour[axis] = best[axis], cell.share[axis] = weight / sum;
      cell.level = std::max(cell.level, level[best[axis]] + 1);
    }
    if (cell.level == 0) continue;
    level[here] = cell.level;
    made.push_back(cell);
  }
  return made;
}

}  // namespace

template <class Real>
Extension<Real> make_extension(const Fluid<Real>& fluid) {
  const std::vector<Made<Real>> made = made_cells(fluid.solid);
  std::int32_t levels = 0;
  for (const Made<Real>& cell : made) levels = std::max(levels, cell.level);
  Extension<Real> extension;
  const std::size_t n = padded(made.size());
  extension.cell.resize(n);
  for (int axis = 0; axis < 3; ++axis) extension.neighbour[axis].resize(n), extension.share[axis].resize(n);
  const auto for_each = [&](const auto& visit) {
    for (const Made<Real>& cell : made) visit(cell, cell.level - 1);
  };
  const auto put = [&](const Made<Real>& cell, int place) {
    extension.cell[place] = cell.cell;
    for (int axis = 0; axis < 3; ++axis)
      extension.neighbour[axis][place] = cell.neighbour[axis], extension.share[axis][place] = cell.share[axis];
  };
  stable_counting_sort(levels, for_each, put, extension.first);
  return extension;
}

template Extension<float> make_extension(const Fluid<float>& fluid);
template Extension<double> make_extension(const Fluid<double>& fluid);

}  // namespace lockstep::production_fluid
