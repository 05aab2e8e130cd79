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
  const Vector3<floatv> at = floatv(1 / phi.spacing) * Vector3<floatv>{load(&px[i]), load(&py[i]), load(&pz[i])};
  const floatv here = sample<Index>(phi, first_centre, at, LineCorners());
  return has_escaped(load(&particles.sign[i]), here, load(&particles.radius[i]));
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

// A line of cells, by the escaped particles of the lines of blocks at y - 1 and y, z - 1 and z.
class LineOfCells {
 public:
  LineOfCells(const Escaped& escaped, Field<Real>& phi) : escaped_(escaped), phi_(phi) {}

  void correct(int y, int z, Real* minus) const {
    Real* const plus = &phi_(0, y, z);
    const int nx = phi_.nx;
    bool any = false;
    for (int bz = std::max(z - 1, 0); bz <= z; ++bz) {
      const int begin = escaped_.first[std::max(y - 1, 0) + phi_.ny * bz], end = escaped_.first[y + 1 + phi_.ny * bz];
      if (begin == end) continue;
      if (!any) std::copy_n(plus, nx, minus);
      any = true;
      for (int i = begin; i < end; i += lanes) apply(i, std::min(i + lanes, end), y, z, plus, minus);
    }
    if (!any) return;
    for (int x = 0; x < nx; x += lanes)
      store(plus + x, of_less_magnitude(load(plus + x), load(minus + x)), first_lanes(nx - x));
  }

 private:
  // Escaped particles i .. end - 1, at most sixteen: what they say of the two centres beside each is found at once.
  void apply(int i, int end, int y, int z, Real* plus, Real* minus) const {
    const floatv per_spacing = 1 / phi_.spacing, half = .5f;
    const Vector3<floatv> at =
        per_spacing * Vector3<floatv>{load(escaped_.x() + i), load(escaped_.y() + i), load(escaped_.z() + i)};
    const intv cell = place<Index>(at.x - half, phi_.nx).first;
    alignas(64) Real level[2][lanes];
    alignas(64) std::int32_t first[lanes];
    store(first, cell);
    for (int k = 0; k < 2; ++k) {
      const Vector3<floatv> centre = {to_float(cell + k) + half, to_float(intv(y)) + half, to_float(intv(z)) + half};
      store(level[k],
            level_of_ball(load(escaped_.sign() + i), load(escaped_.radius() + i), centre - at, floatv(phi_.spacing)));
    }
    for (int l = 0; l < end - i; ++l)
      for (int k = 0; k < 2 && first[l] + k < phi_.nx; ++k)
        correct_centre(escaped_.sign()[i + l], level[k][l], plus[first[l] + k], minus[first[l] + k]);
  }

  const Escaped& escaped_;
  Field<Real>& phi_;
};

}  // namespace

void correct_level_set(const Particles<Real>& particles, Field<Real>& phi) {
  Compaction chosen(particles.count);
  // A chunk chooses among its own particles, from a field that none writes yet.
#pragma omp parallel for schedule(static)
  for (int chunk = 0; chunk < chosen.chunks(); ++chunk)
    chosen.for_each_sixteen(chunk, [&](int i) { chosen.choose(i, have_escaped(phi, particles, i)); });
  const int lines = phi.ny * phi.nz;
  Escaped escaped(lines, chosen.add_up());
  const LineOfCells line_of_cells(escaped, phi);
  const Vectors<Real>& p = particles.position;
  Failure failure;
#pragma omp parallel
  {
    Array<Real> minus;
    failure.guard([&] { minus.resize(padded(phi.nx)); });
    // A line's beginning is known by now.
#pragma omp for schedule(static) nowait
    for (int line = 0; line <= lines; ++line)
      escaped.first[line] = chosen.before_any(particles.first[std::size_t(line) * phi.nx]);
      // A chunk's escaped ones go to places of their own.
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
#pragma omp for schedule(dynamic, 16)
      for (int line = 0; line < lines; ++line) line_of_cells.correct(line % phi.ny, line / phi.ny, minus.data());
    }
  }
  failure.rethrow();
}

}  // namespace lockstep::production_fluid::openmp
