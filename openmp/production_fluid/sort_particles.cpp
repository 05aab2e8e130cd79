// Puts particles in the order of their blocks.
//
// Counts of all blocks, of every thread, would be larger than the particles. So threads first sort by the line of the
// block, together; then each line is one thread's, who sorts it by x. Lanes find the blocks.
//
// The contract stands in common/production_fluid/sort_particles.h.
#include "common/production_fluid/sort_particles.h"

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "common/real.h"
#include "common/simd.h"
#include "openmp/counting_sort.h"
#include "openmp/failure.h"
#include "openmp/share.h"

namespace lockstep::production_fluid::openmp {
namespace {

using namespace lockstep::openmp;
using Index = intv;

// The block along one axis of sixteen coordinates.
intv block_along(const floatv& x, const Field<Real>& phi, int n) {
  return place<Index>(floatv(1 / phi.spacing) * x - floatv(.5f), n).first;
}

// Calls visit(particle, line of blocks) for particles begin .. end - 1.
template <class Visit>
void for_each_line_of(const Field<Real>& phi, const Particles<Real>& particles, int begin, int end,
                      const Visit& visit) {
  const auto& [px, py, pz] = particles.position;
  for (int i = begin; i < end; i += lanes) {
    alignas(64) std::int32_t line[lanes];
    store(line, block_along(load(&py[i]), phi, phi.ny) + phi.ny * block_along(load(&pz[i]), phi, phi.nz));
    for (int lane = 0; lane < std::min(lanes, end - i); ++lane) visit(i + lane, line[lane]);
  }
}

// What a thread needs to sort a line; it grows with the longest.
struct Scratch {
  Array<Real> at;                   // where along x each particle is, m
  Array<std::int32_t> block, rank;  // each particle's block, and how many of that block come before it
  Array<std::int32_t> from;         // which particle comes first, second, ...
  std::vector<std::int32_t> begin;  // where each block begins

  void make_room(int count, int blocks) {
    if (from.size() < padded(count)) {
      at.resize(padded(count));
      for (Array<std::int32_t>* array : {&block, &rank, &from}) array->resize(padded(count));
    }
    begin.assign(blocks, 0);
  }
};

// Sorts particles order[0], ..., order[count - 1], those of a line, by x, into places begin .. begin + count - 1. Only
// while it counts does a particle wait for the one before it.
void sort_line(const Field<Real>& phi, const Particles<Real>& particles, const std::int32_t* order, int begin,
               int count, Scratch& scratch, std::int32_t* first, Particles<Real>& sorted) {
  scratch.make_room(count, phi.nx);
  Real* const at = scratch.at.data();
  std::int32_t *const block = scratch.block.data(), *const rank = scratch.rank.data(),
                      *const from = scratch.from.data(), *const next = scratch.begin.data();
  for (int k = 0; k < count; ++k) at[k] = particles.position.x[order[k]];
  for (int k = 0; k < count; k += lanes) store(block + k, block_along(load(at + k), phi, phi.nx));
  for (int k = 0; k < count; ++k) rank[k] = next[block[k]]++;
  std::int32_t sum = 0;
  for (int x = 0; x < phi.nx; ++x) {
    first[x] = begin + sum;
    sum += std::exchange(next[x], sum);
  }
  for (int k = 0; k < count; ++k) from[next[block[k]] + rank[k]] = order[k];
  for (int k = 0; k < count; ++k) {
    const int i = from[k], place = begin + k;
    store(sorted.position, place, load(particles.position, i));
    sorted.radius[place] = particles.radius[i], sorted.sign[place] = particles.sign[i];
  }
}

}  // namespace

void sort_particles(const Field<Real>& phi, const Particles<Real>& particles, Particles<Real>& sorted) {
  const int count = particles.count, blocks = phi.nx, lines = phi.ny * phi.nz;
  resize(sorted, count);
  sorted.first.resize(std::size_t(lines) * blocks + 1);
  const auto order = std::make_unique_for_overwrite<std::int32_t[]>(padded(count));
  Array<std::int32_t> begin(lines + 1);
  CountingSort sort(lines);
  Failure failure;
  // Each thread sorts its own share of the particles by line (openmp/counting_sort.h); then each line is an iteration,
  // which alone writes the line's particles.
#pragma omp parallel
  {
    const Share mine = my_share(count);
    sort([&](const auto& visit) { for_each_line_of(phi, particles, mine.begin, mine.end, visit); },
         [&](int i, int place) { order[place] = i; }, begin.data());
    Scratch scratch;
    // Behind this barrier, order and begin are complete.
#pragma omp barrier
#pragma omp for schedule(dynamic, 32)
    for (int line = 0; line < lines; ++line)
      failure.guard([&] {
        sort_line(phi, particles, &order[begin[line]], begin[line], begin[line + 1] - begin[line], scratch,
                  &sorted.first[std::size_t(line) * blocks], sorted);
      });
  }
  failure.rethrow();
  sorted.first.back() = count;
}

}  // namespace lockstep::production_fluid::openmp
