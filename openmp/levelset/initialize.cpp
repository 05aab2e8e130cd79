// The points beside the interface and their distances from it (common/levelset/crossings.h): where the march, or the
// sweeps, begin.
//
// Each thread takes slabs of the grid, sixteen points along x at once, and lists the interface points that it finds;
// the lists of the threads, one after another, are in the order of the field.
//
// Source: [ITJ07]; Adalsteinsson and Sethian, J. Comput. Phys. 148 (1999). The contract stands in
// common/levelset/initialize.h.
#include "common/levelset/initialize.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "common/levelset/crossings.h"
#include "common/real.h"
#include "common/simd.h"
#include "openmp/failure.h"
#include "openmp/share.h"

namespace lockstep::levelset::openmp {
namespace {

using namespace lockstep::openmp;
using Number = floatv;
using Mask = maskv;

// phi is prefetched so many lines before its turn: lines are too short for the processor to foresee them, and half of
// the time went into waiting for phi of the next slab.
constexpr int ahead = 4;

// Whether sixteen points all have the sign of their neighbours: most have. `values` are of the points, and of those
// before and after them along each axis.
LOCKSTEP_INLINE bool have_one_sign(const Number (&values)[7]) {
  Number least = values[0], most = values[0];
  for (const Number& value : values) least = min(least, value), most = max(most, value);
  return none((least <= 0.f) & (most >= 0.f));
}

// One line along x, with its padding. Distances are streamed past the caches: the line is not fetched before it is
// written, and phi of the slabs beside stays where it is.
void initialize_line(const Field<Real>& phi, int y, int z, Field<Real>& d, std::vector<Point>& interface) {
  // Beyond the grid phi is what it is here: no crossing.
  const auto line = [&](int y, int z) { return &phi(0, std::clamp(y, 0, phi.ny - 1), std::clamp(z, 0, phi.nz - 1)); };
  const Real *const middle = line(y, z), *const below = line(y - 1, z), *const above = line(y + 1, z),
                    *const behind = line(y, z - 1), *const in_front = line(y, z + 1),
                    *const to_come = line(y + ahead, z + 1);
  Real* const distance = &d(0, y, z);
  for (int x = -d.padding; x < 0; x += lanes) stream(distance + x, Number(far<Real>));
  for (int x = 0; x < phi.nx; x += lanes) {
    // Lanes are chosen at a line's ends alone: at every vector it takes a sixth more time.
    const Number here = load(middle + x);
    const Number before = x > 0 ? load(middle + x - 1) : shift_up(here, middle[0]),
                 after = x < phi.nx - lanes ? load(middle + x + 1)
                                            : select(lane_index() + x < phi.nx - 1, load(middle + x + 1), here);
    __builtin_prefetch(to_come + x);
    if (have_one_sign({here, before, after, load(below + x), load(above + x), load(behind + x), load(in_front + x)})) {
      stream(distance + x, Number(far<Real>));
      continue;
    }
    const Vector3<Number> beyond = {other_side(here, before, after),  //
                                    other_side(here, load(below + x), load(above + x)),
                                    other_side(here, load(behind + x), load(in_front + x))};
    const Mask beside = beside_interface(here, beyond) & first_lanes(phi.nx - x);
    stream(&d(x, y, z), select(beside, distance_from_crossings(here, beyond, Number(phi.spacing)), Number(far<Real>)));
    for (std::uint32_t set = bits(beside); set != 0; set &= set - 1)
      interface.push_back({x + std::countr_zero(set), y, z});
  }
  for (int x = (phi.nx + lanes - 1) / lanes * lanes; x < d.pitch - d.padding; x += lanes)
    stream(distance + x, Number(far<Real>));
}

}  // namespace

void initialize(const Field<Real>& phi, Distances<Real>& distances) {
  Field<Real>& d = distances.distance;
  d = {phi.nx, phi.ny, phi.nz, phi.spacing, phi.pitch, std::move(d.value)};
  d.value.resize(phi.value.size());
  std::fill(d.value.begin() + (d.index(0, 0, d.nz) - d.padding), d.value.end(),
            far<Real>);  // what is after the last line

  // The first thread lists its points in the memory of the list that was there: new pages cost a fault each.
  std::vector<std::vector<Point>> found(omp_get_max_threads());
  distances.interface.clear();
  found[0].swap(distances.interface);
  Failure failure;
#pragma omp parallel
  {
    std::vector<Point> mine = std::move(found[omp_get_thread_num()]);
    // Slabs of a thread are side by side, and threads in order. A thread writes all lines of its own slabs, padding as
    // well, and no others.
#pragma omp for schedule(static)
    for (int z = 0; z < phi.nz; ++z)
      failure.guard([&] {
        for (int y = 0; y < phi.ny; ++y) initialize_line(phi, y, z, d, mine);
      });
    finish_streams();
    found[omp_get_thread_num()] = std::move(mine);
  }
  failure.rethrow();
  distances.interface.swap(found[0]);
  for (std::size_t thread = 1; thread < found.size(); ++thread)
    distances.interface.insert(distances.interface.end(), found[thread].begin(), found[thread].end());
}

}  // namespace lockstep::levelset::openmp
