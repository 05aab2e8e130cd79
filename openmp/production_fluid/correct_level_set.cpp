// Lets escaped particles put the level set right.
//
// Few particles have escaped. First they are found, sixteen at a time, line by line of blocks. Then each line of cells
// asks the escaped ones of the four lines of blocks around it: cells own the result, so no two threads write to one,
// and a line that none is near is copied.
//
// The contract stands in common/production_fluid/correct_level_set.h.
#include "common/production_fluid/correct_level_set.h"

#include <algorithm>
#include <bit>

#include "common/real.h"
#include "common/simd.h"
#include "openmp/failure.h"
#include "openmp/production_fluid/scattered_corners.h"

namespace lockstep::production_fluid::openmp {
namespace {

using namespace lockstep::openmp;

// The escaped particles of each line of blocks: particle[first .. first + count[line] - 1], where `first` is the line's
// first particle.
struct Escaped {
  Array<std::int32_t> particle, count;
};

int find_escaped(const Field<Real>& phi, const Particles<Real>& particles, int begin, int end, std::int32_t* found) {
  const auto& [px, py, pz] = particles.position;
  const floatv per_spacing = 1 / phi.spacing;
  int count = 0;
  for (int i = begin; i < end; i += lanes) {
    const Vector3<floatv> at = per_spacing * Vector3<floatv>{load(&px[i]), load(&py[i]), load(&pz[i])};
    const floatv here = sample<intv>(phi, first_centre, at, ScatteredCorners());
    const maskv escaped = has_escaped(load(&particles.sign[i]), here, load(&particles.radius[i]));
    for (std::uint32_t left = bits(escaped & first_lanes(end - i)); left; left &= left - 1)
      found[count++] = i + std::countr_zero(left);
  }
  return count;
}

// A line of cells, by the escaped particles of the lines of blocks at y - 1 and y, z - 1 and z.
class LineOfCells {
 public:
  LineOfCells(const Field<Real>& phi, const Particles<Real>& particles, const Escaped& escaped)
      : phi_(phi), particles_(particles), escaped_(escaped) {}

  void correct(int y, int z, Real* minus, Real* corrected) const {
    const Real* const before = &phi_(0, y, z);
    std::copy_n(before, phi_.nx, corrected);  // phi+
    if (!any_around(y, z)) return;
    std::copy_n(before, phi_.nx, minus);
    for_each_around(y, z, [&](int i) { apply(i, y, z, corrected, minus); });
    for (int x = 0; x < phi_.nx; ++x) corrected[x] = of_less_magnitude(corrected[x], minus[x]);
  }

 private:
  template <class F>
  void for_each_line_around(int y, int z, const F& f) const {
    for (int bz = std::max(z - 1, 0); bz <= z; ++bz)
      for (int by = std::max(y - 1, 0); by <= y; ++by) f(by + phi_.ny * bz);
  }
  bool any_around(int y, int z) const {
    bool any = false;
    for_each_line_around(y, z, [&](int line) { any |= escaped_.count[line] > 0; });
    return any;
  }
  template <class F>
  void for_each_around(int y, int z, const F& f) const {
    for_each_line_around(y, z, [&](int line) {
      const int first = particles_.first[std::size_t(line) * phi_.nx];
      for (int k = first; k < first + escaped_.count[line]; ++k) f(escaped_.particle[k]);
    });
  }
  void apply(int i, int y, int z, Real* plus, Real* minus) const {
    const Real sign = particles_.sign[i], radius = particles_.radius[i];
    const Vector3<Real> at = (1 / phi_.spacing) * load(particles_.position, i);
    const int first = place<std::int32_t>(at.x - Real(.5), phi_.nx).first;
    for (int x = first; x < std::min(first + 2, phi_.nx); ++x) {
      const Vector3<Real> centre = {to_float(x) + Real(.5), to_float(y) + Real(.5), to_float(z) + Real(.5)};
      correct_centre(sign, level_of_ball(sign, radius, centre - at, phi_.spacing), plus[x], minus[x]);
    }
  }

  const Field<Real>& phi_;
  const Particles<Real>& particles_;
  const Escaped& escaped_;
};

}  // namespace

void correct_level_set(const Field<Real>& phi, const Particles<Real>& particles, Field<Real>& corrected) {
  const int lines = phi.ny * phi.nz;
  Escaped escaped = {Array<std::int32_t>(padded(particles.count)), Array<std::int32_t>(lines)};
  const LineOfCells line_of_cells(phi, particles, escaped);
  Failure failure;
#pragma omp parallel
  {
    Array<Real> minus;
    failure.guard([&] { minus.resize(phi.nx); });
    // A line of blocks writes its own part of the list. Lines differ in how many particles they have.
#pragma omp for schedule(dynamic, 16)
    for (int line = 0; line < lines; ++line) {
      const std::int32_t* const first = &particles.first[std::size_t(line) * phi.nx];
      escaped.count[line] = find_escaped(phi, particles, first[0], first[phi.nx], &escaped.particle[first[0]]);
    }
    if (!failure.happened()) {
      // A line of cells is one iteration's. The lists are complete: the loop before ends with a barrier.
#pragma omp for schedule(dynamic, 16)
      for (int line = 0; line < lines; ++line) {
        const int y = line % phi.ny, z = line / phi.ny;
        line_of_cells.correct(y, z, minus.data(), &corrected(0, y, z));
      }
    }
  }
  failure.rethrow();
}

}  // namespace lockstep::production_fluid::openmp
