// Makes the system of the pressure.
//
// The algorithm and its serial form stand in serial/production_fluid/make_system.cpp. Sixteen cells along x at once;
// threads share the lines. The runs of lines are counted before they are written. One thread finds the pockets: it
// works on runs, of which there are about as many as lines.
//
// The contract stands in common/production_fluid/make_system.h.
#include "common/production_fluid/make_system.h"

#include <algorithm>
#include <bit>
#include <vector>

#include "common/production_fluid/neighbours.h"
#include "common/production_fluid/pockets.h"
#include "common/real.h"
#include "common/simd.h"

namespace lockstep::production_fluid::openmp {
namespace {

// Writes a line of all arrays, zero where no liquid is. Lines of the border have no cells.
void make_line(const Fluid<Real>& fluid, const Lines<Real>& lines, int y, int z, System<Real>& system) {
  const std::size_t first = system.cells.index(0, y, z);
  Real* const diagonal = &system.diagonal[first];
  Real* const right = &system.right[first];
  std::uint8_t* const air = &system.air[first];
  if (y < 0 || z < 0 || z >= fluid.nz) {
    std::fill_n(diagonal, system.cells.line(), 0.f), std::fill_n(right, system.cells.line(), 0.f);
    std::fill_n(air, system.cells.line(), 0);
    return;
  }
  const auto& [u, v, w] = fluid.velocity;
  const Line<Real> here = lines(y, z), low_y = lines(y - 1, z), high_y = lines(y + 1, z), low_z = lines(y, z - 1),
                   high_z = lines(y, z + 1);
  // An iteration writes its own element of `air`.
#pragma omp simd
  for (int x = 0; x < fluid.nx; ++x) air[x] = is_air(here.phi[x], here.solid[x]);
  for (int x = 0; x < fluid.nx; x += lanes) {
    const maskv in_box = first_lanes(fluid.nx - x);
    const floatv phi = load(&here.phi[x]);
    const maskv liquid = in_box & is_liquid(phi, load(&here.solid[x]));
    Row<floatv> row;
    if (any(liquid)) {
      add_face(phi, load(&here.phi[x - 1]), load(&here.solid[x - 1]), load(&u(x, y, z)), row);
      add_face(phi, load(&here.phi[x + 1]), load(&here.solid[x + 1]), -load(&u(x + 1, y, z)), row);
      add_face(phi, load(&low_y.phi[x]), load(&low_y.solid[x]), load(&v(x, y, z)), row);
      add_face(phi, load(&high_y.phi[x]), load(&high_y.solid[x]), -load(&v(x, y + 1, z)), row);
      add_face(phi, load(&low_z.phi[x]), load(&low_z.solid[x]), load(&w(x, y, z)), row);
      add_face(phi, load(&high_z.phi[x]), load(&high_z.solid[x]), -load(&w(x, y, z + 1)), row);
    }
    store(&diagonal[x], select(liquid, row.diagonal, 0.f), in_box);
    store(&right[x], select(liquid, row.right, 0.f), in_box);
  }
  diagonal[fluid.nx] = right[fluid.nx] = 0;
  air[fluid.nx] = 0;
}

// Calls f(begin, end) for each run of a line.
template <class F>
void for_each_run_in(const Real* diagonal, int nx, const F& f) {
  int begin = -1;  // of the run that has begun
  for (int x = 0; x < nx; x += lanes) {
    std::uint32_t rows = bits((load(&diagonal[x]) > 0.f) & first_lanes(nx - x));
    for (int l = 0; l < lanes;) {
      const std::uint32_t from_here = rows >> l;
      const int next = std::min(lanes, l + std::countr_zero(begin < 0 ? from_here : ~from_here));
      if (next < lanes) {
        if (begin >= 0) f(begin, x + next);
        begin = begin < 0 ? x + next : -1;
      }
      l = next;
    }
  }
  if (begin >= 0) f(begin, nx);
}

void find_runs(System<Real>& system) {
  const int nx = system.cells.nx, ny = system.cells.ny, lines = ny * system.cells.nz;
  system.first_run.resize(lines + 1);
  system.first_run[0] = 0;
  const auto line_of = [&](int line) { return &system.diagonal[system.cells.index(0, line % ny, line / ny)]; };
  // A line writes its own number of runs.
#pragma omp parallel for schedule(static)
  for (int line = 0; line < lines; ++line) {
    int count = 0;
    for_each_run_in(line_of(line), nx, [&](int, int) { ++count; });
    system.first_run[line + 1] = count;
  }
  for (int line = 0; line < lines; ++line) system.first_run[line + 1] += system.first_run[line];
  system.runs.resize(system.first_run[lines]);
  // A line writes its own runs.
#pragma omp parallel for schedule(static)
  for (int line = 0; line < lines; ++line) {
    Run* run = system.runs.data() + system.first_run[line];
    for_each_run_in(line_of(line), nx, [&](int begin, int end) { *run++ = {begin, end}; });
  }
}

RunSum sum_run(const System<Real>& system, std::size_t first, int count) {
  const std::ptrdiff_t line = system.cells.line(), plane = system.cells.plane();
  maskv open = first_lanes(0);
  for (int k = 0; k < count; k += lanes) {
    const Real* const at = &system.diagonal[first + k];
    open |= first_lanes(count - k) & has_air_beside(load(at), {load(at - 1), load(at + 1), load(at - line),
                                                               load(at + line), load(at - plane), load(at + plane)});
  }
  RunSum sum = {any(open), 0};
  for (int k = 0; k < count; ++k) sum.right += system.right[first + k];
  return sum;
}

void balance_pockets(System<Real>& system) {
  const int lines = system.cells.ny * system.cells.nz;
  const auto for_each_run_of = [&](int line, const auto& f) {
    for_each_run_of_line(system, line % system.cells.ny, line / system.cells.ny, f);
  };
  std::vector<RunSum> sums(system.runs.size());
  // A run writes its own sum.
#pragma omp parallel for schedule(static)
  for (int line = 0; line < lines; ++line)
    for_each_run_of(line, [&](std::size_t first, int count, int run) { sums[run] = sum_run(system, first, count); });
  const Array<Real> means = means_of_pockets(system, sums);
  if (means.empty()) return;
    // A run changes its own cells.
#pragma omp parallel for schedule(static)
  for (int line = 0; line < lines; ++line)
    for_each_run_of(line, [&](std::size_t first, int count, int run) {
      for (int k = 0; k < count; ++k) system.right[first + k] -= means[run];
    });
}

}  // namespace

void make_system(const Fluid<Real>& fluid, System<Real>& system) {
  system.cells = {fluid.nx, fluid.ny, fluid.nz};
  system.open_top = fluid.open_top;
  system.diagonal.resize(system.cells.size()), system.right.resize(system.cells.size());
  system.air.resize(system.cells.size());
  const Lines<Real> lines(fluid);
  // A line writes its own elements; the lines of the border are among them.
#pragma omp parallel for collapse(2) schedule(static)
  for (int z = -1; z <= fluid.nz; ++z)
    for (int y = -1; y < fluid.ny; ++y) make_line(fluid, lines, y, z, system);
  const std::size_t behind = system.cells.index(0, -1, fluid.nz + 1);
  const auto clear_ends = [&](auto& array) {
    std::fill_n(array.begin(), Bordered::front, 0), std::fill(array.begin() + behind, array.end(), 0);
  };
  clear_ends(system.diagonal), clear_ends(system.right), clear_ends(system.air);
  find_runs(system);
  balance_pockets(system);
}

}  // namespace lockstep::production_fluid::openmp
