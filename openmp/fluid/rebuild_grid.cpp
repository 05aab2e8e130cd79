// Puts the particles in cell order, in two ways. Both give the stable order of serial/fluid/rebuild_grid.cpp, to the
// bit.
//
// Counting sort: the serial one, with the particles cut into parts, one a thread. A thread counts the particles of its
// part; the sums run over cells and, within a cell, over parts in order. So each thread knows where its particles of
// each cell go, and because parts are contiguous and taken in order the sort stays stable, whatever the number of
// threads. A part has a histogram of all cells: where cells are many and particles few there are fewer parts than
// threads, so that memory and work do not grow with threads x cells.
//
// Linked lists: the paper's. Threads push particles on per-cell lists, each under its cell's lock. The order within a
// list depends on timing. So each cell's few particles are sorted into their incoming order when its list is emptied,
// and the result does not depend on timing.
//
// Source: [LRB08] "Thread Synchronization and software locks". The contract stands in common/fluid/rebuild_grid.h.
#include "common/fluid/rebuild_grid.h"

#include <algorithm>
#include <utility>

#include "common/fluid/limits.h"
#include "common/real.h"
#include "common/simd.h"
#include "openmp/fluid/lanes.h"
#include "openmp/share.h"

namespace lockstep::fluid::openmp {
namespace {

using namespace lockstep::openmp;

// The cells of particles i .. i + 15. Lanes beyond the last particle answer some cell of the grid.
intv cell_of(const Grid<Real>& grid, const Vectors<Real>& position, int i) {
  return cell_of(grid, lanes_at(position, i));
}

// Calls visit(i, cell of i) for the particles of a share, whose cells are computed some vectors at a time.
template <class Visit>
void for_each_cell(const Grid<Real>& grid, const Vectors<Real>& position, const Share& share, const Visit& visit) {
  constexpr int chunk = 64 * lanes;
  alignas(array_alignment) std::int32_t cell[chunk];
  for (int first = share.begin; first < share.end; first += chunk) {
    const int last = std::min(first + chunk, share.end);
    for (int i = first; i < last; i += lanes) store(cell + (i - first), cell_of(grid, position, i));
    for (int i = first; i < last; ++i) visit(i, cell[i - first]);
  }
}

// sorted[k] = old[from[k]]
template <class T>
void fetch(const Array<T>& old, const std::int32_t* from, const Share& mine, Array<T>& sorted) {
  const T* const src = old.data();
  T* const dst = sorted.data();
  for (int k = mine.begin; k < mine.end; ++k) dst[k] = src[from[k]];
}

void fetch(const Vectors<Real>& old, const std::int32_t* from, const Share& mine, Vectors<Real>& sorted) {
  fetch(old.x, from, mine, sorted.x);
  fetch(old.y, from, mine, sorted.y);
  fetch(old.z, from, mine, sorted.z);
}

}  // namespace

void rebuild_grid_counting_sort(Grid<Real>& grid, Particles<Real>& particles, Particles<Real>& sorted) {
  std::int32_t* const from = sorted.id.data();  // from[k]: where particle k comes from; until the ids go there
  const double histograms = histogram_entries(particles.count, grid.cells()) / grid.cells();
  const int most_parts = static_cast<int>(std::min<double>(omp_get_max_threads(), histograms));
  std::vector<Array<std::int32_t>> next(most_parts);  // next[t][c] is the next free place of cell c for part t
  for (Array<std::int32_t>& histogram : next) histogram.reserve(grid.cells());  // the parallel region must not throw
  std::vector<std::int32_t> total(omp_get_max_threads() + 1);

  // Thread t writes next[t], its own share of total and cell_begin, and places of `sorted` that are its alone;
  // the barriers stand between one thread's writing and another's reading.
#pragma omp parallel
  {
    const int thread = omp_get_thread_num(), threads = omp_get_num_threads(), parts = std::min(threads, most_parts);
    const Share mine = my_share(particles.count), cells = my_share(grid.cells());
    const Share part = thread < parts ? share(particles.count, thread, parts) : Share{0, 0};
    if (thread < parts) next[thread].assign(grid.cells(), 0);
    std::int32_t* const my_next = thread < parts ? next[thread].data() : nullptr;
    for_each_cell(grid, particles.position, part, [&](int, std::int32_t cell) { ++my_next[cell]; });
#pragma omp barrier

    // The sums within this thread's share of the cells, then what stands before that share.
    std::int32_t sum = 0;
    for (int c = cells.begin; c < cells.end; ++c)
      for (int t = 0; t < parts; ++t) sum += std::exchange(next[t][c], sum);
    total[thread + 1] = sum;
#pragma omp barrier
#pragma omp single
    for (int t = 0; t < threads; ++t) total[t + 1] += total[t];

    for (int c = cells.begin; c < cells.end; ++c) {
      for (int t = 0; t < parts; ++t) next[t][c] += total[thread];
      grid.cell_begin[c] = next[0][c];
    }
#pragma omp barrier

    for_each_cell(grid, particles.position, part, [&](int i, std::int32_t cell) { from[my_next[cell]++] = i; });
#pragma omp barrier

    fetch(particles.position, from, mine, sorted.position);
    fetch(particles.half_velocity, from, mine, sorted.half_velocity);
    fetch(particles.velocity, from, mine, sorted.velocity);
    for (int k = mine.begin; k < mine.end; ++k) sorted.id[k] = particles.id[from[k]];
  }
  grid.cell_begin[grid.cells()] = particles.count;
  std::swap(particles, sorted);
}

void rebuild_grid_linked_lists(Grid<Real>& grid, Particles<Real>& particles, Particles<Real>& sorted) {
  constexpr std::int32_t none = -1;
  Array<std::int32_t> cell(padded(particles.count)), next(particles.count), order(particles.count);
  Array<std::int32_t> head(grid.cells(), none);
  Locks locks(grid.cells());
  std::fill(grid.cell_begin.begin(), grid.cell_begin.end(), 0);

  // A particle's cell is its own; head and count of a cell are guarded by the cell's lock.
#pragma omp parallel for schedule(static)
  for (int vector = 0; vector < (particles.count + lanes - 1) / lanes; ++vector) {
    const int first = vector * lanes, last = std::min(first + lanes, particles.count);
    store(&cell[first], cell_of(grid, particles.position, first));
    for (int i = first; i < last; ++i) {
      locks.acquire(cell[i]);
      next[i] = std::exchange(head[cell[i]], i);
      ++grid.cell_begin[cell[i] + 1];
      locks.release(cell[i]);
    }
  }
  for (int c = 0; c < grid.cells(); ++c) grid.cell_begin[c + 1] += grid.cell_begin[c];

    // Each cell empties its own list into its own run.
#pragma omp parallel for schedule(static)
  for (int c = 0; c < grid.cells(); ++c) {
    const int begin = grid.cell_begin[c], end = grid.cell_begin[c + 1];
    int k = begin;
    for (int i = head[c]; i != none; i = next[i]) order[k++] = i;
    std::sort(order.begin() + begin, order.begin() + end);
    for (k = begin; k < end; ++k) copy_particle(particles, order[k], sorted, k);
  }
  std::swap(particles, sorted);
}

}  // namespace lockstep::fluid::openmp
