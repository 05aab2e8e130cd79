// The lines of cells beside a line, walls and the air above an open top among them.
#pragma once

#include "common/production_fluid/state.h"

namespace lockstep::production_fluid {

// phi and solid of cells (0, y, z), (1, y, z) and so on. Element -1 and the one after the last are walls.
template <class Real>
struct Line {
  const Real *phi, *solid;
};

// The lines of a fluid. Beyond the box are walls, and above an open top air whose phi is 0.
template <class Real>
class Lines {
 public:
  explicit Lines(const Fluid<Real>& fluid)
      : fluid_(fluid), zero_(fluid.phi.pitch, 0), wall_(fluid.phi.pitch, -1), air_(fluid.phi.pitch, 1) {}

  Line<Real> operator()(int y, int z) const {
    if (y == fluid_.ny && fluid_.open_top) return {zero_.data(), air_.data()};
    if (y < 0 || y >= fluid_.ny || z < 0 || z >= fluid_.nz) return {zero_.data(), wall_.data()};
    const std::size_t first = fluid_.phi.index(0, y, z);
    return {&fluid_.phi.value[first], &fluid_.solid.value[first]};
  }

 private:
  const Fluid<Real>& fluid_;
  Array<Real> zero_, wall_, air_;
};

}  // namespace lockstep::production_fluid
