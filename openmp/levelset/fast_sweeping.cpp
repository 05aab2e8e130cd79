// The Fast Sweeping Method: Gauss-Seidel over the grid, in all eight directions.
//
// The distance comes to a point from nearer points. A sweep that goes along x, y and z as the distance grows brings it there in one
// go, however far; of the eight ways to go, one fits every straight path away from the interface. No heap, no order to find out,
// only loops; the price is that every point within reach of the band (common/levelset/reach.h) is visited eight times.
//
// In a sweep a point waits for the three neighbours before it alone. Sixteen lines along x are worked on at once, one lane each, every
// one a step behind the line before (skewed.h); such tiles wait for the tile before in their plane and the same tile of the plane before,
// so threads share the tiles on a diagonal. Every point finds what it finds in a serial sweep, so the bits are the same.
//
// Source: [ITJ07] Figure 8; Zhao, Math. Comp. 74 (2005); Detrixhe, Gibou and Min, J. Comput. Phys. 237 (2013). The contract stands in
// common/levelset/fast_sweeping.h.
#include "common/levelset/fast_sweeping.h"

#include <omp.h>
#include <sys/mman.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <new>
#include <optional>
#include <vector>

#include "common/levelset/blocks.h"
#include "common/levelset/eikonal.h"
#include "common/levelset/reach.h"
#include "common/real.h"
#include "common/simd.h"
#include "openmp/levelset/skewed.h"

namespace lockstep::levelset::openmp {
namespace {

// A run of vectors being swept, and where the sweep is: the vector itself, those of the planes before and after, and the outer
// neighbours along y of the first lane (last lane of the tile before, fifteen vectors ahead) and of the last lane.
struct Strand {
  float* here;
  const float *up, *down, *outer_first, *outer_last;
  const std::uint16_t* standing;
  int left;                // vectors to go
  floatv before, current;  // the vector done last, and the one at `here`
};

template <int step>
LOCKSTEP_INLINE Strand begin_strand(const Skewed& d, int tile, int z, const Extent& run) {
  constexpr int aside = lanes - 1;
  const int t = step > 0 ? run.begin : run.end - 1;
  float* const here = d.vector(tile, z, t);
  return {here,
          d.vector(tile, z - 1, t),
          d.vector(tile, z + 1, t),
          d.vector(tile - 1, z, t + aside) + aside,
          d.vector(tile + 1, z, t - aside),
          d.standing(tile, z, t),
          run.end - run.begin,
          load(here - step * lanes),
          load(here)};
}

// Sweeps sixteen points, n vectors on; says which came nearer.
template <int step>
LOCKSTEP_INLINE maskv advance(Strand& s, int n, floatv spacing, floatv band) {
  const std::ptrdiff_t on = std::ptrdiff_t(n) * step * lanes;
  const floatv after = load(s.here + on + step * lanes);
  const floatv low = step > 0 ? s.before : after, high = step > 0 ? after : s.before;
  const floatv a = min(low, high);
  const floatv b = min(shift_up(low, s.outer_first[on]), shift_down(high, s.outer_last[on]));
  const floatv c = min(load(s.up + on), load(s.down + on));
  const floatv u = upwind(a, b, c, spacing);
  const maskv nearer = (u < s.current) & (u <= band) & ~lanes_of(s.standing[n * step]);
  s.before = select(nearer, u, s.current);
  store(s.here + on, s.before);
  s.current = after;
  return nearer;
}

// Moves on by n vectors, which are done.
template <int step>
void move_on(Strand& s, int n) {
  const std::ptrdiff_t on = std::ptrdiff_t(n) * step * lanes;
  s.here += on, s.up += on, s.down += on, s.outer_first += on, s.outer_last += on;
  s.standing += n * step;
  s.left -= n;
}

// Sweeps the last `count` strands side by side until one of them ends, and takes those that end away.
template <int step, int count>
maskv sweep_together(std::vector<Strand>& strands, floatv spacing, floatv band) {
  maskv changed = first_lanes(0);
  Strand s[count];
  std::copy(strands.end() - count, strands.end(), s);
  strands.resize(strands.size() - count);
  const auto shorter = [](const Strand& a, const Strand& b) { return a.left < b.left; };
  const int together = std::min_element(s, s + count, shorter)->left;
  for (int n = 0; n < together; ++n)
    for (Strand& strand : s) changed = changed | advance<step>(strand, n, spacing, band);
  for (Strand& strand : s) {
    move_on<step>(strand, together);
    if (strand.left > 0) strands.push_back(strand);
  }
  return changed;
}

// Sweeps strands that do not wait for one another; says whether anything came nearer. A vector waits for the one before it, for as long
// as an upwind solution takes; four strands at once fill that time.
template <int step>
bool sweep_strands(std::vector<Strand>& strands, floatv spacing, floatv band) {
  maskv changed = first_lanes(0);
  while (!strands.empty()) switch (strands.size()) {
      case 1: changed = changed | sweep_together<step, 1>(strands, spacing, band); break;
      case 2: changed = changed | sweep_together<step, 2>(strands, spacing, band); break;
      case 3: changed = changed | sweep_together<step, 3>(strands, spacing, band); break;
      default: changed = changed | sweep_together<step, 4>(strands, spacing, band);
    }
  return any(changed);
}

// One sweep, along x and y (step 1) or against both (-1).
template <int step>
bool sweep(const Skewed& d, Real spacing, Real band, int step_z) {
  const int tiles = d.tiles(), planes = d.planes();
  bool changed = false;
#pragma omp parallel reduction(| : changed)
  {
    const int thread = omp_get_thread_num(), threads = omp_get_num_threads();
    std::vector<Strand> strands;
    for (int diagonal = 0; diagonal < tiles + planes - 1; ++diagonal) {
      const int begin = std::max(0, diagonal - planes + 1), end = std::min(tiles, diagonal + 1);
      const auto tile = [&](int i) { return step > 0 ? i : tiles - 1 - i; };
      const auto plane = [&](int i) { return step_z > 0 ? diagonal - i : planes - 1 - (diagonal - i); };
      // Tiles of a diagonal wait for tiles of the diagonal before alone, which the barrier ends; none reads what another writes. In a
      // band many are empty, so each thread takes its share of the vectors: the tiles whose middle lies in it.
      long long all = 0, before = 0;
      for (int i = begin; i < end; ++i) all += d.vectors(tile(i), plane(i));
      for (int i = begin; i < end; ++i) {
        const int own = d.vectors(tile(i), plane(i));
        if ((2 * before + own) * threads / (2 * all + 1) == thread)
          for (const Extent& run : d.runs(tile(i), plane(i))) strands.push_back(begin_strand<step>(d, tile(i), plane(i), run));
        before += own;
      }
      changed |= sweep_strands<step>(strands, spacing, band);
#pragma omp barrier
    }
  }
  return changed;
}

// Room for floats, in large pages where it is large, for by ordinary pages a grid of 256^3 waited longer for them than all sweeps take.
class Memory {
 public:
  explicit Memory(std::size_t floats) {
    constexpr std::size_t large_page = 2 << 20;
    const std::size_t bytes = (floats * sizeof(float) + large_page) / large_page * large_page;
    memory_ = std::aligned_alloc(large_page, bytes);
    if (!memory_) throw std::bad_alloc();
    madvise(memory_, bytes, MADV_HUGEPAGE);
  }
  ~Memory() { std::free(memory_); }
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  float* floats() const { return static_cast<float*>(memory_); }

 private:
  void* memory_;
};

}  // namespace

int fast_sweeping_sweeps(Distances<Real>& distances, Real band, int rounds) {
  const Reach reach = make_reach(distances, band, [](int planes, const auto& work_on) {
  // A plane writes what is its own alone.
#pragma omp parallel for schedule(static)
    for (int z = 0; z < planes; ++z) work_on(z);
  });
  std::optional<Skewed> straight, mirrored;
#pragma omp parallel sections
  {
    // Each is made from what nobody changes.
#pragma omp section
    straight.emplace(distances, reach, false);
#pragma omp section
    mirrored.emplace(distances, reach, true);
  }
  const Memory memory(std::max(straight->size(), mirrored->size()));
  for (int round = 1; round <= rounds; ++round) {
    bool changed = false;
    for (Skewed* d : {&*straight, &*mirrored}) {
      d->take(distances.distance, memory.floats());
      for (const int z : {1, -1}) changed |= sweep<1>(*d, distances.distance.spacing, band, z);
      for (const int z : {1, -1}) changed |= sweep<-1>(*d, distances.distance.spacing, band, z);
      d->give_back(distances.distance);
    }
    if (!changed) return round;
  }
  return rounds;
}

int fast_sweeping_blocks(Distances<Real>& distances, Real band, int rounds, int size) {
  const std::vector<Block> blocks = make_blocks(distances, band, size);
  const int count = static_cast<int>(blocks.size());
  int most = 0;
  // A block reads interface points, which nobody changes, and writes its own points alone. Blocks differ in work, hence dynamic.
#pragma omp parallel for schedule(dynamic) reduction(max : most)
  for (int b = 0; b < count; ++b) {
    const Block& block = blocks[b];
    Distances<Real> padded = cut_out(distances, block);
    most = std::max(most, fast_sweeping_sweeps(padded, band, rounds));  // by this thread alone: parallel regions do not nest
    put_back(padded, block, distances);
  }
  return most;
}

}  // namespace lockstep::levelset::openmp
