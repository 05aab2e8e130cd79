// Puts the particles in cell order, in two ways. Both give the stable order of serial/fluid/rebuild_grid.cpp, to the
// bit.
//
// Counting sort: the serial one, with the particles cut into parts, one a thread. A thread counts the particles of its
// part; the sums run over cells and, within a cell, over parts in order. So each thread knows where its particles of
// each cell go, and because parts are contiguous and taken in order the sort stays stable, whatever the number of
// threads. A part's histogram goes from its lowest cell to its highest. Particles come in the cell order of the frame
// before, and few cross more than a cell in a frame. So a part stays near its own planes of cells, and all histograms
// together are little longer than one of all cells. In any other order each may be as long as that. Where together they
// are longer than histogram_entries allows, there are fewer parts than threads, so that memory and work do not grow
// with threads x cells.
//
// Linked lists: the paper's. Threads push particles on per-cell lists, each under its cell's lock. The order within a
// list depends on timing. So each cell's few particles are sorted into their incoming order when its list is emptied,
// and the result does not depend on timing.
//
// Source: [LRB08] "Thread Synchronization and software locks". The contract stands in common/fluid/rebuild_grid.h.
#include "common/fluid/rebuild_grid.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "common/fluid/limits.h"
#include "common/real.h"
#include "common/simd.h"
#include "openmp/failure.h"
#include "openmp/share.h"
#include "openmp/vector_lanes.h"

namespace lockstep::fluid::openmp {
namespace {

using namespace lockstep::openmp;

// The cells of particles i .. i + 15. Lanes beyond the last particle answer some cell of the grid.
intv cell_of(const Grid<Real>& grid, const Vectors<Real>& position, int i) {
  return cell_of(grid, load(pointers(position), i));
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

// One thread's particles, the cells from their lowest to their highest, and an entry for each of these cells: how many
// of the particles it holds; then, where the next of them goes.
struct Part {
  Share particles = {0, 0}, cells = {0, 0};
  Array<std::int32_t> next;

  int entries() const { return cells.end - cells.begin; }
};

void take(const Grid<Real>& grid, const Vectors<Real>& position, const Share& particles, Part& part) {
  alignas(array_alignment) std::int32_t low[lanes], high[lanes];
  intv lowest = grid.cells(), highest = -1;
  for (int i = particles.begin; i < particles.end; i += lanes) {
    const maskv inside = first_lanes(particles.end - i);
    const intv cell = cell_of(grid, position, i);
    lowest = select(inside, min(lowest, cell), lowest);
    highest = select(inside, max(highest, cell), highest);
  }
  store(low, lowest), store(high, highest);
  const int end = *std::max_element(high, high + lanes) + 1;
  part.particles = particles;
  part.cells = {std::min(*std::min_element(low, low + lanes), end), end};
}

// Calls visit(c, entry of c) for those of `cells` for which the part has an entry.
template <class Visit>
void for_each_entry(Part& part, const Share& cells, const Visit& visit) {
  std::int32_t* const next = part.next.data();
  const int first = part.cells.begin, end = std::min(part.cells.end, cells.end);
  for (int c = std::max(first, cells.begin); c < end; ++c) visit(c, next[c - first]);
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
  std::int32_t* const cell_begin = grid.cell_begin.data();
  const double most_entries = histogram_entries(particles.count, grid.cells());
  std::vector<Part> parts(omp_get_max_threads());
  std::vector<std::int32_t> total(omp_get_max_threads());
  Failure failure;

  // Thread t writes parts[t], total[t], its own share of cell_begin, of all parts the entries of the cells of that
  // share, and places of `sorted` that are its alone; the barriers stand between one thread's writing and another's
  // reading.
#pragma omp parallel
  {
    const int thread = omp_get_thread_num(), threads = omp_get_num_threads();
    const Share mine = my_share(particles.count), cells = my_share(grid.cells());
    Part& part = parts[thread];
    take(grid, particles.position, mine, part);
#pragma omp barrier

    // The same in every thread: all go through the same barriers. None changes its part before all have read it.
    double entries = 0;
    for (int t = 0; t < threads; ++t) entries += parts[t].entries();
    if (entries > most_entries) {
      const int fewer = static_cast<int>(most_entries / grid.cells());
#pragma omp barrier
      take(grid, particles.position, thread < fewer ? share(particles.count, thread, fewer) : Share{0, 0}, part);
    }
    failure.guard([&] { part.next.assign(part.entries(), 0); });
    std::int32_t* const my_next = part.next.data();
    const int first = part.cells.begin;
    if (!part.next.empty())
      for_each_cell(grid, particles.position, part.particles, [&](int, std::int32_t cell) { ++my_next[cell - first]; });
#pragma omp barrier

    if (!failure.happened()) {
      // How many particles are in this thread's share of the cells.
      std::int32_t in_share = 0;
      for (int t = 0; t < threads; ++t)
        for_each_entry(parts[t], cells, [&](int, std::int32_t next) { in_share += next; });
      total[thread] = in_share;
#pragma omp barrier

      // Of each part its begin within its cell; then the begins of the cells; then both together.
      std::fill(cell_begin + cells.begin, cell_begin + cells.end, 0);
      for (int t = 0; t < threads; ++t)
        for_each_entry(parts[t], cells, [&](int c, std::int32_t& next) {
          const std::int32_t before = cell_begin[c];
          cell_begin[c] += next;
          next = before;
        });
      std::int32_t sum = std::accumulate(total.begin(), total.begin() + thread, 0);
      for (int c = cells.begin; c < cells.end; ++c) sum += std::exchange(cell_begin[c], sum);
      for (int t = 0; t < threads; ++t)
        for_each_entry(parts[t], cells, [&](int c, std::int32_t& next) { next += cell_begin[c]; });
#pragma omp barrier

      for_each_cell(grid, particles.position, part.particles,
                    [&](int i, std::int32_t cell) { from[my_next[cell - first]++] = i; });
#pragma omp barrier

      fetch(particles.position, from, mine, sorted.position);
      fetch(particles.half_velocity, from, mine, sorted.half_velocity);
      fetch(particles.velocity, from, mine, sorted.velocity);
      for (int k = mine.begin; k < mine.end; ++k) sorted.id[k] = particles.id[from[k]];
    }
  }
  failure.rethrow();
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
