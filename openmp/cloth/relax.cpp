// Relaxation: every constraint is projected in turn, iteration after iteration. Gauss-Seidel, without a matrix.
//
// Sixteen constraints at once. On a sheet there are no gathers: both ends of sixteen constraints are loaded whole
// (row_lanes.h).
//
// Chains. Columns are independent lines: lanes are neighbouring columns. Rows are columns of the transposed sheet,
// sixteen of which are transposed at a time (across.h). Threads take stages down the sheet (schedule.h), where
// iterations follow one another.
//
// Colours. All constraints of a half pass are independent, but a half pass at a time would stream the sheet through the
// cache twelve times an iteration: schedule.h turns them into one sweep down the rows, in bands.
//
// Batches. The constraints of a batch, of a sheet or a mesh, share no particle that moves. Particles are loaded and
// stored as records.
//
// Every constraint sees the particles as in serial/, so all forms have its bits, at every thread count.
//
// Source: [Jakobsen 2001] section 3; [LRB08] Figure 11. The contract stands in common/cloth/relax.h.
#include "common/cloth/relax.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "common/cloth/project.h"
#include "common/real.h"
#include "common/simd.h"
#include "openmp/cloth/across.h"
#include "openmp/cloth/row_lanes.h"
#include "openmp/cloth/schedule.h"
#include "openmp/share.h"

namespace lockstep::cloth::openmp {

void relax_chains(Cloth<Real>& cloth, int iterations) {
  const Sheet& sheet = cloth.sheet;
  const std::vector<Family<Real>>& families = cloth.families;
  const Rows rows = rows_of(cloth);

  // Both passes along the rows are one, of sixteen rows at a time.
  Units units;
  AlongRows along;
  for (int f = 0; f < static_cast<int>(families.size()); ++f) {
    const int down = families[f].down;
    if (down == 0) (families[f].right == 1 ? along.next : along.bending) = families[f];
    if (down == 0 && families[f].right == 1)
      for (int r = 0; r < sheet.rows; r += lanes) units.push_back({f, r, std::min(r + lanes, sheet.rows), 1});
    if (down > 0)
      for (int r = 0; r + down < sheet.rows; ++r) units.push_back({f, r, r + down + 1, down});
  }
  const std::vector<Units> stages = cut_into_stages(units, sheet.rows, 2 * omp_get_max_threads());
  const int bands = static_cast<int>(stages.size());
  std::vector<Across> across((bands + 1) / 2, Across(sheet.pitch));  // bands of one stage are two apart

#pragma omp parallel
  for (int stage = 0; stage < 2 * (iterations - 1) + bands; ++stage) {
    // Bands of one stage share no row (schedule.h), and each has room of its own; the loop's barrier ends the stage.
#pragma omp for schedule(static, 1)
    for (int band = stage % 2; band < bands; band += 2) {
      if (band > stage || (stage - band) / 2 >= iterations) continue;
      for (const auto& [f, begin, end, step] : stages[band]) {
        if (families[f].down == 0)
          enforce_chains_along(rows, sheet, begin, end - begin, along, across[band / 2]);
        else
          enforce_row(rows, sheet, families[f], begin);
      }
    }
  }
}

namespace {

// The bands of a sheet's colours: pass 2 f + colour is that colour of family f. They depend on nothing but the
// arguments. The calling thread keeps its last ones from call to call, for one thread makes them while all others wait.
const Bands& bands_of_colours(int rows, const std::vector<Family<Real>>& families, int threads) {
  struct Kept {
    int rows = 0, threads = 0;
    std::vector<int> downs;  // [family]
    Bands bands;
  };
  thread_local Kept kept;
  std::vector<int> downs;
  for (const Family<Real>& family : families) downs.push_back(family.down);
  if (kept.rows == rows && kept.threads == threads && kept.downs == downs) return kept.bands;

  Units units;
  int period = 1;  // rows
  for (const int down : downs) period = std::lcm(period, 2 * std::max(down, 1));
  for (int pass = 0; pass < 2 * static_cast<int>(families.size()); ++pass) {
    const int down = downs[pass / 2], colour = pass % 2;
    for (int r = 0; r + down < rows; ++r)
      if (down == 0 || r / down % 2 == colour) units.push_back({pass, r, r + down + 1, std::max(down, 1)});
  }
  Bands bands = cut_into_bands(units, rows, period, threads);
  kept = {rows, threads, std::move(downs), std::move(bands)};
  return kept.bands;
}

}  // namespace

void relax_colours(Cloth<Real>& cloth, int iterations) {
  const Sheet& sheet = cloth.sheet;
  const std::vector<Family<Real>>& families = cloth.families;
  const Rows rows = rows_of(cloth);
  const Bands& shared = bands_of_colours(sheet.rows, families, omp_get_max_threads());
  const int bands = static_cast<int>(shared.bands.size());

  const auto enforce = [&](const Units& units) {
    for (const auto& [pass, r, end, step] : units) {
      const Family<Real>& family = families[pass / 2];
      const int colour = pass % 2;
      if (family.down > 0)
        enforce_row(rows, sheet, family, r);
      else if (family.right == 1)
        enforce_along<1>(rows, sheet.index(r, colour), sheet.columns - colour, family.rest_2);
      else
        enforce_along<2>(rows, sheet.index(r, 2 * colour), sheet.columns - 2 * colour, family.rest_2);
    }
  };

#pragma omp parallel
  for (int iteration = 0; iteration < iterations; ++iteration) {
    // Bands share no row with one another, nor do seams; the barrier at the end of each loop keeps the two apart.
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
    // Every record is one thread's; the barrier at the loop's end precedes all reads of records.
#pragma omp for schedule(static)
    for (int i = 0; i < cloth.count; ++i) {
      float* const r = records + 4 * i;
      r[0] = p.x[i], r[1] = p.y[i], r[2] = p.z[i], r[3] = cloth.inverse_mass[i];
    }

    for (int iteration = 0; iteration < iterations; ++iteration)
      for (int batch = 0; batch < batches; ++batch) {
        const int begin = cloth.batch_begin[batch], end = cloth.batch_begin[batch + 1];
        // The constraints of a batch share no particle that moves, and pinned ones are not written. The loop's barrier
        // ends the batch.
#pragma omp for schedule(static)
        for (int k = begin; k < end; k += lanes) {
          // Lanes beyond the end read what the first lane reads, which no other thread writes.
          const maskv inside = first_lanes(end - k);
          std::int32_t few_a[lanes], few_b[lanes];
          const std::int32_t *of_a = list_a + k, *of_b = list_b + k;
          if (end - k < lanes) {
            store(few_a, select(inside, load(of_a), *of_a)), store(few_b, select(inside, load(of_b), *of_b));
            of_a = few_a, of_b = few_b;
          }
          const auto [ax, ay, az, aw] = load_quads(records, of_a).field;
          const auto [bx, by, bz, bw] = load_quads(records, of_b).field;
          Point<floatv> a = {ax, ay, az, aw}, b = {bx, by, bz, bw};
          project(a, b, load(list_rest_2 + k));
          store_quads(records, of_a, {{a.x, a.y, a.z, a.w}}, inside & (a.w > 0.f));
          store_quads(records, of_b, {{b.x, b.y, b.z, b.w}}, inside & (b.w > 0.f));
        }
      }

      // Every particle is one thread's.
#pragma omp for schedule(static)
    for (int i = 0; i < cloth.count; ++i)
      p.x[i] = records[4 * i], p.y[i] = records[4 * i + 1], p.z[i] = records[4 * i + 2];
  }
}

}  // namespace lockstep::cloth::openmp
