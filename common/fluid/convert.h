// A simulation's state in another precision (common/convert.h).
#pragma once

#include "common/convert.h"
#include "common/fluid/fluid.h"

namespace lockstep::fluid {

template <class To, class From>
Particles<To> convert(const Particles<From>& p) {
  Particles<To> to;
  to.count = p.count;
  convert_arrays<To>(p, to);
  return to;
}

template <class To, class From>
Axis<To> convert(const Axis<From>& a) {
  return {static_cast<To>(a.min), static_cast<To>(a.max), a.cells, static_cast<To>(a.cells_per_metre)};
}

template <class To, class From>
Grid<To> convert(const Grid<From>& g) {
  return {convert<To>(g.x), convert<To>(g.y), convert<To>(g.z), g.cell_begin};
}

template <class To, class From>
Fluid<To> convert(const Fluid<From>& f) {
  const Grid<To> grid = convert<To>(f.grid);
  return {convert<To>(f.model),
          grid,
          convert<To>(f.particles),
          convert<To>(f.sorted),
          make_neighbours(grid, f.particles.count),
          convert<To>(f.density),
          convert<To>(f.acceleration)};
}

}  // namespace lockstep::fluid
