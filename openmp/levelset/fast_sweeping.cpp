// The Fast Sweeping Method: Gauss-Seidel over the grid, in all eight directions.
//
// The distance comes to a point from nearer points. A sweep that goes along x, y and z as the distance grows brings it
// there in one go, however far; every straight path away from the interface fits one of the eight sweeps. There is no
// heap and no order to find, only loops; the price is that every point within reach of the band
// (common/levelset/reach.h) is visited eight times a round.
//
// In a sweep a point waits only for the three neighbours before it. Sixteen lines along x are worked on at once, one
// lane each, every one a step behind the line before (skewed.h). Such tiles wait for the tile before in their plane and
// the same tile of the plane before, so threads share the tiles on a diagonal of the (tile, plane) grid: the wavefront
// of the sweep. Every point reads the same values as in a serial sweep, so the bits are the same.
//
// Source: [ITJ07] Figure 8; Zhao, Math. Comp. 74 (2005); Detrixhe, Gibou and Min, J. Comput. Phys. 237 (2013). The
// contract stands in common/levelset/fast_sweeping.h.
#include "common/levelset/fast_sweeping.h"

#include <omp.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "common/levelset/blocks.h"
#include "common/levelset/eikonal.h"
#include "common/levelset/reach.h"
#include "common/real.h"
#include "common/simd.h"
#include "openmp/failure.h"
#include "openmp/large_pages.h"
#include "openmp/levelset/skewed.h"

namespace lockstep::levelset::openmp {
namespace {

using namespace lockstep::openmp;

// Where the sweep of a run of vectors is: the vector itself, those of the planes before and after, and the outer
// neighbours along y of the first lane (last lane of the tile before, fifteen vectors ahead) and of the last lane.
struct Cursor {
  float* here;
  const float *up, *down, *outer_first, *outer_last;
  const std::uint16_t* fixed;
  int left;                // vectors to go
  floatv before, current;  // the vector done last, and the one at `here`
};

template <int step>
LOCKSTEP_INLINE Cursor begin_run(const Skewed& d, int tile, int z, const Extent& run) {
  constexpr int aside = lanes - 1;
  const int t = step > 0 ? run.begin : run.end - 1;
  float* const here = d.vector(tile, z, t);
  return {here,
          d.vector(tile, z - 1, t),
          d.vector(tile, z + 1, t),
          d.vector(tile - 1, z, t + aside) + aside,
          d.vector(tile + 1, z, t - aside),
          d.fixed(tile, z, t),
          run.end - run.begin,
          load(here - step * lanes),
          load(here)};
}

// Updates the sixteen points n vectors ahead of the cursor; returns which of them came nearer.
template <int step>
LOCKSTEP_INLINE maskv advance(Cursor& s, int n, floatv spacing, floatv band) {
  const std::ptrdiff_t on = std::ptrdiff_t(n) * step * lanes;
  const floatv after = load(s.here + on + step * lanes);
  const floatv low = step > 0 ? s.before : after, high = step > 0 ? after : s.before;
  const floatv a = min(low, high);
  const floatv b = min(shift_up(low, s.outer_first[on]), shift_down(high, s.outer_last[on]));
  const floatv c = min(load(s.up + on), load(s.down + on));
  const floatv u = upwind(a, b, c, spacing);
  const maskv nearer = (u < s.current) & (u <= band) & ~lanes_of(s.fixed[n * step]);
  s.before = select(nearer, u, s.current);
  store(s.here + on, s.before);
  s.current = after;
  return nearer;
}

// Moves on by n vectors, which are done.
template <int step>
void move_on(Cursor& s, int n) {
  const std::ptrdiff_t on = std::ptrdiff_t(n) * step * lanes;
  s.here += on, s.up += on, s.down += on, s.outer_first += on, s.outer_last += on;
  s.fixed += n * step;
  s.left -= n;
}

// Advances the last `count` cursors together until one run ends, and removes the cursors of runs that have ended.
template <int step, int count>
maskv sweep_together(std::vector<Cursor>& cursors, floatv spacing, floatv band) {
  maskv changed = first_lanes(0);
  Cursor s[count];
  std::copy(cursors.end() - count, cursors.end(), s);
  cursors.resize(cursors.size() - count);
  const auto shorter = [](const Cursor& a, const Cursor& b) { return a.left < b.left; };
  const int together = std::min_element(s, s + count, shorter)->left;
  for (int n = 0; n < together; ++n)
    for (Cursor& cursor : s) changed = changed | advance<step>(cursor, n, spacing, band);
  for (Cursor& cursor : s) {
    move_on<step>(cursor, together);
    if (cursor.left > 0) cursors.push_back(cursor);
  }
  return changed;
}

// Sweeps runs that do not wait for one another; says whether anything came nearer. A vector waits for the one before
// it, for as long as an upwind solution takes: four runs at once hide that latency.
template <int step>
bool sweep_runs(std::vector<Cursor>& cursors, floatv spacing, floatv band) {
  maskv changed = first_lanes(0);
  while (!cursors.empty()) switch (cursors.size()) {
      case 1: changed = changed | sweep_together<step, 1>(cursors, spacing, band); break;
      case 2: changed = changed | sweep_together<step, 2>(cursors, spacing, band); break;
      case 3: changed = changed | sweep_together<step, 3>(cursors, spacing, band); break;
      default: changed = changed | sweep_together<step, 4>(cursors, spacing, band);
    }
  return any(changed);
}

// One sweep, along x and y (step 1) or against both (-1).
template <int step>
bool sweep(const Skewed& d, Real spacing, Real band, int step_z) {
  const int tiles = d.tiles(), planes = d.planes();
  bool changed = false;
  Failure failure;
  // Each thread has a `changed` of its own; whether any is true is the same in any order.
#pragma omp parallel reduction(| : changed)
  {
    const int thread = omp_get_thread_num(), threads = omp_get_num_threads();
    std::vector<Cursor> cursors;
    failure.guard([&] { cursors.reserve(d.most_runs()); });
    // Behind this barrier all threads agree on whether one has failed.
#pragma omp barrier
    const int diagonals = failure.happened() ? 0 : tiles + planes - 1;
    for (int diagonal = 0; diagonal < diagonals; ++diagonal) {
      const int begin = std::max(0, diagonal - planes + 1), end = std::min(tiles, diagonal + 1);
      const auto tile = [&](int i) { return step > 0 ? i : tiles - 1 - i; };
      const auto plane = [&](int i) { return step_z > 0 ? diagonal - i : planes - 1 - (diagonal - i); };
      // Tiles of a diagonal wait only for tiles of the diagonal before, which the barrier below completes; none reads
      // what another of its diagonal writes. In a band many tiles are empty, so threads share vectors: a thread takes
      // the tiles whose middle vector is in its share.
      long long all = 0, before = 0;
      for (int i = begin; i < end; ++i) all += d.vectors(tile(i), plane(i));
      for (int i = begin; i < end; ++i) {
        const int own = d.vectors(tile(i), plane(i));
        if ((2 * before + own) * threads / (2 * all + 1) == thread)
          for (const Extent& run : d.runs(tile(i), plane(i)))
            cursors.push_back(begin_run<step>(d, tile(i), plane(i), run));
        before += own;
      }
      changed |= sweep_runs<step>(cursors, spacing, band);
#pragma omp barrier
    }
  }
  failure.rethrow();
  return changed;
}

}  // namespace

int fast_sweeping_sweeps(Distances<Real>& distances, Real band, int rounds) {
  Failure failure;
  const Reach reach = make_reach(distances, band, [&](int planes, const auto& work_on) {
  // A call writes the data of its own plane alone, and reads what earlier loops completed.
#pragma omp parallel for schedule(static)
    for (int z = 0; z < planes; ++z) failure.guard([&] { work_on(z); });
    failure.rethrow();
  });
  std::optional<Skewed> straight, mirrored;
#pragma omp parallel sections
  {
    // Each section makes its own object, and reads what no thread changes.
#pragma omp section
    failure.guard([&] { straight.emplace(distances, reach, false); });
#pragma omp section
    failure.guard([&] { mirrored.emplace(distances, reach, true); });
  }
  failure.rethrow();
  const LargePages memory(share(*straight, *mirrored));
  std::vector<float> lines(omp_get_max_threads() * straight->lines_to_take(), far<float>);
  for (Skewed* d : {&*straight, &*mirrored}) d->place(memory.floats(), distances.interface);
  straight->begin(distances);

  const auto sweep_four_times = [&](const Skewed& d) {
    bool changed = false;
    for (const int z : {1, -1}) changed |= sweep<1>(d, distances.distance.spacing, band, z);
    for (const int z : {1, -1}) changed |= sweep<-1>(d, distances.distance.spacing, band, z);
    return changed;
  };
  int round = 0;
  for (bool changed = true; changed && round < rounds; ++round) {
    if (round > 0) straight->take(*mirrored, lines.data());
    changed = sweep_four_times(*straight);
    mirrored->take(*straight, lines.data());
    changed |= sweep_four_times(*mirrored);
  }
  mirrored->write(distances.distance);
  return round;
}

int fast_sweeping_blocks(Distances<Real>& distances, Real band, int rounds, int size) {
  Failure failure;
  std::vector<Block> blocks = make_blocks(distances, band, size, [&](int n, const auto& pick) {
  // A block picks its own points from those of the interface, which no thread changes.
#pragma omp parallel for schedule(dynamic)
    for (int b = 0; b < n; ++b) failure.guard([&] { pick(b); });
    failure.rethrow();
  });
  // The largest first: one begun late would keep all other threads waiting. The order changes no result.
  std::sort(blocks.begin(), blocks.end(),
            [](const Block& a, const Block& b) { return a.interface.size() > b.interface.size(); });
  const int count = static_cast<int>(blocks.size());
  int most = 0;
#pragma omp parallel reduction(max : most)
  {
    omp_set_num_threads(
        1);  // for the regions that this thread opens: it sweeps its blocks alone, also where regions nest
    // A block reads interface points, which no thread changes, and writes its own points alone. Each thread has a
    // `most` of its own. Blocks differ in work, hence dynamic.
#pragma omp for schedule(dynamic)
    for (int b = 0; b < count; ++b)
      failure.guard([&] {
        const Block& block = blocks[b];
        Distances<Real> padded = cut_out(distances, block);
        most = std::max(most, fast_sweeping_sweeps(padded, band, rounds));
        put_back(padded, block, distances);
      });
  }
  failure.rethrow();
  return most;
}

}  // namespace lockstep::levelset::openmp
