// The Fast Sweeping Method: Gauss-Seidel over the grid, in all eight directions.
//
// The distance comes to a point from nearer points. A sweep that goes along x, y and z as the distance grows brings it
// there in one go, however far; every straight path away from the interface fits one of the eight sweeps. There is no
// heap and no order to find, only loops; the price is that every point within reach of the band
// (common/levelset/reach.h) is visited eight times a round.
//
// In a sweep a point waits only for the three neighbours before it. Sixteen lines along x are worked on at once, one
// lane each, every one a step behind the line before (skewed.h). Such tiles wait for the tile before in their plane and
// the same tile of the plane before. Where threads are many, tiles are cut along the lines as well, and wait for the
// cut before. Threads share what lies on a diagonal of this grid: the wavefront of the sweep. Every point reads the
// same values as in a serial sweep, so the bits are the same.
//
// Source: [ITJ07] Figure 8; Zhao, Math. Comp. 74 (2005); Detrixhe, Gibou and Min, J. Comput. Phys. 237 (2013). The
// contract stands in common/levelset/fast_sweeping.h.
#include "common/levelset/fast_sweeping.h"

#include <omp.h>

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <optional>
#include <utility>
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

// A part of a run.
struct Piece {
  int tile, z;
  Extent vectors;
  int before = 0;  // how many vectors the pieces before it have

  int count() const { return vectors.end - vectors.begin; }
};

// A sweep's pieces, diagonal by diagonal. Those of a diagonal do not wait for one another.
struct Wavefront {
  std::vector<Piece> pieces;
  std::vector<int> first;  // [diagonal]: its first piece; and the number of all

  int diagonals() const { return static_cast<int>(first.size()) - 1; }
  int most_pieces() const {
    int largest = 0;
    for (int k = 0; k < diagonals(); ++k) largest = std::max(largest, first[k + 1] - first[k]);
    return largest;
  }
  // Threads share the vectors of a diagonal: a thread takes the pieces whose middle is in its share.
  int first_of(int diagonal, int thread, int threads) const {
    const auto begin = pieces.begin() + first[diagonal], end = pieces.begin() + first[diagonal + 1];
    if (begin == end) return first[diagonal];
    const long long start = begin->before, all = end[-1].before + end[-1].count() - start;
    const auto is_before = [&](const Piece& piece) {
      return (2 * (piece.before - start) + piece.count()) * threads < 2 * all * thread;
    };
    return static_cast<int>(std::partition_point(begin, end, is_before) - pieces.begin());
  }
};

// The wavefront of sweeps along x and y, and along z (step_z 1) or against it (-1). Lines are cut every `length`
// vectors, and runs with them, into pieces. A vector reads fifteen ahead in the tile before, so cut c of a tile waits
// for cuts c and c + 1 there. It is on diagonal 2 tile + z + c. Whole lines are on diagonal tile + z.
//
// The cuts of a plane are three for each thread. More of them are shared more evenly, fewer have longer lines, which
// the processor foresees better. The bits do not depend on it.
Wavefront make_wavefront(const Skewed& d, int step_z) {
  const int line = d.vectors_of_line(), even = line * d.tiles() / (3 * omp_get_max_threads()) / lanes * lanes;
  const int length = even < line ? std::max(even, 2 * lanes) : line, of_tile = length < line ? 2 : 1;
  const auto for_each_piece = [&](const auto& f) {
    for (int tile = 0; tile < d.tiles(); ++tile)
      for (int z = 0; z < d.planes(); ++z)
        for (const auto& [run_begin, run_end] : d.runs(tile, z))
          for (int begin = run_begin; begin < run_end;) {
            const int c = begin / length, end = std::min((c + 1) * length, run_end);
            f(of_tile * tile + (step_z > 0 ? z : d.planes() - 1 - z) + c, Piece{tile, z, {begin, end}});
            begin = end;
          }
  };
  Wavefront w;
  for_each_piece([&](int diagonal, const Piece&) {
    if (diagonal + 2 > static_cast<int>(w.first.size())) w.first.resize(diagonal + 2);
    ++w.first[diagonal + 1];
  });
  std::partial_sum(w.first.begin(), w.first.end(), w.first.begin());
  if (w.first.empty()) w.first = {0};
  w.pieces.resize(w.first.back());
  std::vector<int> next(w.first);
  for_each_piece([&](int diagonal, const Piece& piece) { w.pieces[next[diagonal]++] = piece; });
  int before = 0;
  for (Piece& piece : w.pieces) piece.before = std::exchange(before, before + piece.count());
  return w;
}

// A sweep along x and y (step 1), or against both and through the wavefront backwards (-1).
template <int step>
bool sweep(const Skewed& d, const Wavefront& wavefront, Real spacing, Real band) {
  const int last = wavefront.diagonals() - 1, most = wavefront.most_pieces();
  bool changed = false;
  Failure failure;
  // Each thread has a `changed` of its own; whether any is true is the same in any order.
#pragma omp parallel reduction(| : changed)
  {
    const int thread = omp_get_thread_num(), threads = omp_get_num_threads();
    std::vector<Cursor> cursors;
    failure.guard([&] { cursors.reserve(most); });
    // Behind this barrier all threads agree on whether one has failed.
#pragma omp barrier
    for (int k = failure.happened() ? last + 1 : 0; k <= last; ++k) {
      const int diagonal = step > 0 ? k : last - k;
      // Pieces wait only for those of the diagonal before, which the barrier below completes; none reads what another
      // of its diagonal writes.
      const int end = wavefront.first_of(diagonal, thread + 1, threads);
      for (int i = wavefront.first_of(diagonal, thread, threads); i < end; ++i) {
        const Piece& piece = wavefront.pieces[i];
        cursors.push_back(begin_run<step>(d, piece.tile, piece.z, piece.vectors));
      }
      changed |= sweep_runs<step>(cursors, spacing, band);
#pragma omp barrier
    }
  }
  failure.rethrow();
  return changed;
}

// A layout, and the wavefronts of its sweeps along z and against it.
struct Layout {
  Skewed skewed;
  Wavefront up, down;

  Layout(const Distances<Real>& distances, const Reach& reach, bool mirrored)
      : skewed(distances, reach, mirrored), up(make_wavefront(skewed, 1)), down(make_wavefront(skewed, -1)) {}
};

}  // namespace

int fast_sweeping_sweeps(Distances<Real>& distances, Real band, int rounds) {
  Failure failure;
  const Reach reach = make_reach(distances, band, [&](int planes, const auto& work_on) {
  // A call writes the data of its own plane alone, and reads what earlier loops completed.
#pragma omp parallel for schedule(static)
    for (int z = 0; z < planes; ++z) failure.guard([&] { work_on(z); });
    failure.rethrow();
  });
  std::optional<Layout> straight, mirrored;
#pragma omp parallel sections
  {
    // Each section makes its own object, and reads what no thread changes.
#pragma omp section
    failure.guard([&] { straight.emplace(distances, reach, false); });
#pragma omp section
    failure.guard([&] { mirrored.emplace(distances, reach, true); });
  }
  failure.rethrow();
  const LargePages memory(share(straight->skewed, mirrored->skewed));
  std::vector<float> lines(omp_get_max_threads() * straight->skewed.lines_to_take(), far<float>);
  for (Layout* layout : {&*straight, &*mirrored}) layout->skewed.place(memory.floats(), distances.interface);
  straight->skewed.begin(distances);

  // Backwards through a wavefront, a sweep goes against x and y, and the other way along z.
  const auto sweep_four_times = [&](const Layout& layout) {
    const auto& [d, up, down] = layout;
    bool changed = false;
    for (const Wavefront* w : {&up, &down}) changed |= sweep<1>(d, *w, distances.distance.spacing, band);
    for (const Wavefront* w : {&down, &up}) changed |= sweep<-1>(d, *w, distances.distance.spacing, band);
    return changed;
  };
  int round = 0;
  for (bool changed = true; changed && round < rounds; ++round) {
    if (round > 0) straight->skewed.take(mirrored->skewed, lines.data());
    changed = sweep_four_times(*straight);
    mirrored->skewed.take(straight->skewed, lines.data());
    changed |= sweep_four_times(*mirrored);
  }
  mirrored->skewed.write(distances.distance);
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
