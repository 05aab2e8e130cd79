// The points beside the interface and their distances from it (common/levelset/crossings.h): where the march, or the
// sweeps, begin.
//
// Source: [ITJ07]; Adalsteinsson and Sethian, J. Comput. Phys. 148 (1999). The contract stands in
// common/levelset/initialize.h.
#include "common/levelset/initialize.h"

#include <algorithm>
#include <utility>

#include "common/levelset/crossings.h"
#include "common/real.h"

namespace lockstep::levelset::serial {
namespace {

using Number = Real;
using Mask = bool;

// One line along x.
void initialize_line(const Field<Real>& phi, int y, int z, Field<Real>& d, std::vector<Point>& interface) {
  // Beyond the grid phi is what it is here: no crossing.
  const auto line = [&](int y, int z) { return &phi(0, std::clamp(y, 0, phi.ny - 1), std::clamp(z, 0, phi.nz - 1)); };
  const Real *const middle = line(y, z), *const below = line(y - 1, z), *const above = line(y + 1, z),
                    *const behind = line(y, z - 1), *const in_front = line(y, z + 1);
  for (int x = 0; x < phi.nx; ++x) {
    const Number here = middle[x];
    const Number before = x > 0 ? middle[x - 1] : here, after = x < phi.nx - 1 ? middle[x + 1] : here;
    const Vector3<Number> beyond = {other_side(here, before, after),  //
                                    other_side(here, below[x], above[x]), other_side(here, behind[x], in_front[x])};
    const Mask beside = beside_interface(here, beyond);
    if (none(beside)) continue;

    d(x, y, z) = distance_from_crossings(here, beyond, Number(phi.spacing));
    interface.push_back({x, y, z});
  }
}

}  // namespace

void initialize(const Field<Real>& phi, Distances<Real>& distances) {
  Field<Real>& d = distances.distance;
  d = {phi.nx, phi.ny, phi.nz, phi.spacing, phi.pitch, std::move(d.value)};
  d.value.assign(phi.value.size(), far<Real>);
  distances.interface.clear();

  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y) initialize_line(phi, y, z, d, distances.interface);
}

}  // namespace lockstep::levelset::serial
