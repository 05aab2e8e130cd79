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

// What is read and written for the first time is prefetched so many lines before its turn: lines are too short for the
// processor to foresee them, and half of the time went into waiting for phi of the next slab.
constexpr int ahead = 4;

// One line along x.
void initialize_line(const Field<Real>& phi, int y, int z, Field<Real>& d, std::vector<Point>& interface) {
  // Beyond the grid phi is what it is here: no crossing.
  const auto line = [&](int y, int z) { return &phi(0, std::clamp(y, 0, phi.ny - 1), std::clamp(z, 0, phi.nz - 1)); };
  const Real *const middle = line(y, z), *const below = line(y - 1, z), *const above = line(y + 1, z),
                    *const behind = line(y, z - 1), *const in_front = line(y, z + 1),
                    *const to_come = line(y + ahead, z + 1);
  for (int x = 0; x < phi.nx; x += lanes) {
    const intv lane_x = lane_index() + x;
    const Number here = load(middle + x);
    const Number before = select(lane_x > 0, load(middle + x - 1), here),
                 after = select(lane_x < phi.nx - 1, load(middle + x + 1), here);
    const Vector3<Number> beyond = {other_side(here, before, after),  //
                                    other_side(here, load(below + x), load(above + x)),
                                    other_side(here, load(behind + x), load(in_front + x))};
    __builtin_prefetch(to_come + x);
    __builtin_prefetch(&d(x, y, z) + ahead * d.pitch, 1);
    const Mask beside = (lane_x < phi.nx) & beside_interface(here, beyond);
    if (none(beside)) continue;

    store(&d(x, y, z), distance_from_crossings(here, beyond, Number(phi.spacing)), beside);
    for (std::uint32_t set = bits(beside); set != 0; set &= set - 1)
      interface.push_back({x + std::countr_zero(set), y, z});
  }
}

}  // namespace

void initialize(const Field<Real>& phi, Distances<Real>& distances) {
  Field<Real>& d = distances.distance;
  d = {phi.nx, phi.ny, phi.nz, phi.spacing, phi.pitch, std::move(d.value)};
  d.value.resize(phi.value.size());
  std::fill(d.value.begin() + (d.index(0, 0, d.nz) - d.padding), d.value.end(),
            far<Real>);  // what is after the last line

  std::vector<std::vector<Point>> found(omp_get_max_threads());
  Failure failure;
#pragma omp parallel
  {
    std::vector<Point> mine;
    // Slabs of a thread are side by side, and threads in order. A thread writes all lines of its own slabs, padding as
    // well, and no others.
#pragma omp for schedule(static)
    for (int z = 0; z < phi.nz; ++z)
      failure.guard([&] {
        for (int y = 0; y < phi.ny; ++y) {
          std::fill_n(&d(0, y, z) - d.padding, d.pitch, far<Real>);
          initialize_line(phi, y, z, d, mine);
        }
      });
    found[omp_get_thread_num()] = std::move(mine);
  }
  failure.rethrow();
  distances.interface.clear();
  for (const std::vector<Point>& part : found)
    distances.interface.insert(distances.interface.end(), part.begin(), part.end());
}

}  // namespace lockstep::levelset::openmp
