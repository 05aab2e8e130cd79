// Solves the system of the pressure by conjugate gradients.
//
// The algorithm and its serial form stand in serial/production_fluid/pressure_solve.cpp. All vectors of the solve are
// in the order of skewed.h, so that the triangular solves take sixteen cells at once with neighbours in the same order
// as ever. An iteration goes through memory twice. The system comes into that order once, and the pressure leaves it
// whenever it is refreshed.
//
// The contract stands in common/production_fluid/pressure_solve.h.
#include "common/production_fluid/pressure_solve.h"

#include <algorithm>
#include <vector>

#include "common/linear/iterate.h"
#include "common/real.h"
#include "common/simd.h"
#include "common/simd_double.h"
#include "openmp/production_fluid/guess.h"
#include "openmp/production_fluid/skewed.h"
#include "openmp/production_fluid/skewing.h"
#include "openmp/production_fluid/solve_order.h"

namespace lockstep::production_fluid::openmp {
namespace {

// Calls f(i) for each vector of a part, in order; i is where it stands.
template <class F>
LOCKSTEP_INLINE void for_each_vector(const Skewed& skewed, const Stretch& part, const F& f) {
  const std::ptrdiff_t begin = skewed.at(part.tile, part.begin), end = skewed.at(part.tile, part.end);
  for (std::ptrdiff_t i = begin; i < end; i += lanes) f(i);
}

// Calls f(part) for each part.
template <class F>
void for_each_part(const Skewed& skewed, const F& f) {
  const std::ptrdiff_t count = std::ssize(skewed.parts());
  // What f writes belongs to its part.
#pragma omp parallel for schedule(static)
  for (std::ptrdiff_t k = 0; k < count; ++k) f(skewed.parts()[k]);
}

// A sum over all cells. A lane adds up its plane vector by vector, from part to part of a tile. Lanes without a row add
// 0 to a sum that began at 0, which changes no bit.
class Sum {
 public:
  explicit Sum(const Skewed& skewed) : of_tiles_(skewed.tiles()) {}

  void start() { std::ranges::fill(of_tiles_, doublev(0.)); }
  doublev& of(const Stretch& part) { return of_tiles_[part.tile]; }
  double total() const {
    double total = 0;
    for (const doublev& planes : of_tiles_) total += reduce_add(planes);
    return total;
  }

 private:
  std::vector<doublev> of_tiles_;
};

// Rows of A x, of the sixteen cells at i. `along_y` is how far their neighbours along y stand.
LOCKSTEP_INLINE floatv row_times(const Real* diagonal, const Real* x, const OuterLanes& outer, std::ptrdiff_t along_y,
                                 std::size_t i) {
  const Real* const at = x + i;
  const floatv d = load(diagonal + i), low_x = load(at - lanes), high_x = load(at + lanes);
  return select(d > 0.f,
                product(d, load(at), low_x, high_x, load(at - along_y), load(at + along_y), outer.low_z(i, low_x),
                        outer.high_z(i, high_x)),
                0.f);
}

// --- Arrays

// An array that is 0 in all parts, and where neighbours of their cells are read.
Array<Real> take_zeros(const Skewed& skewed, PressureMemory<Real>& memory) {
  Array<Real> array = memory.take(skewed.size());
  // A tile writes between its own bounds.
#pragma omp parallel for schedule(static)
  for (int tile = 0; tile < skewed.tiles(); ++tile) {
    std::ptrdiff_t done = skewed.at(tile, 0);
    for (const Stretch& part : skewed.parts(tile)) {
      if (part.begin == part.end) continue;
      const std::ptrdiff_t end = skewed.at(tile, part.end) + skewed.along_y();
      for (std::ptrdiff_t i = std::max(done, skewed.at(tile, part.begin) - skewed.along_y()); i < end; i += lanes)
        store(&array[i], floatv(0.f));
      done = end;
    }
  }
  return array;
}

void fill_parts_with_zeros(const Skewed& skewed, std::span<Real> x) {
  for_each_part(skewed, [&](const Stretch& part) {
    for_each_vector(skewed, part, [&](std::size_t i) { store(&x[i], floatv(0.f)); });
  });
}

// Fills all parts with values of cells.
void skew(const Skewed& skewed, const Array<Real>& of_cells, Array<Real>& to) {
  for_each_part(
      skewed, [&](const Stretch& part) { fill(skewed, part, to, [&](std::size_t i) { return load(&of_cells[i]); }); });
}

// --- The factor

// 1 / e of all cells.
template <class Kind>
Array<Real> make_inverses(const Skewed& skewed, const Kind& kind, const Array<Real>& diagonal,
                          const linear::Modification& modification, PressureMemory<Real>& memory) {
  const floatv tau = static_cast<Real>(modification.tau), sigma = static_cast<Real>(modification.sigma);
  Array<Real> inverse = memory.take(skewed.size()), share = take_zeros(skewed, memory);
  Array<Real> outer_diagonal = memory.take_zeros(skewed.outer_size()),
              outer_share = memory.take_zeros(skewed.outer_size());
  const OuterLanes of_diagonal(skewed, outer_diagonal), of_share(skewed, outer_share);
  // Outer lanes stay 0 where tiles have a factor each.
  if constexpr (Kind::are_tiles_coupled)
    for_each_part(skewed, [&](const Stretch& part) {
      for_each_vector(skewed, part, [&](std::size_t i) { of_diagonal.set_first(i, &diagonal[i]); });
    });
  const std::ptrdiff_t along_y = skewed.along_y();
  // A part writes its own cells.
  kind.ascending([&](const Stretch& part) {
    for_each_vector(skewed, part, [&](std::size_t i) {
      const auto row = [](floatv d) { return select(d > 0.f, floatv(1.f), floatv(0.f)); };
      const Real *const d = &diagonal[i], *const s = &share[i];
      const floatv high_x = load(d + lanes), low_x = load(s - lanes);
      const floatv upper_neighbours = row(high_x) + row(load(d + along_y)) + row(of_diagonal.high_z(i, high_x));
      const Pivot<floatv> p =
          pivot(load(d), low_x, load(s - along_y), of_share.low_z(i, low_x), upper_neighbours, tau, sigma);
      store(&inverse[i], p.inverse), store(&share[i], p.share);
      if constexpr (Kind::are_tiles_coupled) of_share.set_last(i, s);
    });
  });
  for (Array<Real>* array : {&share, &outer_diagonal, &outer_share}) memory.give_back(*array);
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
  OuterLanes outer_of_z, outer_of_p;  // of z: 0 where tiles have a factor each
  Sum sum_rr{skewed}, sum_rz{skewed}, sum_pq{skewed};
  bool is_solved = false;  // the first triangular solve, of r

  double dot(std::span<const Real> x, std::span<const Real> y) const {
    Sum sum(skewed);
    // A tile adds to its own sum.
#pragma omp parallel for schedule(dynamic)
    for (int tile = 0; tile < skewed.tiles(); ++tile)
      for (const Stretch& part : skewed.parts(tile)) {
        doublev xy = sum.of(part);
        for_each_vector(skewed, part,
                        [&](std::size_t i) { xy = xy + to_double(load(&x[i])) * to_double(load(&y[i])); });
        sum.of(part) = xy;
      }
    return sum.total();
  }
  void axpy(Real a, std::span<const Real> x, std::span<Real> y) const {
    for_each_part(skewed, [&](const Stretch& part) {
      for_each_vector(skewed, part, [&](std::size_t i) { store(&y[i], load(&y[i]) + a * load(&x[i])); });
    });
  }

  // z holds q, then y of the new r.
  double descend(Real a, std::span<Real> z, std::span<Real> r) {
    sum_rr.start(), sum_rz.start();
    // A part writes its own cells, and its tile's sums.
    kind.ascending([&, a](const Stretch& part) {
      if (part.begin == part.end) return;
      // In registers: the compiler must assume that stores of lanes change what stands in memory.
      Real *const zs = z.data(), *const rs = r.data();
      const Real* const inverses = inverse.data();
      const OuterLanes outer_z = outer_of_z;
      const std::ptrdiff_t along_y = skewed.along_y();
      doublev rr = sum_rr.of(part), rz = sum_rz.of(part);
      floatv y = load(zs + skewed.at(part.tile, part.begin) - lanes);  // of the vector before
      for_each_vector(skewed, part, [&](std::size_t i) {
        const floatv rest = load(rs + i) - a * load(zs + i);
        store(rs + i, rest);
        rr = rr + to_double(rest) * to_double(rest);
        const floatv ey = forward(rest, y, load(zs + i - along_y), outer_z.low_z(i, y));
        y = ey * load(inverses + i);
        store(zs + i, y);
        if constexpr (Kind::are_tiles_coupled) outer_z.set_last(i, zs + i);
        rz = rz + to_double(ey) * to_double(y);
      });
      sum_rr.of(part) = rr, sum_rz.of(part) = rz;
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
    sum_pq.start();
    // A part writes its own cells, and its tile's sum.
    kind.descending([&, a, b](const Stretch& part, const Stretch& ready) {
      Real *const zs = z.data(), *const xs = x.data(), *const ps = p.data();
      const Real *const inverses = inverse.data(), *const diagonals = diagonal.data();
      const OuterLanes outer_z = outer_of_z, outer_p = outer_of_p;
      const std::ptrdiff_t along_y = skewed.along_y();
      const bool is_part = part.begin < part.end, is_ready = ready.begin < ready.end;
      const std::ptrdiff_t end = skewed.at(part.tile, part.end), size = end - skewed.at(part.tile, part.begin);
      const std::ptrdiff_t end_ready = skewed.at(ready.tile, ready.end),
                           size_ready = end_ready - skewed.at(ready.tile, ready.begin);
      floatv after = is_part ? load(zs + end) : floatv(0.f);  // z of the vector after
      doublev pq = is_ready ? sum_pq.of(ready) : doublev(0.);
      // In turns: a vector of the solve waits for the one before and for memory, the product for neither.
      constexpr std::ptrdiff_t turn = 4 * lanes;
      for (std::ptrdiff_t k = 0; k < std::max(size, size_ready); k += turn) {
        for (std::ptrdiff_t j = k + lanes; j <= std::min(k + turn, size); j += lanes) {
          const std::size_t i = end - j;
          after = backward(load(inverses + i), load(zs + i), after, load(zs + i + along_y), outer_z.high_z(i, after));
          store(zs + i, after);
          if constexpr (Kind::are_tiles_coupled) outer_z.set_first(i, zs + i);
          const floatv along = load(ps + i);
          store(xs + i, load(xs + i) + a * along);
          store(ps + i, after + b * along);
          outer_p.set_first(i, ps + i), outer_p.set_last(i, ps + i);
        }
        for (std::ptrdiff_t j = k + lanes; j <= std::min(k + turn, size_ready); j += lanes) {
          const std::size_t i = end_ready - j;
          const floatv q = row_times(diagonals, ps, outer_p, along_y, i);
          store(zs + i, q);
          pq = pq + to_double(load(ps + i)) * to_double(q);
        }
      }
      if (is_ready) sum_pq.of(ready) = pq;
    });
    return sum_pq.total();
  }
};

// Adds x to the pressure, sets x to 0, and computes the residual of the pressure.
template <class Kind>
double refresh(const System<Real>& system, Steps<Kind>& steps, Array<double>& q, std::span<Real> x, std::span<Real> r) {
  const Skewed& skewed = steps.skewed;
  steps.is_solved = false;  // r becomes another
  for_each_part(skewed, [&](const Stretch& part) { move(skewed, part, x, q); });
  const std::ptrdiff_t line = system.cells.line(), plane = system.cells.plane();
  for_each_part(skewed, [&](const Stretch& part) {
    fill(skewed, part, r, [&](std::size_t i) {
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
  // Arrays whose neighbours are read are 0 around the parts. The others are only read within them.
  Array<Real> diagonal = take_zeros(skewed, memory), right = memory.take(skewed.size());
  skew(skewed, system.diagonal, diagonal), skew(skewed, system.right, right);
  Array<Real> inverse = make_inverses(skewed, kind, diagonal, settings.modification, memory);
  Array<Real> x = memory.take(skewed.size()), r = memory.take(skewed.size()), z = take_zeros(skewed, memory),
              p = take_zeros(skewed, memory);
  for (Array<Real>* array : {&x, &r}) fill_parts_with_zeros(skewed, *array);
  Array<Real> outer_z = memory.take_zeros(skewed.outer_size()), outer_p = memory.take_zeros(skewed.outer_size());
  Steps<Kind> steps{skewed, kind, diagonal, inverse, {skewed, outer_z}, {skewed, outer_p}};
  const linear::System<Real> operators = {
      .multiply = nullptr,
      .precondition = [&](auto, auto z) { return steps.precondition(r, z); },
      .residual = nullptr,
      .refresh = [&](std::span<Real> x, std::span<Real> r) { return refresh(system, steps, q, x, r); },
      .start = start};
  const linear::Solution solution = linear::iterate(steps, operators, right, {x, r, z, p}, settings.stop);
  for (Array<Real>* array : {&diagonal, &right, &inverse, &x, &r, &z, &p, &outer_z, &outer_p}) memory.give_back(*array);
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
