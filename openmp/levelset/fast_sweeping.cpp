// The Fast Sweeping Method: Gauss-Seidel over the grid, in all eight directions.
//
// The distance comes to a point from nearer points. A sweep that goes along x, y and z as the distance grows brings it
// there in one go, however far; every straight path away from the interface fits one of the eight sweeps. There is no
// heap and no order to find, only loops; the price is that every point within reach of the band
// (common/levelset/reach.h) is visited eight times a round.
//
// In a sweep a point waits only for the three neighbours before it. Sixteen lines along x are worked on at once, one
// lane each, every one a step behind the line before (skewed.h). Threads take slabs of a few planes in turn. In a slab,
// planes are worked on side by side, each a window of vectors behind the one before. A slab waits for the one before it
// by a flag (common/flags.h), window by window. Every point reads the same values as in a serial sweep, so the bits
// are the same. How thick slabs and how long windows are follows the number of threads.
//
// Source: [ITJ07] Figure 8; Zhao, Math. Comp. 74 (2005); Detrixhe, Gibou and Min, J. Comput. Phys. 237 (2013). The
// contract stands in common/levelset/fast_sweeping.h.
#include "common/levelset/fast_sweeping.h"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "common/flags.h"
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

// Runs that do not wait for one another, worked on side by side. A vector waits for the one before it, for as long as
// an upwind solution takes: four runs at once hide that latency.
template <int step>
class Strands {
 public:
  Strands(floatv spacing, floatv band) : spacing_(spacing), band_(band) {}

  void add(const Cursor& run) {
    run_[count_++] = run;
    if (count_ == most) together<most>();
  }
  void finish() {
    while (count_ > 0) switch (count_) {
        case 1: together<1>(); break;
        case 2: together<2>(); break;
        default: together<3>();
      }
  }
  bool changed() const { return any(changed_); }  // whether anything came nearer

 private:
  static constexpr int most = 4;

  // Advances `count` runs, all that there are, until one ends, and removes those that have ended.
  template <int count>
  void together() {
    Cursor s[count];
    std::copy(run_, run_ + count, s);
    maskv changed = changed_;
    const auto shorter = [](const Cursor& a, const Cursor& b) { return a.left < b.left; };
    const int vectors = std::min_element(s, s + count, shorter)->left;
    for (int n = 0; n < vectors; ++n)
      for (Cursor& cursor : s) changed = changed | advance<step>(cursor, n, spacing_, band_);
    changed_ = changed;
    count_ = 0;
    for (Cursor& cursor : s) {
      move_on<step>(cursor, vectors);
      if (cursor.left > 0) run_[count_++] = cursor;
    }
  }

  floatv spacing_, band_;
  maskv changed_ = first_lanes(0);
  Cursor run_[most];
  int count_ = 0;
};

// Lines are cut into windows of vectors. A sweep goes through those of a plane tile by tile, and counts them.
struct Windows {
  int tiles, length, of_line;

  // `least` windows a plane, if none is so short that the tile before is read more than one window ahead.
  Windows(const Skewed& d, int least) : tiles(d.tiles()) {
    const int line = d.vectors_of_line(), cuts = std::clamp((least + tiles - 1) / tiles, 1, line / lanes);
    length = (line + cuts - 1) / cuts;
    of_line = (line + length - 1) / length;
  }
  int count() const { return tiles * of_line; }
};

// A walk through the runs of a plane in the order of a sweep, a piece at a time: what is in one window of a run.
template <int step>
class Walk {
 public:
  Walk() = default;
  Walk(const Skewed& d, const Windows& windows, int z) : z_(z), tile_(step > 0 ? 0 : windows.tiles - 1) {
    runs_ = d.runs(tile_, z);
    find(d, windows);
  }
  // The window of the piece, as the sweep counts them; `never` at the end.
  int window() const { return window_; }
  static constexpr int never = 1 << 30;
  Cursor begin(const Skewed& d) const { return begin_run<step>(d, tile_, z_, piece_); }
  void move_on(const Skewed& d, const Windows& windows) {
    (step > 0 ? run_.begin : run_.end) = step > 0 ? piece_.end : piece_.begin;
    find(d, windows);
  }

 private:
  void find(const Skewed& d, const Windows& windows) {
    while (run_.begin == run_.end) {
      while (runs_.empty()) {
        tile_ += step;
        if (tile_ < 0 || tile_ == windows.tiles) {
          window_ = never;
          return;
        }
        runs_ = d.runs(tile_, z_);
      }
      run_ = step > 0 ? runs_.front() : runs_.back();
      runs_ = step > 0 ? runs_.subspan(1) : runs_.first(runs_.size() - 1);
    }
    const int cut = (step > 0 ? run_.begin : run_.end - 1) / windows.length;
    piece_ = {std::max(run_.begin, cut * windows.length), std::min(run_.end, (cut + 1) * windows.length)};
    window_ = tile_ * windows.of_line + cut;
    if (step < 0) window_ = windows.count() - 1 - window_;
  }

  int z_ = 0, tile_ = 0, window_ = 0;
  std::span<const Extent> runs_;  // of the tile, after this one
  Extent run_ = {0, 0}, piece_ = {0, 0};
};

// Planes side by side, and how far sweeps have come in the last of them: in how many windows, of all sweeps.
constexpr int most_planes = 8;
struct Slab {
  Extent planes;
  const Flag* before;  // of the slab before in the sweep, if there is one
  Flag* mine;
};

// Sweeps a slab. Each plane is a window behind the one before it, so what the planes do at a time is independent: a
// piece waits for windows of its plane that are done, tile before included, and for its window in the plane before. The
// first plane finds that in the slab before, by its flag. It waits only where it has a piece. Before its last sweep,
// which went the other way along z, the slab after waited likewise; so it has read what this sweep overwrites.
template <int step>
bool sweep_slab(const Skewed& d, const Windows& windows, const Slab& slab, int step_z, int base, floatv spacing,
                floatv band) {
  const int n = slab.planes.end - slab.planes.begin;
  Walk<step> walks[most_planes];
  for (int i = 0; i < n; ++i) walks[i] = {d, windows, step_z > 0 ? slab.planes.begin + i : slab.planes.end - 1 - i};
  Strands<step> strands(spacing, band);
  const int end = windows.count();
  for (;;) {
    post(*slab.mine, base + std::min(walks[n - 1].window(), end));
    int k = Walk<step>::never;
    for (int i = 0; i < n; ++i) k = std::min(k, walks[i].window() + i);
    if (k == Walk<step>::never) return strands.changed();
    if (slab.before && walks[0].window() == k) await(*slab.before, base + k + 1);
    for (int i = 0; i < n; ++i)
      for (Walk<step>& walk = walks[i]; walk.window() + i == k; walk.move_on(d, windows)) strands.add(walk.begin(d));
    strands.finish();
  }
}

}  // namespace

int fast_sweeping_sweeps(Distances<Real>& distances, Real band, int rounds) {
  const auto for_each = [](int n, const auto& f) {
    Failure failure;
    // A call writes the data of its own plane alone, and reads what earlier loops completed.
#pragma omp parallel for schedule(static)
    for (int i = 0; i < n; ++i) failure.guard([&] { f(i); });
    failure.rethrow();
  };
  const Reach reach = make_reach(distances, band, for_each);
  Skewed straight(distances, reach, false, for_each), mirrored(distances, reach, true, for_each);
  const std::size_t floats = share(straight, mirrored),
                    of_thread = (straight.lines_to_take() + lanes - 1) / lanes * lanes;
  const LargePages memory(floats + omp_get_max_threads() * of_thread);
  for (Skewed* d : {&straight, &mirrored}) d->place(memory.floats());
  const int nz = straight.planes();
  std::vector<Flag> flags(nz);        // [slab]
  std::atomic<int> last_change = -1;  // the last round in which a thread changed something
  // A thread writes planes of its own slabs alone. Flags guard the planes beside them within four sweeps, barriers
  // before and after a layout takes over. Behind the last barrier of a round all threads read the same last_change, or
  // that of a later round, and go on together.
#pragma omp parallel
  {
    const int thread = omp_get_thread_num(), threads = omp_get_num_threads();
    const int thickness = std::clamp(nz / (4 * threads), 2, most_planes), slabs = (nz + thickness - 1) / thickness;
    const Windows windows(straight, 3 * (threads - 1) * thickness);
    float* const lines = memory.floats() + floats + thread * of_thread;
    std::fill(lines, lines + of_thread, far<float>);
    const auto for_each_plane = [&](const auto& f) {
      for (int slab = thread; slab < slabs; slab += threads)
        for (int z = slab * thickness; z < std::min((slab + 1) * thickness, nz); ++z) f(z);
    };
    for_each_plane([&](int z) {
      straight.find_fixed(distances.interface, z);
      mirrored.find_fixed(distances.interface, z);
      straight.begin(distances, z);
    });
    int sweeps = 0;
    const auto sweep_four_times = [&](const Skewed& d) {
      bool changed = false;
      for (int i = 0; i < 4; ++i, ++sweeps) {
        const int step_z = i % 2 == 0 ? 1 : -1, mine = (slabs - thread + threads - 1) / threads;
        for (int j = 0; j < mine; ++j) {
          const int s = thread + (step_z > 0 ? j : mine - 1 - j) * threads;
          const int before = s - step_z;
          const Slab slab{{s * thickness, std::min((s + 1) * thickness, nz)},
                          before >= 0 && before < slabs ? &flags[before] : nullptr,
                          &flags[s]};
          const int base = sweeps * windows.count();
          const Real spacing = distances.distance.spacing;
          changed |= i < 2 ? sweep_slab<1>(d, windows, slab, step_z, base, spacing, band)
                           : sweep_slab<-1>(d, windows, slab, step_z, base, spacing, band);
        }
      }
      return changed;
    };
    for (int round = 0; round < rounds; ++round) {
      if (round > 0) for_each_plane([&](int z) { straight.take(mirrored, z, lines); });
#pragma omp barrier
      bool changed = sweep_four_times(straight);
#pragma omp barrier
      for_each_plane([&](int z) { mirrored.take(straight, z, lines); });
#pragma omp barrier
      changed |= sweep_four_times(mirrored);
      if (changed) last_change.store(round);
#pragma omp barrier
      if (last_change.load() < round) break;
    }
    for_each_plane([&](int z) { mirrored.write(distances.distance, z); });
  }
  return std::min(rounds, last_change.load() + 2);
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
