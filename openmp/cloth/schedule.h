// The passes of an iteration as one wavefront down the sheet, and how threads share it.
//
// Pass by pass, the whole sheet would stream through the first-level cache a dozen times an iteration. But a pass on a
// row depends only on earlier passes on the same rows. So one sweep goes down the rows, and every unit of every pass
// runs as soon as the rows that it depends on are done: only a dozen rows are in use at a time. Every row sees the
// passes in their order, so the result has the bits of going pass by pass.
//
// No serial twin: a serial loop takes pass after pass.
#pragma once

#include <algorithm>
#include <numeric>
#include <vector>

namespace lockstep::cloth::openmp {

// The constraints of one pass that begin in one row, or in a few. It touches rows begin, begin + step, ... before end,
// and no others.
struct Unit {
  int pass, begin, end, step;
};
using Units = std::vector<Unit>;

// Row r is in band k where cut[k] <= r < cut[k + 1].
inline std::vector<int> cut_rows(int rows, int bands) {
  std::vector<int> cut;
  for (int band = 0; band <= bands; ++band)
    cut.push_back(static_cast<int>(static_cast<long long>(rows) * band / bands));
  return cut;
}
inline int band_of(const std::vector<int>& cut, int row) {
  return static_cast<int>(std::upper_bound(cut.begin(), cut.end(), row) - cut.begin()) - 1;
}

// For units in the order of their passes: the row that the sweep must have reached when each of them is done.
inline std::vector<int> rows_reached(const Units& units, int rows) {
  std::vector<int> reached(rows, 0), times;
  times.reserve(units.size());
  for (const auto& [pass, begin, end, step] : units) {
    int time = end - 1;
    for (int r = begin; r < end; r += step) time = std::max(time, reached[r]);
    for (int r = begin; r < end; r += step) reached[r] = time;
    times.push_back(time);
  }
  return times;
}

// The units in the order of the sweep: by counting, which keeps the order of the passes among units of one time.
inline Units in_sweep_order(const Units& units, int rows) {
  const std::vector<int> times = rows_reached(units, rows);
  std::vector<int> next(rows + 1, 0);
  for (const int time : times) ++next[time + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  Units sweep(units.size());
  for (std::size_t u = 0; u < units.size(); ++u) sweep[next[times[u]]++] = units[u];
  return sweep;
}

// The rows that wait around a cut: first what crosses it, then what later passes do on those rows.
struct Seam {
  int begin, end;  // rows begin .. end - 1
  int height() const { return end - begin; }
};
inline Seam seam_around(int cut, const Units& units, int rows) {
  Seam seam = {cut, cut};
  std::vector<char> held_up(rows, false);
  for (const auto& [pass, begin, end, step] : units) {
    bool waits = begin < cut && cut < end;
    for (int r = begin; r < end; r += step) waits |= held_up[r];
    if (!waits) continue;
    for (int r = begin; r < end; r += step) held_up[r] = true;
    seam = {std::min(seam.begin, begin), std::max(seam.end, end)};
  }
  return seam;
}

// For passes whose units touch different rows each: every thread sweeps a band of rows of its own. First, in all bands
// at once, comes what needs no row beyond the band; then what is left, the seams around the cuts. Each pass makes a
// seam wider by the rows that one of its units spans, or not at all where no unit reaches beyond the seam.
struct Bands {
  std::vector<Units> bands;  // in order each; no two bands touch the same row
  std::vector<Units> seams;  // after all bands; in order each, and no two seams touch the same row
};

// Units repeat every `period` rows. There are at most `most_bands` bands, and no more than leave each seam its rows.
inline Bands cut_into_bands(const Units& units, int rows, int period, int most_bands) {
  // Where in the period a cut is decides how high its seam is.
  int best = rows / 2;
  Seam least = seam_around(best, units, rows);
  for (int cut = best + 1; cut < std::min(best + period, rows); ++cut)
    if (const Seam seam = seam_around(cut, units, rows); seam.height() < least.height()) best = cut, least = seam;
  const int place = best % period, apart = std::max((least.height() + period - 1) / period, 1) * period;
  const int bands = std::clamp(rows / apart, 1, most_bands);
  std::vector<int> cut = cut_rows(rows, bands);
  for (int k = 1; k < bands; ++k) cut[k] = cut[k] / period * period + place;

  Bands shared{.bands = std::vector<Units>(bands), .seams = std::vector<Units>(bands)};
  constexpr int none = -1;
  std::vector<int> held_up_by(rows, none);  // [row]: the seam that an earlier unit on it is left to
  for (const Unit& unit : units) {
    const auto [pass, begin, end, step] = unit;
    const int band = band_of(cut, begin);
    int seam = band != band_of(cut, end - 1) ? band : none;
    for (int r = begin; r < end; r += step) seam = std::max(seam, held_up_by[r]);
    if (seam == none) {
      shared.bands[band].push_back(unit);
      continue;
    }
    for (int r = begin; r < end; r += step) held_up_by[r] = seam;
    shared.seams[seam].push_back(unit);
  }
  for (Units& band : shared.bands) band = in_sweep_order(band, rows);
  return shared;
}

// For passes that run down the columns in order, so that no band can begin before the one above: iterations follow one
// another down the sheet (pipelining). The sweep is cut into bands by time. Band b of iteration k runs at stage 2 k +
// b: after the band above it, and after bands b and b + 1 of the iteration before. At the same stage run bands b - 2, b
// + 2, ... of other iterations, with which it shares no row as long as a band is as high as the sweep reaches back.
inline std::vector<Units> cut_into_stages(const Units& units, int rows, int most_bands) {
  const std::vector<int> times = rows_reached(units, rows);
  int reach = 1;
  for (std::size_t u = 0; u < units.size(); ++u) reach = std::max(reach, times[u] - units[u].begin);
  const int bands = std::clamp(rows / reach, 1, most_bands);
  const std::vector<int> cut = cut_rows(rows, bands);

  std::vector<Units> stages(bands);
  for (std::size_t u = 0; u < units.size(); ++u) stages[band_of(cut, times[u])].push_back(units[u]);
  for (Units& stage : stages) stage = in_sweep_order(stage, rows);
  return stages;
}

}  // namespace lockstep::cloth::openmp
