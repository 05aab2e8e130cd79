// The points beside the interface and their distances from it: where the march, or the sweeps, begin.
//
// From a point, the interface crosses an axis at theta spacings, as linear interpolation between the point and its neighbour has it:
// 1 / theta = 1 + |phi of the neighbour| / |phi|. So the nearer crossing of an axis is the one towards the greater |phi|, and the plane
// through the crossings is at h / sqrt(sum 1 / theta^2): a small theta never is divided by.
//
// Source: [ITJ07]; Adalsteinsson and Sethian, J. Comput. Phys. 148 (1999). The contract stands in common/levelset/initialize.h.
#include "common/levelset/initialize.h"

#include <algorithm>
#include <utility>

#include "common/math.h"
#include "common/real.h"

namespace lockstep::levelset::serial {
namespace {

// How far from zero phi is on the other side, at the farther of two neighbours; negative where both are on this side.
Real beyond(Real phi, Real before, Real after) { return select(phi < 0, max(before, after), max(-before, -after)); }

Real inverse_theta(Real phi, Real beyond) { return select(beyond >= 0, 1 + beyond / abs(phi), 0); }

}  // namespace

void initialize(const Field<Real>& phi, Distances<Real>& distances) {
  Field<Real>& d = distances.distance;
  d = {phi.nx, phi.ny, phi.nz, phi.spacing, phi.pitch, std::move(d.value)};
  d.value.assign(phi.value.size(), far<Real>);
  distances.interface.clear();

  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y)
      for (int x = 0; x < phi.nx; ++x) {
        // Beyond the grid phi is what it is here: no crossing.
        const auto at = [&](int x, int y, int z) {
          return phi(std::clamp(x, 0, phi.nx - 1), std::clamp(y, 0, phi.ny - 1), std::clamp(z, 0, phi.nz - 1));
        };
        const Real here = phi(x, y, z);
        const Real bx = beyond(here, at(x - 1, y, z), at(x + 1, y, z));
        const Real by = beyond(here, at(x, y - 1, z), at(x, y + 1, z));
        const Real bz = beyond(here, at(x, y, z - 1), at(x, y, z + 1));
        if (!(here == 0 || max(bx, max(by, bz)) >= 0)) continue;

        const Real ix = inverse_theta(here, bx), iy = inverse_theta(here, by), iz = inverse_theta(here, bz);
        d(x, y, z) = select(here == 0, 0, phi.spacing / sqrt(ix * ix + iy * iy + iz * iz));
        distances.interface.push_back({x, y, z});
      }
}

}  // namespace lockstep::levelset::serial
