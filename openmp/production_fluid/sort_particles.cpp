// Puts particles in the order of their blocks.
//
// Each thread counts the particles of its own share of each block. Counts of all blocks, of every thread, would be
// larger than the particles. But they were sorted before they moved, so a share lies in few lines of blocks, and no
// other line of counts is ever touched. Then the counts of lines that several threads have are added up, block after
// block and thread after thread, and each thread writes the indices of its own particles to their places. At last,
// particles are fetched by index. So one array is written out of order, not five: a processor waits for stores that
// miss its cache, while it runs ahead of loads that do. Lanes find the blocks, and write the particles.
//
// The contract stands in common/production_fluid/sort_particles.h.
#include "common/production_fluid/sort_particles.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "common/real.h"
#include "common/simd.h"
#include "common/simd_records.h"
#include "openmp/share.h"

namespace lockstep::production_fluid::openmp {
namespace {

using namespace lockstep::openmp;
using Index = intv;

// The block along one axis of sixteen coordinates.
intv block_along(const floatv& x, const Field<Real>& phi, int n) {
  return place<Index>(floatv(1 / phi.spacing) * x - floatv(.5f), n).first;
}

// Calls visit(particle, line of blocks, block) for the particles of a share.
template <class Visit>
void find_blocks(const Field<Real>& phi, const Particles<Real>& particles, const Share& mine, const Visit& visit) {
  const auto& [px, py, pz] = particles.position;
  for (int i = mine.begin; i < mine.end; i += lanes) {
    alignas(64) std::int32_t line[lanes], block[lanes];
    const intv of_line = block_along(load(&py[i]), phi, phi.ny) + phi.ny * block_along(load(&pz[i]), phi, phi.nz);
    store(line, of_line);
    store(block, block_along(load(&px[i]), phi, phi.nx) + phi.nx * of_line);
    for (int lane = 0; lane < std::min(lanes, mine.end - i); ++lane) visit(i + lane, line[lane], block[lane]);
  }
}

// Of each thread and block: how many of the thread's particles it has, and then where the next of them goes.
class Counts {
 public:
  // Allocates, so it is made outside of parallel regions.
  Counts(int threads, int lines, int blocks)
      : threads_(threads),
        lines_(lines),
        blocks_(blocks),
        counts_(std::make_unique_for_overwrite<std::int32_t[]>(std::size_t(threads) * lines * blocks)),
        has_line_(std::make_unique<std::uint8_t[]>(std::size_t(threads) * lines)),
        having_(std::size_t(threads) * threads) {}

  std::int32_t* of_thread(int thread) const { return of(thread, 0); }
  // Sets a line of a thread to 0 when it is first touched.
  void touch(int thread, int line) {
    std::uint8_t& has_line = has_line_[std::size_t(lines_) * thread + line];
    if (!has_line) has_line = 1, std::fill_n(of(thread, line), blocks_, 0);
  }
  // How many particles some lines have.
  std::int32_t of_lines(const Share& lines) const {
    std::int32_t sum = 0;
    for (int t = 0; t < threads_; ++t)
      for (int line = lines.begin; line < lines.end; ++line)
        if (has(t, line)) sum += std::accumulate(of(t, line), of(t, line) + blocks_, 0);
    return sum;
  }
  // Turns the counts of some lines, whose first particle goes to `begin`, into places: the particles of a block come in
  // the order of the threads. Says where blocks begin. `thread` is the one that calls.
  void turn_into_places(int thread, const Share& lines, std::int32_t begin, std::int32_t* first) {
    std::int32_t** const having = &having_[std::size_t(threads_) * thread];
    for (int line = lines.begin; line < lines.end; ++line) {
      int several = 0;
      for (int t = 0; t < threads_; ++t)
        if (has(t, line)) having[several++] = of(t, line);
      for (int x = 0; x < blocks_; ++x) {
        first[std::size_t(line) * blocks_ + x] = begin;
        for (int k = 0; k < several; ++k) begin += std::exchange(having[k][x], begin);
      }
    }
  }

 private:
  bool has(int thread, int line) const { return has_line_[std::size_t(lines_) * thread + line]; }
  std::int32_t* of(int thread, int line) const {
    return counts_.get() + (std::size_t(lines_) * thread + line) * blocks_;
  }

  int threads_, lines_, blocks_;
  std::unique_ptr<std::int32_t[]> counts_;    // [thread][line][x]
  std::unique_ptr<std::uint8_t[]> has_line_;  // [thread][line]
  std::vector<std::int32_t*> having_;         // for each thread, the counts of a line by all who have it
};

// Copies the particles that go to the places of a share. A share begins with a vector, so whole vectors are aligned and
// can be streamed.
void fetch_particles(const Particles<Real>& particles, const std::int32_t* origin, const Share& places,
                     Particles<Real>& sorted) {
  const Vectors<Real>& p = particles.position;
  Vectors<Real>& q = sorted.position;
  const Real* const from[] = {p.x.data(), p.y.data(), p.z.data(), particles.radius.data(), particles.sign.data()};
  Real* const to[] = {q.x.data(), q.y.data(), q.z.data(), sorted.radius.data(), sorted.sign.data()};
  const auto put = [&](int i, int place) {
    store(sorted.position, place, load(particles.position, i));
    sorted.radius[place] = particles.radius[i], sorted.sign[place] = particles.sign[i];
  };
  int place = places.begin;
  for (; place + lanes <= places.end; place += lanes)
    for (int k = 0; k < 5; ++k) stream(to[k] + place, load_each(from[k], origin + place));
  finish_streams();
  for (; place < places.end; ++place) put(origin[place], place);
}

}  // namespace

void sort_particles(const Field<Real>& phi, const Particles<Real>& particles, Particles<Real>& sorted) {
  const int blocks = phi.nx, lines = phi.ny * phi.nz;
  resize(sorted, particles.count);
  sorted.first.resize(std::size_t(lines) * blocks + 1);
  Counts counts(omp_get_max_threads(), lines, blocks);
  std::vector<std::int32_t> totals(omp_get_max_threads());
  const auto block = std::make_unique_for_overwrite<std::int32_t[]>(particles.count),
             origin = std::make_unique_for_overwrite<std::int32_t[]>(particles.count);
  // Each thread counts its own share of the particles and finds their places, which no other particle has. In between,
  // each adds up its own share of the lines; at the end each fills its own share of the places.
#pragma omp parallel
  {
    const int thread = omp_get_thread_num();
    const Share mine = my_share(particles.count), my_lines = my_share(lines);
    std::int32_t* const count = counts.of_thread(thread);
    find_blocks(phi, particles, mine, [&](int i, int line, int its_block) {
      block[i] = its_block;
      counts.touch(thread, line);
      ++count[its_block];
    });
    // From here on all threads read the counts.
#pragma omp barrier
    totals[thread] = counts.of_lines(my_lines);
    // From here on all threads read the totals, and counts become places.
#pragma omp barrier
    counts.turn_into_places(thread, my_lines, std::accumulate(totals.begin(), totals.begin() + thread, 0),
                            sorted.first.data());
    // From here on the places are complete.
#pragma omp barrier
    for (int i = mine.begin; i < mine.end; ++i) origin[count[block[i]]++] = i;
      // From here on all threads read where particles come from.
#pragma omp barrier
    fetch_particles(particles, origin.get(), mine, sorted);
  }
  sorted.first.back() = particles.count;
}

}  // namespace lockstep::production_fluid::openmp
