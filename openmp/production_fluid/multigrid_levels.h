// The grids of multigrid's cycle, and lists of what has rows, so that every pass goes straight through memory and skips
// what is empty.
//
// Arrays are bordered, and vectors begin at multiples of sixteen places, wherever in a line that is: a smoother does
// the same at every place, and finds 0 where there is no row. Only transfers go line by line.
//
// The serial form (serial/production_fluid/multigrid_levels.h) goes through all places of a grid.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

#include "common/linear/dot.h"
#include "common/production_fluid/multigrid.h"
#include "common/simd.h"
#include "openmp/production_fluid/zeros.h"

namespace lockstep::production_fluid::openmp {

// Places begin .. end - 1 of one block of a dot product: from its first vector of sixteen that has a row to its last.
struct Part {
  std::ptrdiff_t begin, end;
};

// Cells begin .. end - 1 of a line, from the first that has a row to the last.
struct Span {
  int y, z, begin, end;
};

// A vector that has cells of the band: where it stands, and which lanes, by colour.
struct Patch {
  std::int32_t vector;  // its number
  std::uint16_t of_colour[2];
};

struct Level {
  Bordered cells;
  const Array<float>* diagonal;  // 0 where there is no row
  Array<float> inverse;          // likewise
  std::vector<std::uint16_t> has_row;  // of each vector of sixteen places: a bit a place; and one more that is 0
  std::vector<Part> parts;
  std::vector<Span> lines;
  std::vector<Patch> band;
  int passes;                    // over the band
  Array<float> right, solution;  // of a coarse grid
  Array<float> guess;

  Array<float> rows;  // the diagonal of a coarse grid
};

// Which of sixteen places have a row, from any place on.
LOCKSTEP_INLINE maskv rows_from(const Level& level, std::size_t i) {
  const std::uint16_t* const of_vector = &level.has_row[i / lanes];
  return lanes_of((of_vector[0] | std::uint32_t(of_vector[1]) << lanes) >> i % lanes & 0xffff);
}

// Threads share the work of grids with at least as many parts.
inline bool is_shared(const std::vector<Part>& parts) { return std::ssize(parts) >= blocks_to_share; }
inline bool is_shared(const Level& level) { return is_shared(level.parts); }

// Calls f(y, z) for each line.
template <class F>
void for_each_line(const Bordered& cells, const F& f) {
  // What f writes belongs to its line.
#pragma omp parallel for collapse(2) schedule(static) if (cells.size() >= blocks_to_share * linear::dot_block)
  for (int z = 0; z < cells.nz; ++z)
    for (int y = 0; y < cells.ny; ++y) f(y, z);
}

// In the loops below, an iteration of an `omp simd` loop writes its own element, and reads other arrays. Bounds and
// strides are copied: a byte that is written may alias anything, and the loop would stay scalar.
inline Kinds finest_kinds(const System<float>& system) {
  Kinds kinds = make_kinds(system.cells, system.open_top);
  for_each_line(kinds.cells, [&](int y, int z) {
    const int nx = kinds.cells.nx;
    const std::size_t i = system.cells.index(0, y, z);
    std::uint8_t* const kind = &kinds.value[kinds.index(0, y, z)];
    const float* const diagonal = &system.diagonal[i];
    const std::uint8_t* const is_air = &system.air[i];
#pragma omp simd
    for (int x = 0; x < nx; ++x) kind[x] = kind_of(diagonal[x] > 0, is_air[x]);
  });
  return kinds;
}

inline Kinds coarser_kinds(const Kinds& fine) {
  Kinds kinds = make_kinds(coarser(fine.cells), fine.open_top);
  for_each_line(kinds.cells, [&](int y, int z) {
    const int nx = kinds.cells.nx;
    const std::ptrdiff_t line = fine.line(), plane = fine.plane();
    std::uint8_t* const kind = &kinds.value[kinds.index(0, y, z)];
    const std::uint8_t* const child = &fine.value[fine.index(0, 2 * y, 2 * z)];
#pragma omp simd
    for (int x = 0; x < nx; ++x) kind[x] = kind_of_parent(child + 2 * x, line, plane);
  });
  return kinds;
}

inline Array<float> coarse_rows(const Kinds& kinds, PressureMemory<float>& memory) {
  Array<float> diagonal = take_zeros(memory, kinds.cells.size());
  for_each_line(kinds.cells, [&](int y, int z) {
    const int nx = kinds.cells.nx;
    const std::ptrdiff_t line = kinds.line(), plane = kinds.plane();
    float* const row = &diagonal[kinds.cells.index(0, y, z)];
    const std::uint8_t* const kind = &kinds.value[kinds.index(0, y, z)];
#pragma omp simd
    for (int x = 0; x < nx; ++x) row[x] = static_cast<float>(row_of(kind + x, line, plane));
  });
  return diagonal;
}

// For each place, 0 or, if its cell is in the band, 1 + its colour.
inline Array<std::uint8_t> find_band(const Kinds& kinds) {
  Array<std::uint8_t> beside(kinds.size()), band(kinds.cells.size());
  for_each_line(kinds.cells, [&](int y, int z) {
    const int nx = kinds.cells.nx;
    const std::ptrdiff_t line = kinds.line(), plane = kinds.plane();
    const std::size_t i = kinds.index(0, y, z);
    const std::uint8_t* const kind = &kinds.value[i];
    std::uint8_t* const to = &beside[i];
#pragma omp simd
    for (int x = 0; x < nx; ++x) to[x] = is_beside_boundary(kind + x, line, plane);
  });
  for_each_line(kinds.cells, [&](int y, int z) {
    const int nx = kinds.cells.nx;
    const std::ptrdiff_t line = kinds.line(), plane = kinds.plane();
    const std::uint8_t all = is_coarsest(kinds.cells),
                       colours[] = {std::uint8_t(1 + colour_of(0, y, z)), std::uint8_t(1 + colour_of(1, y, z))};
    const std::size_t i = kinds.index(0, y, z);
    const std::uint8_t *const kind = &kinds.value[i], *const from = &beside[i];
    std::uint8_t* const to = &band[kinds.cells.index(0, y, z)];
#pragma omp simd
    for (int x = 0; x < nx; ++x) {
      const std::uint8_t in = (kind[x] == Kinds::liquid) & (all | is_in_band(from + x, line, plane));
      to[x] = in * (x % 2 == 0 ? colours[0] : colours[1]);
    }
  });
  return band;
}

inline std::vector<Part> find_parts(const Array<float>& diagonal) {
  const std::ptrdiff_t vectors = std::ssize(diagonal) / lanes, of_block = linear::dot_block / lanes;
  std::vector<Part> parts((vectors + of_block - 1) / of_block);
  const auto has_row = [&](std::ptrdiff_t vector) { return any(load(&diagonal[vector * lanes]) > 0.f); };
  // A block writes its own part.
#pragma omp parallel for schedule(static) if (is_shared(parts))
  for (std::ptrdiff_t k = 0; k < std::ssize(parts); ++k) {
    std::ptrdiff_t begin = k * of_block, end = std::min(begin + of_block, vectors);
    while (begin < end && !has_row(begin)) ++begin;
    while (begin < end && !has_row(end - 1)) --end;
    parts[k] = {begin * lanes, end * lanes};
  }
  std::erase_if(parts, [](const Part& part) { return part.begin == part.end; });
  return parts;
}

inline std::vector<Span> find_lines(const Bordered& cells, const Array<float>& diagonal) {
  std::vector<Span> lines(static_cast<std::size_t>(cells.ny) * cells.nz);
  for_each_line(cells, [&](int y, int z) {
    const float* const row = &diagonal[cells.index(0, y, z)];
    int begin = 0, end = cells.nx;
    while (begin < end && !(row[begin] > 0)) ++begin;
    while (begin < end && !(row[end - 1] > 0)) --end;
    lines[y + static_cast<std::size_t>(cells.ny) * z] = {y, z, begin, end};
  });
  std::erase_if(lines, [](const Span& line) { return line.begin == line.end; });
  return lines;
}

inline std::vector<Patch> find_patches(const std::vector<Part>& parts, const Array<std::uint8_t>& band) {
  const auto for_each_patch = [&](const Part& part, const auto& f) {
    for (std::ptrdiff_t i = part.begin; i < part.end; i += lanes) {
      std::uint64_t halves[2];
      std::memcpy(halves, &band[i], sizeof halves);
      if ((halves[0] | halves[1]) == 0) continue;
      Patch patch = {static_cast<std::int32_t>(i / lanes), {0, 0}};
      for (int l = 0; l < lanes; ++l)
        if (band[i + l] > 0) patch.of_colour[band[i + l] - 1] |= static_cast<std::uint16_t>(1 << l);
      f(patch);
    }
  };
  const std::ptrdiff_t count = std::ssize(parts);
  std::vector<std::ptrdiff_t> first(count + 1);
  // A part writes its own number of patches.
#pragma omp parallel for schedule(static) if (is_shared(parts))
  for (std::ptrdiff_t k = 0; k < count; ++k) for_each_patch(parts[k], [&](const Patch&) { ++first[k + 1]; });
  for (std::ptrdiff_t k = 0; k < count; ++k) first[k + 1] += first[k];
  std::vector<Patch> patches(first[count]);
  // A part writes its own patches.
#pragma omp parallel for schedule(static) if (is_shared(parts))
  for (std::ptrdiff_t k = 0; k < count; ++k) {
    Patch* to = patches.data() + first[k];
    for_each_patch(parts[k], [&](const Patch& patch) { *to++ = patch; });
  }
  return patches;
}

inline void make_level(const Kinds& kinds, const Array<float>& diagonal, PressureMemory<float>& memory, Level& level) {
  level.cells = kinds.cells;
  level.diagonal = &diagonal;
  level.passes = is_coarsest(kinds.cells) ? coarsest_passes : band_passes;
  level.parts = find_parts(diagonal);
  level.lines = find_lines(kinds.cells, diagonal);
  level.band = find_patches(level.parts, find_band(kinds));
  level.inverse = memory.take(diagonal.size());  // read only within parts
  level.guess = take_zeros(memory, diagonal.size());
  level.has_row.assign(diagonal.size() / lanes + 1, 0);
  // A part writes its own places.
#pragma omp parallel for schedule(static) if (is_shared(level))
  for (std::ptrdiff_t k = 0; k < std::ssize(level.parts); ++k)
    for (std::ptrdiff_t i = level.parts[k].begin; i < level.parts[k].end; i += lanes) {
      const floatv d = load(&diagonal[i]);
      store(&level.inverse[i], select(d > 0.f, 1.f / d, 0.f));
      level.has_row[i / lanes] = static_cast<std::uint16_t>(bits(d > 0.f));
    }
}

// The finest first. The system must outlive them.
inline std::vector<Level> make_levels(const System<float>& system, PressureMemory<float>& memory) {
  Kinds kinds = finest_kinds(system);
  std::vector<Level> levels(1);
  make_level(kinds, system.diagonal, memory, levels[0]);
  while (!is_coarsest(kinds.cells)) {
    kinds = coarser_kinds(kinds);
    Array<float> rows = coarse_rows(kinds, memory);
    levels.emplace_back();
    make_level(kinds, rows, memory, levels.back());
    for (Array<float>* array : {&levels.back().right, &levels.back().solution})
      *array = take_zeros(memory, rows.size());
    levels.back().rows = std::move(rows);
  }
  for (std::size_t of = 1; of < levels.size(); ++of) levels[of].diagonal = &levels[of].rows;
  return levels;
}

// Gives back an array that was taken as zeros, and written only within a level's parts: a solve that sets these to 0
// again writes less than one that begins with whole arrays.
inline void give_back_zeros(const Level& level, Array<float>& array, PressureMemory<float>& memory) {
  if (array.empty()) return;
  // A part sets its own places.
#pragma omp parallel for schedule(static) if (is_shared(level))
  for (std::ptrdiff_t k = 0; k < std::ssize(level.parts); ++k)
    std::fill(&array[level.parts[k].begin], &array[level.parts[k].end], 0.f);
  memory.give_back_zeros(array);
}

inline void give_back(std::vector<Level>& levels, PressureMemory<float>& memory) {
  for (Level& level : levels) {
    for (Array<float>* array : {&level.right, &level.solution, &level.guess}) give_back_zeros(level, *array, memory);
    for (Array<float>* array : {&level.inverse, &level.rows}) memory.give_back(*array);
  }
}

}  // namespace lockstep::production_fluid::openmp
