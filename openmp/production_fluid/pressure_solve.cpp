// Solves the system of the pressure by conjugate gradients.
//
// The algorithm and its serial form stand in serial/production_fluid/pressure_solve.cpp. All vectors of the solve are
// in the order of skewed.h, so that the triangular solves take sixteen cells at once with neighbours in the same order
// as ever, and every other operation goes straight through memory. The system comes into that order once, and the
// pressure leaves it whenever it is refreshed.
//
// The contract stands in common/production_fluid/pressure_solve.h.
#include "common/production_fluid/pressure_solve.h"

#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "common/linear/iterate.h"
#include "common/real.h"
#include "common/simd.h"
#include "common/simd_double.h"
#include "openmp/production_fluid/prefetch.h"
#include "openmp/production_fluid/skewed.h"
#include "openmp/production_fluid/zeros.h"

namespace lockstep::production_fluid::openmp {
namespace {

static_assert(lines_of_a_sum == lanes && side_of_a_block == lanes);

// Calls f(i) for each vector of a stretch, in order; i is where it stands.
template <class F>
LOCKSTEP_INLINE void for_each_vector(const Skewed& skewed, const Stretch& part, const F& f) {
  const std::ptrdiff_t begin = skewed.at(part.tile, part.z, part.begin), end = skewed.at(part.tile, part.z, part.end);
  for (std::ptrdiff_t i = begin; i < end; i += lanes) f(i);
}
template <class F>
LOCKSTEP_INLINE void for_each_vector_backward(const Skewed& skewed, const Stretch& part, const F& f) {
  const std::ptrdiff_t begin = skewed.at(part.tile, part.z, part.begin), end = skewed.at(part.tile, part.z, part.end);
  for (std::ptrdiff_t i = end - lanes; i >= begin; i -= lanes) f(i);
}

// Calls f(tile) for each tile that has rows.
template <class F>
void for_each_tile(const Skewed& skewed, const F& f) {
  const std::ptrdiff_t count = std::ssize(skewed.tiles());
  // What f writes belongs to its tile.
#pragma omp parallel for schedule(static)
  for (std::ptrdiff_t k = 0; k < count; ++k) f(skewed.tiles()[k]);
}

// The sum over all tiles of f(tile), sixteen sums, one a line. A lane adds up its line in ascending order of x; lanes
// without a row add 0 to a sum that began at 0, which changes no bit.
template <class F>
double sum(const Skewed& skewed, const F& f) {
  const std::ptrdiff_t count = std::ssize(skewed.tiles());
  std::vector<double> sums(count);
  // A tile writes its own sum, and what f writes belongs to the tile.
#pragma omp parallel for schedule(static)
  for (std::ptrdiff_t k = 0; k < count; ++k) sums[k] = reduce_add(f(skewed.tiles()[k]));
  double sum = 0;
  for (const double s : sums) sum += s;
  return sum;
}

// What the loop of conjugate gradients does with vectors (common/linear/dot.h, update.h).
struct Vectors {
  const Skewed& skewed;

  double dot(std::span<const Real> x, std::span<const Real> y) const {
    return sum(skewed, [&](const Stretch& tile) {
      doublev lines = 0.;
      for_each_vector(skewed, tile,
                      [&](std::size_t i) { lines = lines + to_double(load(&x[i])) * to_double(load(&y[i])); });
      return lines;
    });
  }
  void axpy(Real a, std::span<const Real> x, std::span<Real> y) const {
    for_each_tile(skewed, [&](const Stretch& tile) {
      for_each_vector(skewed, tile, [&](std::size_t i) { store(&y[i], load(&y[i]) + a * load(&x[i])); });
    });
  }
};

// --- The factor. Whole and InBlocks, the two kinds of it, call f(part, coupled) for all parts in the order of a
// triangular solve, ascending or descending. Every thread of the team must call them.

// Whether neighbours beyond a tile count in the factor: along y, in the plane before, in the plane after.
struct Coupled {
  bool y, low_z, high_z;
};

// One factor of all cells, stage after stage. The barrier at the end of a stage makes what its parts wrote visible to
// the next.
struct Whole {
  const Skewed& skewed;

  template <class F>
  void ascending(const F& f) const {
    for (const std::vector<Stretch>& parts : skewed.stages()) of_stage(parts, f);
  }
  // Calls g(part), too, once f was called for all neighbours of the part.
  template <class F, class G>
  void descending(const F& f, const G& g) const {
    const std::ptrdiff_t count = std::ssize(skewed.stages());
    const auto parts = [&](std::ptrdiff_t stage) {
      return stage >= 0 && stage < count ? std::span(skewed.stages()[stage]) : std::span<const Stretch>();
    };
    for (std::ptrdiff_t stage = count - 1; stage >= -2; --stage) {
      const std::span<const Stretch> first = parts(stage), second = parts(stage + 2);
      const std::ptrdiff_t pairs = std::max(std::ssize(first), std::ssize(second));
#pragma omp for schedule(static)
      for (std::ptrdiff_t k = 0; k < 2 * pairs; ++k)
        if (k % 2 == 0) {
          if (k / 2 < std::ssize(first)) f(first[k / 2], Coupled{true, true, true});
        } else {
          if (k / 2 < std::ssize(second)) g(second[k / 2]);
        }
    }
  }

 private:
  template <class F>
  static void of_stage(const std::vector<Stretch>& parts, const F& f) {
    const std::ptrdiff_t count = std::ssize(parts);
    // Parts of a stage do not wait for one another, and each writes its own cells.
#pragma omp for schedule(static)
    for (std::ptrdiff_t k = 0; k < count; ++k) f(parts[k], Coupled{true, true, true});
  }
};

// A factor a block.
struct InBlocks {
  const Skewed& skewed;

  template <class F>
  void ascending(const F& f) const {
    of_blocks([&](const std::vector<Stretch>& block) {
      for (const Stretch& part : block) f(part, coupled(part));
    });
  }
  template <class F, class G>
  void descending(const F& f, const G& g) const {
    of_blocks([&](const std::vector<Stretch>& block) {
      for (auto part = block.rbegin(); part != block.rend(); ++part) f(*part, coupled(*part));
    });
    of_blocks([&](const std::vector<Stretch>& block) {
      for (const Stretch& part : block) g(part);
    });
  }

 private:
  static Coupled coupled(const Stretch& part) {
    return {false, part.z % side_of_a_block > 0, (part.z + 1) % side_of_a_block > 0};
  }
  template <class F>
  void of_blocks(const F& f) const {
    const std::ptrdiff_t count = std::ssize(skewed.blocks());
    // Blocks do not read what others write, and each writes its own cells.
#pragma omp for schedule(dynamic)
    for (std::ptrdiff_t k = 0; k < count; ++k) f(skewed.blocks()[k]);
  }
};

LOCKSTEP_INLINE floatv low_y(const Skewed& skewed, const Real* at, const Coupled& coupled) {
  return coupled.y ? low_y(skewed, at) : shift_up(low_x(at), 0.f);
}
LOCKSTEP_INLINE floatv high_y(const Skewed& skewed, const Real* at, const Coupled& coupled) {
  return coupled.y ? high_y(skewed, at) : shift_down(high_x(at), 0.f);
}
LOCKSTEP_INLINE floatv low_z(const Skewed& skewed, const Real* at, const Coupled& coupled) {
  return coupled.low_z ? low_z(skewed, at) : floatv(0.f);
}
LOCKSTEP_INLINE floatv high_z(const Skewed& skewed, const Real* at, const Coupled& coupled) {
  return coupled.high_z ? high_z(skewed, at) : floatv(0.f);
}

// 1 / e of all cells.
template <class Kind>
Array<Real> make_inverses(const Skewed& skewed, const Kind& kind, const Array<Real>& diagonal,
                          const linear::Modification& modification, PressureMemory<Real>& memory) {
  const floatv tau = static_cast<Real>(modification.tau), sigma = static_cast<Real>(modification.sigma);
  Array<Real> inverse = take_zeros(memory, skewed.size()), share = take_zeros(memory, skewed.size());
  // The threads share parts as the kind says. A part writes its own cells.
#pragma omp parallel
  kind.ascending([&](const Stretch& part, const Coupled& c) {
    for_each_vector(skewed, part, [&](std::size_t i) {
      const auto row = [](floatv d) { return select(d > 0.f, floatv(1.f), floatv(0.f)); };
      const Real *const d = &diagonal[i], *const s = &share[i];
      const floatv upper_neighbours = row(high_x(d)) + row(high_y(skewed, d, c)) + row(high_z(skewed, d, c));
      const Pivot<floatv> p =
          pivot(load(d), low_x(s), low_y(skewed, s, c), low_z(skewed, s, c), upper_neighbours, tau, sigma);
      store(&inverse[i], p.inverse), store(&share[i], p.share);
    });
  });
  memory.give_back(share);
  return inverse;
}

template <class Kind>
struct Steps {
  const Skewed& skewed;
  const Kind& kind;
  const Array<Real>&diagonal, &inverse;
  std::span<Real> x, r, z, p;
  std::optional<double> rz = {};
  struct SumOf {
    std::vector<doublev> lines;
    std::vector<double> tiles;
    explicit SumOf(std::size_t n) : lines(n, doublev(0.)), tiles(n) {}
    void end(int k, bool last, doublev sum) {
      if (last) tiles[k] = reduce_add(sum), sum = doublev(0.);
      lines[k] = sum;
    }
    double total() const {
      double total = 0;
      for (const double t : tiles) total += t;
      return total;
    }
  };
  SumOf first = SumOf(skewed.tiles().size()), second = SumOf(skewed.tiles().size());

  double precondition() {
    if (!rz) descend(0);
    const double found = *rz;
    rz.reset();
    return found;
  }

  double descend(Real a) {
#pragma omp parallel
    kind.ascending([&](const Stretch& part, const Coupled& c) {
      doublev rr = first.lines[part.of], ry = second.lines[part.of];
      floatv low = low_x(&z[skewed.at(part.tile, part.z, part.begin)]);
      for_each_vector(skewed, part, [&](std::size_t i) {
        Real* const at = &z[i];
        prefetch<ahead>(&inverse[i], &r[i], at);
        const floatv rest = load(&r[i]) - a * load(at);
        const floatv low_y = shift_up(low, c.y ? at[skewed.to_low_tile() + lanes - 1] : 0.f);
        const floatv ey = forward(rest, low, low_y, low_z(skewed, at, c));
        const floatv y = load(&inverse[i]) * ey;
        store(&r[i], rest);
        store(at, y);
        rr = rr + to_double(rest) * to_double(rest);
        ry = ry + to_double(ey) * to_double(y);
        low = y;
      });
      const bool last = part.end == skewed.tiles()[part.of].end;
      first.end(part.of, last, rr), second.end(part.of, last, ry);
    });
    rz = second.total();
    return first.total();
  }

  double advance(Real a, Real b) {
#pragma omp parallel
    kind.descending(
        [&](const Stretch& part, const Coupled& c) {
          floatv high = load(&z[skewed.at(part.tile, part.z, part.end)]);
          for_each_vector_backward(skewed, part, [&](std::size_t i) {
            Real* const at = &z[i];
            prefetch<-ahead>(&inverse[i], at, &x[i], &p[i]);
            const floatv high_y = shift_down(high, c.y ? at[skewed.to_high_tile()] : 0.f);
            high = backward(load(&inverse[i]), load(at), high, high_y, high_z(skewed, at, c));
            store(at, high);
            const floatv along = load(&p[i]);
            store(&x[i], load(&x[i]) + a * along);
            store(&p[i], high + b * along);
          });
        },
        [&](const Stretch& part) {
          doublev pq = first.lines[part.of];
          for_each_vector_backward(skewed, part, [&](std::size_t i) {
            const Real* const at = &p[i];
            const floatv here = load(at), d = load(&diagonal[i]);
            prefetch<-ahead>(&diagonal[i]);
            const floatv row = product(d, here, low_x(at), high_x(at), low_y(skewed, at), high_y(skewed, at),
                                       low_z(skewed, at), high_z(skewed, at));
            const floatv found = select(d > 0.f, row, 0.f);
            store(&z[i], found);
            pq = pq + to_double(here) * to_double(found);
          });
          first.end(part.of, part.begin == skewed.tiles()[part.of].begin, pq);
        });
    return first.total();
  }
};

// --- To the order of the cells and back

// Cells of lane l in vectors s .. s + 15: x = begin .. end - 1, from place `first` of sixteen on.
struct Cells {
  int y, begin, end, first;
};
Cells cells_of(const Bordered& cells, const Stretch& tile, int s, int l) {
  const int y = tile.tile * lanes + l, x = s - l, begin = std::max(x, 0);
  return {y, begin, y < cells.ny ? std::min(x + lanes, cells.nx) : begin, begin - x};
}

// Fills a tile with values of its cells: value(i), where i is where the cell stands in bordered arrays.
template <class Value>
void fill(const Skewed& skewed, const Stretch& tile, std::span<Real> to, const Value& value) {
  for (int s = tile.begin; s < tile.end; s += lanes) {
    floatv square[lanes];
    for (int l = 0; l < lanes; ++l) {
      Real line[lanes] = {};
      const auto [y, begin, end, first] = cells_of(skewed.cells(), tile, s, l);
      for (int x = begin; x < end; ++x) line[first + x - begin] = value(skewed.cells().index(x, y, tile.z));
      square[l] = load(line);
    }
    transpose(square);
    for (int k = 0; k < std::min(lanes, tile.end - s); ++k) store(&to[skewed.at(tile.tile, tile.z, s + k)], square[k]);
  }
}

// Calls f(i, value) for the cells of a tile; i is where the cell stands in bordered arrays.
template <class F>
void for_each_value(const Skewed& skewed, const Stretch& tile, std::span<const Real> from, const F& f) {
  for (int s = tile.begin; s < tile.end; s += lanes) {
    floatv square[lanes];
    for (int k = 0; k < lanes; ++k)
      square[k] = s + k < tile.end ? load(&from[skewed.at(tile.tile, tile.z, s + k)]) : floatv(0.f);
    transpose(square);
    for (int l = 0; l < lanes; ++l) {
      Real line[lanes];
      store(line, square[l]);
      const auto [y, begin, end, first] = cells_of(skewed.cells(), tile, s, l);
      for (int x = begin; x < end; ++x) f(skewed.cells().index(x, y, tile.z), line[first + x - begin]);
    }
  }
}

Array<Real> skew(const Skewed& skewed, const Array<Real>& of_cells, PressureMemory<Real>& memory) {
  Array<Real> to = take_zeros(memory, skewed.size());
  for_each_tile(skewed,
                [&](const Stretch& tile) { fill(skewed, tile, to, [&](std::size_t i) { return of_cells[i]; }); });
  return to;
}

// Adds x to the pressure, sets x to 0, and computes the residual of the pressure.
double refresh(const System<Real>& system, const Skewed& skewed, Array<double>& q, std::span<Real> x,
               std::span<Real> r) {
  for_each_tile(skewed, [&](const Stretch& tile) {
    for_each_value(skewed, tile, x, [&](std::size_t i, Real value) { q[i] += value; });
    for_each_vector(skewed, tile, [&](std::size_t i) { store(&x[i], floatv(0.f)); });
  });
  const std::ptrdiff_t line = system.cells.line(), plane = system.cells.plane();
  for_each_tile(skewed, [&](const Stretch& tile) {
    fill(skewed, tile, r, [&](std::size_t i) {
      const double* const at = &q[i];
      const double row =
          product<double>(system.diagonal[i], at[0], at[-1], at[1], at[-line], at[line], at[-plane], at[plane]);
      return system.diagonal[i] > 0 ? static_cast<Real>(system.right[i] - row) : 0;
    });
  });
  return Vectors{skewed}.dot(r, r);
}

template <class Kind>
linear::Solution solve(const System<Real>& system, const PressureSettings& settings, PressureMemory<Real>& memory,
                       Array<double>& q) {
  q.resize(system.cells.size()), fill_with_zeros(q);
  const Skewed skewed(system);
  const Kind kind{skewed};
  Array<Real> diagonal = skew(skewed, system.diagonal, memory), right = skew(skewed, system.right, memory),
              inverse = make_inverses(skewed, kind, diagonal, settings.modification, memory);
  const auto zeros = [&] { return take_zeros(memory, skewed.size()); };
  Array<Real> x = zeros(), r = zeros(), z = zeros(), p = zeros();
  Steps<Kind> steps{skewed, kind, diagonal, inverse, x, r, z, p};
  const linear::System<Real> operators = {
      .multiply = nullptr,
      .precondition = nullptr,
      .residual = nullptr,
      .refresh = [&](std::span<Real> x, std::span<Real> r) { steps.rz.reset(); return refresh(system, skewed, q, x, r); }};
  const linear::Solution solution =
      linear::iterate(Vectors{skewed}, operators, right, {x, r, z, p}, settings.stop, steps);
  for (Array<Real>* array : {&diagonal, &right, &inverse, &x, &r, &z, &p}) memory.give_back(*array);
  return solution;
}

}  // namespace

linear::Solution pressure_solve_mic(const System<Real>& system, const PressureSettings& settings,
                                    PressureMemory<Real>& memory, Array<double>& q) {
  return solve<Whole>(system, settings, memory, q);
}

linear::Solution pressure_solve_block_mic(const System<Real>& system, const PressureSettings& settings,
                                          PressureMemory<Real>& memory, Array<double>& q) {
  return solve<InBlocks>(system, settings, memory, q);
}

}  // namespace lockstep::production_fluid::openmp
