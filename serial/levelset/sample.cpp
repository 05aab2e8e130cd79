// A field between its points, by trilinear interpolation: seven interpolations a position, along x, then y, then z.
//
// The contract stands in common/levelset/sample.h.
#include "common/levelset/sample.h"

#include "common/real.h"

namespace lockstep::levelset::serial {

using Index = std::int32_t;

void sample(const Field<Real>& field, int count, const Vectors<Real>& position, Array<Real>& value) {
  const Real per_metre = 1 / field.spacing;
  for (int i = 0; i < count; ++i) {
    const auto x = between<Index>(position.x[i] * per_metre, field.nx);
    const auto y = between<Index>(position.y[i] * per_metre, field.ny);
    const auto z = between<Index>(position.z[i] * per_metre, field.nz);

    const auto along_x = [&](Index dy, Index dz) {
      const Real* const pair = &field.value[field.index(x.first, y.first + dy, z.first + dz)];
      return interpolate(pair[0], pair[1], x.fraction);
    };
    const Real near = interpolate(along_x(0, 0), along_x(1, 0), y.fraction);
    const Real far = interpolate(along_x(0, 1), along_x(1, 1), y.fraction);
    value[i] = interpolate(near, far, z.fraction);
  }
}

}  // namespace lockstep::levelset::serial
