// Relaxation: every constraint enforced in turn, over and over, until all hold nearly enough. Gauss-Seidel, without a matrix.
//
// Sixteen constraints at once, without gathers: constraints that begin side by side in a row end side by side in a row, so both
// ends are loaded whole. Constraints along a row take 32 particles and split them into partners by one shuffle.
//
// Chains. Columns are independent lines: a thread takes whole columns, and lanes are neighbouring columns. Rows are columns of
// the transposed sheet, which is kept beside it. Diagonals are shared out line by line, so that a thread's part of a row moves on by one
// from row to row.
//
// Colours. All constraints of a half pass are independent, but a half pass at a time would stream the sheet through the cache twelve
// times an iteration: schedule.h turns them into one sweep down the rows, in bands.
//
// Batches. Whatever the constraints, those of a batch share no particle that moves; ends are gathered and scattered.
//
// Every constraint sees the particles as in serial/, so all forms have its bits, at every thread count.
//
// Source: [Jakobsen 2001] section 3; [LRB08] Figure 11. The contract stands in common/cloth/relax.h.
#include "common/cloth/relax.h"

#include <algorithm>

#include "common/cloth/project.h"
#include "common/real.h"
#include "common/simd.h"
#include "openmp/cloth/schedule.h"
#include "openmp/share.h"

namespace lockstep::cloth::openmp {
namespace {

using namespace lockstep::openmp;

// Where the particles of a sheet are: rows of `pitch`. Pointers of our own, so that stores to one array leave the others' known.
struct Rows {
  float *x, *y, *z;
  const float* w;
  int pitch;
};

Rows rows_of(Cloth<Real>& cloth) {
  Vectors<Real>& p = cloth.position;
  return {p.x.data(), p.y.data(), p.z.data(), cloth.inverse_mass.data(), cloth.sheet.pitch};
}

LOCKSTEP_INLINE Point<floatv> read(const Rows& p, int i) { return {load(p.x + i), load(p.y + i), load(p.z + i), load(p.w + i)}; }
LOCKSTEP_INLINE Point<floatv> read(const Rows& p, int i, maskv mask) {
  return {load(p.x + i, mask), load(p.y + i, mask), load(p.z + i, mask), load(p.w + i, mask)};
}
LOCKSTEP_INLINE void write(const Rows& p, int i, const Point<floatv>& v) { store(p.x + i, v.x), store(p.y + i, v.y), store(p.z + i, v.z); }
LOCKSTEP_INLINE void write(const Rows& p, int i, const Point<floatv>& v, maskv mask) {
  store(p.x + i, v.x, mask), store(p.y + i, v.y, mask), store(p.z + i, v.z, mask);
}

// n constraints between particles a, a + 1, ... and b, b + 1, ..., of different rows.
LOCKSTEP_INLINE void enforce_between(const Rows& p, int a, int b, int n, floatv rest_2) {
  int k = 0;
  for (; k + lanes <= n; k += lanes) {
    Point<floatv> pa = read(p, a + k), pb = read(p, b + k);
    project(pa, pb, rest_2);
    write(p, a + k, pa);
    write(p, b + k, pb);
  }
  if (k == n) return;
  const maskv inside = first_lanes(n - k);
  Point<floatv> pa = read(p, a + k, inside), pb = read(p, b + k, inside);
  project(pa, pb, rest_2);
  write(p, a + k, pa, inside);
  write(p, b + k, pb, inside);
}

// Enforces the constraints between partners G apart among 32 particles.
template <int G>
LOCKSTEP_INLINE void enforce_partners(Point<floatv>& low, Point<floatv>& high, floatv rest_2) {
  const Halves x = split<G>(low.x, high.x), y = split<G>(low.y, high.y), z = split<G>(low.z, high.z), w = split<G>(low.w, high.w);
  Point<floatv> a = {x.first, y.first, z.first, w.first}, b = {x.second, y.second, z.second, w.second};
  project(a, b, rest_2);
  join<G>({a.x, b.x}, low.x, high.x);
  join<G>({a.y, b.y}, low.y, high.y);
  join<G>({a.z, b.z}, low.z, high.z);
}

// The constraints of one colour along a row: particles first .. first + n - 1 in blocks of 2 G, each tied to its partner G further on.
template <int G>
LOCKSTEP_INLINE void enforce_along(const Rows& p, int first, int n, floatv rest_2) {
  int k = 0;
  for (; k + 2 * lanes <= n; k += 2 * lanes) {
    Point<floatv> low = read(p, first + k), high = read(p, first + k + lanes);
    enforce_partners<G>(low, high, rest_2);
    write(p, first + k, low);
    write(p, first + k + lanes, high);
  }
  if (k >= n) return;
  // Both of a pair must be there.
  const auto paired = [&](intv i) { return max(i, i ^ intv(G)) < n; };
  const maskv low_paired = paired(lane_index() + k), high_paired = paired(lane_index() + (k + lanes));
  Point<floatv> low = read(p, first + k, low_paired), high = read(p, first + k + lanes, high_paired);
  enforce_partners<G>(low, high, rest_2);
  write(p, first + k, low, low_paired);
  write(p, first + k + lanes, high, high_paired);
}

// Sixteen rows with lanes across them: element [16 c + i] is column c of row i. What is missing of the sixteen is padding.
struct Across {
  Array<float> x, y, z, w;

  explicit Across(int pitch) {
    for (Array<float>* array : {&x, &y, &z, &w}) array->resize(lanes * pitch);
  }
  Rows rows() { return {x.data(), y.data(), z.data(), w.data(), lanes}; }
};

LOCKSTEP_INLINE void transpose_in(const float* rows, int pitch, int n, float* across) {
  for (int c = 0; c < pitch; c += lanes) {
    floatv square[lanes];
    for (int i = 0; i < lanes; ++i) square[i] = i < n ? load(rows + i * pitch + c) : floatv(0.f);
    transpose(square);
    for (int i = 0; i < lanes; ++i) store(across + (c + i) * lanes, square[i]);
  }
}

LOCKSTEP_INLINE void transpose_out(const float* across, float* rows, int pitch, int n) {
  for (int c = 0; c < pitch; c += lanes) {
    floatv square[lanes];
    for (int i = 0; i < lanes; ++i) square[i] = load(across + (c + i) * lanes);
    transpose(square);
    for (int i = 0; i < n; ++i) store(rows + i * pitch + c, square[i]);
  }
}

// Both passes along n <= 16 rows, from `row` on, one row a lane. The second pass, two apart, follows the first by two columns: that is
// all it waits for, and the two chains hide some of each other's latency.
void enforce_chains_along(const Rows& p, const Sheet& sheet, int row, int n, floatv rest_2, bool bending, floatv bending_rest_2,
                          Across& across) {
  const int first = row * p.pitch;
  transpose_in(p.x + first, p.pitch, n, across.x.data());
  transpose_in(p.y + first, p.pitch, n, across.y.data());
  transpose_in(p.z + first, p.pitch, n, across.z.data());
  transpose_in(p.w + first, p.pitch, n, across.w.data());
  const Rows columns = across.rows();
  const auto enforce = [&](int c, int d, floatv rest_2) { enforce_between(columns, c * lanes, d * lanes, lanes, rest_2); };
  for (int c = 0; c + 1 < sheet.columns; ++c) {
    enforce(c, c + 1, rest_2);
    if (bending && c >= 2) enforce(c - 2, c, bending_rest_2);
  }
  if (bending && sheet.columns > 2) enforce(sheet.columns - 3, sheet.columns - 1, bending_rest_2);
  transpose_out(across.x.data(), p.x + first, p.pitch, n);
  transpose_out(across.y.data(), p.y + first, p.pitch, n);
  transpose_out(across.z.data(), p.z + first, p.pitch, n);
}

// The constraints of a family that begin in a row and end in another one.
LOCKSTEP_INLINE void enforce_row(const Rows& p, const Sheet& sheet, const Family<Real>& family, int row) {
  const auto [down, right, rest_2] = family;
  const int begin = std::max(0, -right), end = sheet.columns - std::max(0, right);
  enforce_between(p, sheet.index(row, begin), sheet.index(row + down, begin + right), end - begin, rest_2);
}

}  // namespace

void relax_chains(Cloth<Real>& cloth, int iterations) {
  const Sheet& sheet = cloth.sheet;
  const std::vector<Family<Real>>& families = cloth.families;
  const Rows p = rows_of(cloth);

  // Both passes along the rows are one, of sixteen rows at a time.
  Units units;
  Family<Real> along = {0, 0, 0}, along_bending = {0, 0, 0};
  for (int f = 0; f < static_cast<int>(families.size()); ++f) {
    const int down = families[f].down;
    if (down == 0) (families[f].right == 1 ? along : along_bending) = families[f];
    if (down == 0 && families[f].right == 1)
      for (int r = 0; r < sheet.rows; r += lanes) units.push_back({f, r, std::min(r + lanes, sheet.rows), 1});
    if (down > 0)
      for (int r = 0; r + down < sheet.rows; ++r) units.push_back({f, r, r + down + 1, down});
  }
  const std::vector<Units> stages = cut_into_stages(units, sheet.rows, 2 * omp_get_max_threads());
  const int bands = static_cast<int>(stages.size());

#pragma omp parallel
  {
    Across across(sheet.pitch);
    for (int stage = 0; stage < 2 * (iterations - 1) + bands; ++stage) {
      // Bands of one stage are two apart and share no row (schedule.h); the loop's barrier ends the stage.
#pragma omp for schedule(static, 1)
      for (int band = stage % 2; band < bands; band += 2) {
        if (band > stage || (stage - band) / 2 >= iterations) continue;
        for (const auto& [f, begin, end, step] : stages[band]) {
          if (families[f].down == 0)
            enforce_chains_along(p, sheet, begin, end - begin, along.rest_2, along_bending.right != 0, along_bending.rest_2, across);
          else
            enforce_row(p, sheet, families[f], begin);
        }
      }
    }
  }
}

void relax_colours(Cloth<Real>& cloth, int iterations) {
  const Sheet& sheet = cloth.sheet;
  const std::vector<Family<Real>>& families = cloth.families;
  const Rows p = rows_of(cloth);

  Units units;  // pass 2 f + colour is that colour of family f
  const int passes = 2 * static_cast<int>(families.size());
  for (int pass = 0; pass < passes; ++pass) {
    const int down = families[pass / 2].down, colour = pass % 2;
    for (int r = 0; r + down < sheet.rows; ++r)
      if (down == 0 || r / down % 2 == colour) units.push_back({pass, r, r + down + 1, std::max(down, 1)});
  }
  const Bands shared = cut_into_bands(units, sheet.rows, passes, omp_get_max_threads());
  const int bands = static_cast<int>(shared.bands.size());

  const auto enforce = [&](const Units& units) {
    for (const auto& [pass, r, end, step] : units) {
      const Family<Real>& family = families[pass / 2];
      const int colour = pass % 2;
      if (family.down > 0)
        enforce_row(p, sheet, family, r);
      else if (family.right == 1)
        enforce_along<1>(p, sheet.index(r, colour), sheet.columns - colour, family.rest_2);
      else
        enforce_along<2>(p, sheet.index(r, 2 * colour), sheet.columns - 2 * colour, family.rest_2);
    }
  };

#pragma omp parallel
  for (int iteration = 0; iteration < iterations; ++iteration) {
    // Bands share no row with one another, and seams none either; the barrier at the end of each loop keeps them apart.
#pragma omp for schedule(static, 1)
    for (int band = 0; band < bands; ++band) enforce(shared.bands[band]);
#pragma omp for schedule(static, 1)
    for (int seam = 0; seam < bands; ++seam) enforce(shared.seams[seam]);
  }
}

void relax_batches(Cloth<Real>& cloth, int iterations) {
  Vectors<Real>& p = cloth.position;
  const Constraints<Real>& list = cloth.batched;
  const std::int32_t *list_a = list.a.data(), *list_b = list.b.data();
  const float* const list_rest_2 = list.rest_2.data();
  const int batches = static_cast<int>(cloth.batch_begin.size()) - 1;
  Array<float> record_array(4 * padded(cloth.count));  // x, y, z and inverse mass of every particle side by side
  float* const records = record_array.data();

#pragma omp parallel
  {
    // Every record is one thread's; the loop's barrier ends it before any is read.
#pragma omp for schedule(static)
    for (int i = 0; i < cloth.count; ++i) {
      float* const r = records + 4 * i;
      r[0] = p.x[i], r[1] = p.y[i], r[2] = p.z[i], r[3] = cloth.inverse_mass[i];
    }

    for (int iteration = 0; iteration < iterations; ++iteration)
      for (int batch = 0; batch < batches; ++batch) {
        const int begin = cloth.batch_begin[batch], end = cloth.batch_begin[batch + 1];
        // The constraints of a batch share no particle that moves, and pinned ones are not written. The loop's barrier ends the batch.
#pragma omp for schedule(static)
        for (int k = begin; k < end; k += lanes) {
          // Lanes beyond the end read what the first lane reads, which no other thread writes.
          const maskv inside = first_lanes(end - k);
          alignas(array_alignment) std::int32_t index_a[lanes], index_b[lanes];
          store(index_a, select(inside, load(list_a + k), list_a[k]));
          store(index_b, select(inside, load(list_b + k), list_b[k]));
          const auto [ax, ay, az, aw] = load_quads(records, index_a).field;
          const auto [bx, by, bz, bw] = load_quads(records, index_b).field;
          Point<floatv> a = {ax, ay, az, aw}, b = {bx, by, bz, bw};
          project(a, b, load(list_rest_2 + k));
          store_quads(records, index_a, {{a.x, a.y, a.z, a.w}}, inside & (a.w > 0.f));
          store_quads(records, index_b, {{b.x, b.y, b.z, b.w}}, inside & (b.w > 0.f));
        }
      }

      // Every particle is one thread's.
#pragma omp for schedule(static)
    for (int i = 0; i < cloth.count; ++i) p.x[i] = records[4 * i], p.y[i] = records[4 * i + 1], p.z[i] = records[4 * i + 2];
  }
}

}  // namespace lockstep::cloth::openmp
