// Solves the system of the pressure by conjugate gradients.
//
// The algorithm and its serial form stand in serial/production_fluid/pressure_solve.cpp. All vectors of the solve are
// in the order of skewed.h, so that the triangular solves take sixteen cells at once with neighbours in the same order
// as ever. An iteration goes through memory twice. The system comes into that order once, and the pressure leaves it
// whenever it is refreshed.
//
// The contract stands in common/production_fluid/pressure_solve.h.
#include "common/production_fluid/pressure_solve.h"

#include <array>
#include <vector>

#include "common/linear/iterate.h"
#include "common/real.h"
#include "common/simd.h"
#include "common/simd_double.h"
#include "openmp/production_fluid/guess.h"
#include "openmp/production_fluid/prefetch.h"
#include "openmp/production_fluid/skewed.h"
#include "openmp/production_fluid/skewing.h"
#include "openmp/production_fluid/solve_order.h"
#include "openmp/production_fluid/zeros.h"

namespace lockstep::production_fluid::openmp {
namespace {

static_assert(lines_of_a_sum == lanes);

// Calls f(i, k) for each vector of a stretch and each of its planes, in order; i is where the vector of plane k stands.
template <class F>
LOCKSTEP_INLINE void for_each_vector(const Skewed& skewed, const Stretch& part, const F& f) {
  const std::ptrdiff_t begin = skewed.at(part.tile, part.z, part.begin), end = skewed.at(part.tile, part.z, part.end);
  for (std::ptrdiff_t i = begin; i < end; i += lanes)
    for (int k = 0; k < depth; ++k) f(i + k * skewed.along_z(), k);
}
template <class F>
LOCKSTEP_INLINE void for_each_vector_backward(const Skewed& skewed, const Stretch& part, const F& f) {
  const std::ptrdiff_t begin = skewed.at(part.tile, part.z, part.begin), end = skewed.at(part.tile, part.z, part.end);
  for (std::ptrdiff_t i = end - lanes; i >= begin; i -= lanes)
    for (int k = depth - 1; k >= 0; --k) f(i + k * skewed.along_z(), k);
}

// Calls f(tile) for each tile that has rows.
template <class F>
void for_each_tile(const Skewed& skewed, const F& f) {
  const std::ptrdiff_t count = std::ssize(skewed.tiles());
  // What f writes belongs to its tile.
#pragma omp parallel for schedule(static)
  for (std::ptrdiff_t k = 0; k < count; ++k) f(skewed.tiles()[k]);
}

// The sums of a tile's lines: lane l of number k is line l of plane k. A lane adds up its line vector by vector; lanes
// without a row add 0 to a sum that began at 0, which changes no bit.
using Lines = std::array<doublev, depth>;
Lines zero_lines() {
  Lines lines;
  lines.fill(doublev(0.));
  return lines;
}

// A sum over all cells, in each pass anew. A pass may come to the parts of a tile one after another: a lane goes on
// where the part before left it.
class Sum {
 public:
  explicit Sum(const Skewed& skewed) : tiles_(skewed.tiles()), sums_(tiles_.size()) {}

  Lines lines(const Stretch& part, bool is_first) const { return is_first ? zero_lines() : sums_[part.of].lines; }
  void go_on(const Stretch& part, const Lines& lines, bool is_last) {
    OfTile& tile = sums_[part.of];
    if (is_last)
      for (int k = 0; k < depth; ++k) tile.planes[k] = reduce_add(lines[k]);
    else
      tile.lines = lines;
  }
  double total() const {
    double total = 0;
    for (std::size_t begin = 0, end = 0; begin < tiles_.size(); begin = end) {
      while (end < tiles_.size() && tiles_[end].z == tiles_[begin].z) ++end;
      for (int k = 0; k < depth; ++k)
        for (std::size_t tile = begin; tile < end; ++tile) total += sums_[tile].planes[k];
    }
    return total;
  }

 private:
  struct OfTile {
    Lines lines;
    std::array<double, depth> planes;
  };

  const std::vector<Stretch>& tiles_;
  std::vector<OfTile> sums_;
};

// The sum over all tiles of f(tile).
template <class F>
double sum_of_tiles(const Skewed& skewed, const F& f) {
  Sum sum(skewed);
  for_each_tile(skewed, [&](const Stretch& tile) { sum.go_on(tile, f(tile), true); });
  return sum.total();
}

// Rows of A x.
LOCKSTEP_INLINE floatv row_times(const Skewed& skewed, const Array<Real>& diagonal, std::span<const Real> x,
                                 std::size_t i) {
  const Real* const at = &x[i];
  const floatv d = load(&diagonal[i]);
  return select(d > 0.f,
                product(d, load(at), low_x(at), high_x(at), low_y(skewed, at), high_y(skewed, at), low_z(skewed, at),
                        high_z(skewed, at)),
                0.f);
}

// --- The factor

// 1 / e of all cells.
template <class Kind>
Array<Real> make_inverses(const Skewed& skewed, const Kind& kind, const Array<Real>& diagonal,
                          const linear::Modification& modification, PressureMemory<Real>& memory) {
  const floatv tau = static_cast<Real>(modification.tau), sigma = static_cast<Real>(modification.sigma);
  Array<Real> inverse = memory.take(skewed.size()), share = take_zeros(memory, skewed.size());
  // The threads share parts as the kind says. A part writes its own cells.
#pragma omp parallel
  kind.ascending([&](const Stretch& part, const Stretch&, const Coupled& of_part) {
    for_each_vector(skewed, part, [&](std::size_t i, int k) {
      const Coupled c = of_part.of_plane(k);
      const auto row = [](floatv d) { return select(d > 0.f, floatv(1.f), floatv(0.f)); };
      const Real *const d = &diagonal[i], *const s = &share[i];
      const floatv upper_neighbours = row(high_x(d)) + row(high_y(skewed, d, high_x(d), c)) + row(high_z(skewed, d, c));
      const Pivot<floatv> p =
          pivot(load(d), low_x(s), low_y(skewed, s, low_x(s), c), low_z(skewed, s, c), upper_neighbours, tau, sigma);
      store(&inverse[i], p.inverse), store(&share[i], p.share);
    });
  });
  memory.give_back(share);
  return inverse;
}

// What the loop of conjugate gradients does with vectors (common/linear/iterate.h), in two passes through memory, which
// bounds it. The first triangular solve goes with the update of r, which it begins with. The second one goes with the
// step, the direction and the product, which use its z. The direction needs r . z: that comes from the first solve.
template <class Kind>
struct Steps {
  const Skewed& skewed;
  const Kind& kind;
  const Array<Real>&diagonal, &inverse;
  Sum sum_rr{skewed}, sum_rz{skewed}, sum_pq{skewed};
  bool is_solved = false;  // the first triangular solve, of r

  double dot(std::span<const Real> x, std::span<const Real> y) const {
    return sum_of_tiles(skewed, [&](const Stretch& tile) {
      Lines sum = zero_lines();
      for_each_vector(skewed, tile,
                      [&](std::size_t i, int k) { sum[k] = sum[k] + to_double(load(&x[i])) * to_double(load(&y[i])); });
      return sum;
    });
  }
  void axpy(Real a, std::span<const Real> x, std::span<Real> y) const {
    for_each_tile(skewed, [&](const Stretch& tile) {
      for_each_vector(skewed, tile, [&](std::size_t i, int) { store(&y[i], load(&y[i]) + a * load(&x[i])); });
    });
  }

  // z holds q, then y of the new r.
  double descend(Real a, std::span<Real> z, std::span<Real> r) {
    // The threads share parts as the kind says. A part writes its own cells, and its tile's sums.
#pragma omp parallel
    kind.ascending([&, a](const Stretch& part, const Stretch& next, const Coupled& c) {
      const std::ptrdiff_t begin = skewed.at(part.tile, part.z, part.begin),
                           ahead = skewed.at(next.tile, next.z, next.begin) - begin;
      Lines rr = sum_rr.lines(part, is_lowest(part)), rz = sum_rz.lines(part, is_lowest(part));
      floatv y[depth];  // of the vectors before
      for (int k = 0; k < depth; ++k) y[k] = low_x(&z[begin + k * skewed.along_z()]);
      for_each_vector(skewed, part, [&](std::size_t i, int k) {
        Real* const at = &z[i];
        prefetch<0>(&inverse[i] + ahead), prefetch_to_write(at + ahead, &r[i] + ahead);
        const floatv rest = load(&r[i]) - a * load(at);
        store(&r[i], rest);
        rr[k] = rr[k] + to_double(rest) * to_double(rest);
        const floatv ey = forward(rest, y[k], low_y(skewed, at, y[k], c), low_z(skewed, at, c.of_plane(k)));
        y[k] = ey * load(&inverse[i]);
        store(at, y[k]);
        rz[k] = rz[k] + to_double(ey) * to_double(y[k]);
      });
      sum_rr.go_on(part, rr, is_highest(part)), sum_rz.go_on(part, rz, is_highest(part));
    });
    is_solved = true;
    return sum_rr.total();
  }

  // The first triangular solve: z becomes y. Returns r . M^-1 r. `descend` has solved for the r that it left.
  double precondition(std::span<Real> r, std::span<Real> z) {
    if (!is_solved) descend(0, z, r);
    return sum_rz.total();
  }

  // The second triangular solve, the step and the next direction, and z = A p. Returns p . A p.
  double advance_and_multiply(Real a, Real b, std::span<Real> x, std::span<Real> p, std::span<Real> z) {
    // The threads share parts as the kind says. A part writes its own cells, and its tile's sum.
#pragma omp parallel
    kind.descending(
        [&, a, b](const Stretch& part, const Stretch& next, const Coupled& c) {
          const std::ptrdiff_t end = skewed.at(part.tile, part.z, part.end),
                               ahead = skewed.at(next.tile, next.z, next.end) - end;
          floatv after[depth];  // z of the vectors after
          for (int k = 0; k < depth; ++k) after[k] = load(&z[end + k * skewed.along_z()]);
          for_each_vector_backward(skewed, part, [&](std::size_t i, int k) {
            Real* const at = &z[i];
            prefetch<0>(&inverse[i] + ahead), prefetch_to_write(at + ahead, &x[i] + ahead, &p[i] + ahead);
            after[k] = backward(load(&inverse[i]), load(at), after[k], high_y(skewed, at, after[k], c),
                                high_z(skewed, at, c.of_plane(k)));
            store(at, after[k]);
            const floatv along = load(&p[i]);
            store(&x[i], load(&x[i]) + a * along);
            store(&p[i], after[k] + b * along);
          });
        },
        [&](const Stretch& part, const Stretch& next) {
          const std::ptrdiff_t ahead = skewed.at(next.tile, next.z, next.end) - skewed.at(part.tile, part.z, part.end);
          Lines pq = sum_pq.lines(part, is_highest(part));
          for_each_vector_backward(skewed, part, [&](std::size_t i, int k) {
            prefetch<0>(&diagonal[i] + ahead);
            const floatv q = row_times(skewed, diagonal, p, i);
            store(&z[i], q);
            pq[k] = pq[k] + to_double(load(&p[i])) * to_double(q);
          });
          sum_pq.go_on(part, pq, is_lowest(part));
        });
    return sum_pq.total();
  }

  bool is_lowest(const Stretch& part) const { return part.begin == skewed.tiles()[part.of].begin; }
  bool is_highest(const Stretch& part) const { return part.end == skewed.tiles()[part.of].end; }
};

Array<Real> skew(const Skewed& skewed, const Array<Real>& of_cells, Array<Real> to) {
  for_each_tile(
      skewed, [&](const Stretch& tile) { fill(skewed, tile, to, [&](std::size_t i) { return load(&of_cells[i]); }); });
  return to;
}

void fill_tiles_with_zeros(const Skewed& skewed, std::span<Real> x) {
  for_each_tile(skewed, [&](const Stretch& tile) {
    for_each_vector(skewed, tile, [&](std::size_t i, int) { store(&x[i], floatv(0.f)); });
  });
}

// Adds x to the pressure, sets x to 0, and computes the residual of the pressure.
template <class Kind>
double refresh(const System<Real>& system, Steps<Kind>& steps, Array<double>& q, std::span<Real> x, std::span<Real> r) {
  const Skewed& skewed = steps.skewed;
  steps.is_solved = false;  // r becomes another
  for_each_tile(skewed, [&](const Stretch& tile) { add(skewed, tile, x, q); });
  fill_tiles_with_zeros(skewed, x);
  const std::ptrdiff_t line = system.cells.line(), plane = system.cells.plane();
  for_each_tile(skewed, [&](const Stretch& tile) {
    fill(skewed, tile, r, [&](std::size_t i) {
      const double* const at = &q[i];
      const floatv diagonal = load(&system.diagonal[i]);
      const doublev row = product(to_double(diagonal), load(at), load(at - 1), load(at + 1), load(at - line),
                                  load(at + line), load(at - plane), load(at + plane));
      return select(diagonal > 0.f, to_float(to_double(load(&system.right[i])) - row), 0.f);
    });
  });
  return steps.dot(r, r);
}

template <class Kind>
linear::Solution solve(const System<Real>& system, const PressureSettings& settings, PressureMemory<Real>& memory,
                       Array<double>& q) {
  const auto start = start_of(system, settings.guess, memory, q);
  const Skewed skewed(system);
  const Kind kind{skewed};
  // Arrays whose neighbours are read are 0 beyond the tiles, too. The others are only read within them.
  const auto zeros = [&] { return take_zeros(memory, skewed.size()); };
  const auto unset = [&] { return memory.take(skewed.size()); };
  Array<Real> diagonal = skew(skewed, system.diagonal, zeros()), right = skew(skewed, system.right, unset()),
              inverse = make_inverses(skewed, kind, diagonal, settings.modification, memory);
  Array<Real> x = unset(), r = unset(), z = zeros(), p = zeros();
  for (Array<Real>* array : {&x, &r}) fill_tiles_with_zeros(skewed, *array);
  Steps<Kind> steps{skewed, kind, diagonal, inverse};
  const linear::System<Real> operators = {
      .multiply = nullptr,
      .precondition = [&](auto, auto z) { return steps.precondition(r, z); },
      .residual = nullptr,
      .refresh = [&](std::span<Real> x, std::span<Real> r) { return refresh(system, steps, q, x, r); },
      .start = start};
  const linear::Solution solution = linear::iterate(steps, operators, right, {x, r, z, p}, settings.stop);
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
