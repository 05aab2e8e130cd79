// Lets escaped particles put the level set right.
//
// Few particles have escaped. First they are found, sixteen at a time, and moved side by side (openmp/compaction.h).
// Then each line of cells asks the escaped ones of the four lines of blocks around it: cells own the result, so no two
// threads write to one, and a line that none is near is not touched.
//
// The contract stands in common/production_fluid/correct_level_set.h.
#include "common/production_fluid/correct_level_set.h"

#include <algorithm>
#include <cstdint>
#include <memory>

#include "common/real.h"
#include "common/simd.h"
#include "openmp/compaction.h"
#include "openmp/failure.h"
#include "openmp/production_fluid/line_corners.h"

namespace lockstep::production_fluid::openmp {
namespace {

using namespace lockstep::openmp;
using Index = intv;

// Whether particles i .. i + 15 have escaped.
maskv have_escaped(const Field<Real>& phi, const Particles<Real>& particles, int i) {
  const auto& [px, py, pz] = particles.position;
  const floatv sign = load(&particles.sign[i]), radius = load(&particles.radius[i]);
  const Vector3<floatv> at = floatv(1 / phi.spacing) * Vector3<floatv>{load(&px[i]), load(&py[i]), load(&pz[i])};
  return has_escaped(sign, sample<Index>(phi, first_centre, at, LineCorners()), radius);
}

// The escaped particles, in the order of all, and where those of each line of blocks begin. Threads are the first to
// touch the particles' memory, each its own part.
struct Escaped {
  Array<std::int32_t> first;
  std::size_t room;
  std::unique_ptr<Real[]> value;

  Escaped(int lines, int count)
      : first(lines + 1), room(padded(count)), value(std::make_unique_for_overwrite<Real[]>(5 * room)) {}
  Real* column(int k) const { return &value[k * room]; }
  Real* x() const { return column(0); }
  Real* y() const { return column(1); }
  Real* z() const { return column(2); }
  Real* radius() const { return column(3); }
  Real* sign() const { return column(4); }
};

// Takes phi_p of escaped particles i .. end - 1, at most sixteen, into phi+ and phi- of the two centres beside each, in
// a line of cells. Lanes find phi_p.
void apply(const Escaped& escaped, int i, int end, const Field<Real>& phi, int y, int z, Real* plus, Real* minus) {
  const floatv sign = load(escaped.sign() + i), radius = load(escaped.radius() + i);
  const Vector3<floatv> at =
      floatv(1 / phi.spacing) * Vector3<floatv>{load(escaped.x() + i), load(escaped.y() + i), load(escaped.z() + i)};
  const auto first = [](floatv x, int n) { return place<Index>(x - Real(.5), n).first; };
  const Index x = first(at.x, phi.nx);
  alignas(64) std::int32_t cell[lanes];
  alignas(64) Real level[2][lanes];
  store(cell, x);
  for (int k = 0; k < 2; ++k) {
    const Vector3<floatv> centre = {to_float(x + k) + Real(.5), to_float(y) + Real(.5), to_float(z) + Real(.5)};
    store(level[k], level_of_ball(sign, radius, centre - at, floatv(phi.spacing)));
  }
  for (int l = 0; l < end - i; ++l)
    for (int cx = cell[l]; cx < std::min(cell[l] + 2, phi.nx); ++cx)
      correct_centre(escaped.sign()[i + l], level[cx - cell[l]][l], plus[cx], minus[cx]);
}

// phi+, in phi's place, and phi- of a line of cells, by the escaped particles of the lines of blocks at y - 1 and y,
// z - 1 and z. Returns whether there are any.
bool ask_escaped(const Escaped& escaped, int y, int z, Field<Real>& phi, Real* minus) {
  Real* const plus = &phi(0, y, z);
  bool any = false;
  for (int bz = std::max(z - 1, 0); bz <= z; ++bz) {
    const int begin = escaped.first[std::max(y - 1, 0) + phi.ny * bz], end = escaped.first[y + 1 + phi.ny * bz];
    if (begin == end) continue;
    if (!any) std::copy_n(plus, phi.nx, minus);
    any = true;
    for (int i = begin; i < end; i += lanes) apply(escaped, i, std::min(i + lanes, end), phi, y, z, plus, minus);
  }
  return any;
}

}  // namespace

void correct_level_set(const Particles<Real>& particles, Field<Real>& phi) {
  Compaction chosen(particles.count);
  // A chunk chooses among its own particles, from a field that none writes yet.
#pragma omp parallel for schedule(static)
  for (int chunk = 0; chunk < chosen.chunks(); ++chunk)
    chosen.for_each_sixteen(chunk, [&](int i) { chosen.choose(i, have_escaped(phi, particles, i)); });
  const int lines = phi.ny * phi.nz;
  Escaped escaped(lines, chosen.add_up());
  const Vectors<Real>& p = particles.position;
  Failure failure;
#pragma omp parallel
  {
    Array<Real> minus;
    failure.guard([&] { minus.resize(phi.nx); });
    // An iteration writes one element of `first`, from counts that are complete; the next loop does not read it, hence
    // nowait.
#pragma omp for schedule(static) nowait
    for (int line = 0; line <= lines; ++line)
      escaped.first[line] = chosen.before_any(particles.first[std::size_t(line) * phi.nx]);
      // A chunk moves its own escaped particles, to places of their own.
#pragma omp for schedule(static)
    for (int chunk = 0; chunk < chosen.chunks(); ++chunk)
      chosen.for_each_sixteen(chunk, [&](int i) {
        if (chosen.which(i) == 0) return;
        chosen.move(i, {{p.x.data(), escaped.x()},
                        {p.y.data(), escaped.y()},
                        {p.z.data(), escaped.z()},
                        {particles.radius.data(), escaped.radius()},
                        {particles.sign.data(), escaped.sign()}});
      });
    if (!failure.happened()) {
      // A line of cells is one iteration's, which alone writes it. The escaped ones are complete: the loop before ends
      // with a barrier. Lines differ in how many are near them.
#pragma omp for collapse(2) schedule(dynamic, 16)
      for (int z = 0; z < phi.nz; ++z)
        for (int y = 0; y < phi.ny; ++y) {
          if (!ask_escaped(escaped, y, z, phi, minus.data())) continue;
          for (int x = 0; x < phi.nx; ++x) phi(x, y, z) = of_less_magnitude(phi(x, y, z), minus[x]);
        }
    }
  }
  failure.rethrow();
}

}  // namespace lockstep::production_fluid::openmp
