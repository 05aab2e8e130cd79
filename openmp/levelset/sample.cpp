// A field between its points, by trilinear interpolation: seven interpolations a position, along x, then y, then z.
//
// Sixteen positions at once. The two neighbours along x stand side by side in memory, so one access brings both
// (gather_pairs): four a position instead of eight.
//
// The contract stands in common/levelset/sample.h.
#include "common/levelset/sample.h"

#include "common/real.h"
#include "common/simd.h"

namespace lockstep::levelset::openmp {

using Index = intv;

void sample(const Field<Real>& field, int count, const Vectors<Real>& position, Array<Real>& value) {
  const Real per_metre = 1 / field.spacing;
  // An iteration writes its own sixteen values; what it reads, no thread writes.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < count; i += lanes) {
    const auto x = between<Index>(load(&position.x[i]) * per_metre, field.nx);
    const auto y = between<Index>(load(&position.y[i]) * per_metre, field.ny);
    const auto z = between<Index>(load(&position.z[i]) * per_metre, field.nz);
    const Index corner = (z.first * field.ny + y.first) * field.pitch + x.first;

    const auto along_x = [&](int dy, int dz) {
      const auto [first, second] = gather_pairs(&field.value[field.index(0, dy, dz)], corner);
      return interpolate(first, second, x.fraction);
    };
    const floatv near = interpolate(along_x(0, 0), along_x(1, 0), y.fraction);
    const floatv far = interpolate(along_x(0, 1), along_x(1, 1), y.fraction);
    store(&value[i], interpolate(near, far, z.fraction), first_lanes(count - i));
  }
}

}  // namespace lockstep::levelset::openmp
