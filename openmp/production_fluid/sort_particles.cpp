// Puts particles in the order of their blocks.
//
// Counts of all blocks, of every thread, would be larger than the particles. So threads first sort by the line of the
// block, together; then each line is one thread's, who sorts it by x.
//
// The contract stands in common/production_fluid/sort_particles.h.
#include "common/production_fluid/sort_particles.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "common/real.h"
#include "common/simd.h"
#include "openmp/counting_sort.h"
#include "openmp/failure.h"
#include "openmp/share.h"

namespace lockstep::production_fluid::openmp {
namespace {

using namespace lockstep::openmp;
using Index = intv;

// Where particles are: in which line of blocks, and where in it.
struct Places {
  Array<std::int32_t> line, x;

  explicit Places(int count) : line(padded(count)), x(padded(count)) {}
};

void find_places(const Field<Real>& phi, const Particles<Real>& particles, int begin, int end, Places& places) {
  const Real per_spacing = 1 / phi.spacing;
  const auto& [px, py, pz] = particles.position;
  for (int i = begin; i < end; i += lanes) {
    const auto block = [per_spacing](const Array<Real>& p, int k, int n) {
      return place<Index>(floatv(per_spacing) * load(&p[k]) - floatv(.5f), n).first;
    };
    const maskv mine = first_lanes(end - i);
    store(&places.x[i], block(px, i, phi.nx), mine);
    store(&places.line[i], block(py, i, phi.ny) + phi.ny * block(pz, i, phi.nz), mine);
  }
}

// Sorts particles order[begin], ..., order[end - 1], those of a line, into places begin .. end - 1. `next` has room for
// the blocks of a line and one more.
void sort_line(const Particles<Real>& particles, const Places& places, const std::int32_t* order, int begin, int end,
               int blocks, std::int32_t* next, std::int32_t* first, Particles<Real>& sorted) {
  std::fill_n(next, blocks, 0);
  for (int k = begin; k < end; ++k) ++next[places.x[order[k]]];
  std::int32_t sum = begin;
  for (int block = 0; block < blocks; ++block) sum += std::exchange(next[block], sum);
  std::copy_n(next, blocks, first);
  for (int k = begin; k < end; ++k) {
    const int i = order[k], to = next[places.x[i]]++;
    store(sorted.position, to, load(particles.position, i));
    sorted.radius[to] = particles.radius[i], sorted.sign[to] = particles.sign[i];
  }
}

}  // namespace

void sort_particles(const Field<Real>& phi, const Particles<Real>& particles, Particles<Real>& sorted) {
  const int count = particles.count, blocks = phi.nx, lines = phi.ny * phi.nz;
  resize(sorted, count);
  sorted.first.resize(std::size_t(lines) * blocks + 1);
  Places places(count);
  Array<std::int32_t> order(padded(count)), begin(lines + 1);
  CountingSort sort(lines);
  Failure failure;
  // Each thread sorts its own share of the particles by line (openmp/counting_sort.h); then each line is an iteration,
  // which alone writes the line's particles.
#pragma omp parallel
  {
    std::unique_ptr<std::int32_t[]> next;
    failure.guard([&] { next = std::make_unique_for_overwrite<std::int32_t[]>(blocks); });
    const Share mine = my_share(count);
    find_places(phi, particles, mine.begin, mine.end, places);
    sort(
        [&](const auto& visit) {
          for (int i = mine.begin; i < mine.end; ++i) visit(i, places.line[i]);
        },
        [&](int i, int place) { order[place] = i; }, begin.data());
    // Behind this barrier, order and begin are complete.
#pragma omp barrier
    if (!failure.happened()) {
#pragma omp for schedule(dynamic, 32)
      for (int line = 0; line < lines; ++line)
        sort_line(particles, places, order.data(), begin[line], begin[line + 1], blocks, next.get(),
                  &sorted.first[std::size_t(line) * blocks], sorted);
    }
  }
  failure.rethrow();
  sorted.first.back() = count;
}

}  // namespace lockstep::production_fluid::openmp
