// Solves the system of the pressure by conjugate gradients.
//
// The algorithm and its serial form stand in serial/production_fluid/pressure_solve.cpp. All vectors of the solve are
// in the order of skewed.h, so that the triangular solves take sixteen cells at once with neighbours in the same order
// as ever, and every other operation goes straight through memory. The system comes into that order once, and the
// pressure leaves it whenever it is refreshed.
//
// The contract stands in common/production_fluid/pressure_solve.h.
#include "common/production_fluid/pressure_solve.h"

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "common/linear/iterate.h"
#include "common/real.h"
#include "common/simd.h"
#include "common/simd_double.h"
#include "openmp/production_fluid/factor_order.h"
#include "openmp/production_fluid/prefetch.h"
#include "openmp/production_fluid/skewed.h"
#include "openmp/production_fluid/skewing.h"
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
      const floatv upper_neighbours = row(high_x(d)) + row(high_y(skewed, d, high_x(d), c)) + row(high_z(skewed, d, c));
      const Pivot<floatv> p =
          pivot(load(d), low_x(s), low_y(skewed, s, low_x(s), c), low_z(skewed, s, c), upper_neighbours, tau, sigma);
      store(&inverse[i], p.inverse), store(&share[i], p.share);
    });
  });
  memory.give_back(share);
  return inverse;
}

// A sum of a pass that comes to the parts of a tile one after another: a lane goes on where the part before left it.
class Sum {
 public:
  explicit Sum(const Skewed& skewed) : lines_(skewed.tiles().size(), doublev(0.)), tiles_(lines_.size()) {}

  doublev lines(const Stretch& part) const { return lines_[part.of]; }
  void go_on(const Stretch& part, doublev lines, bool is_last) {
    if (is_last) tiles_[part.of] = reduce_add(lines);
    lines_[part.of] = is_last ? doublev(0.) : lines;
  }
  double total() const {
    double total = 0;
    for (const double tile : tiles_) total += tile;
    return total;
  }

 private:
  std::vector<doublev> lines_;
  std::vector<double> tiles_;
};

// The steps of an iteration (common/linear/iterate.h) in two passes over memory. The first takes the step along A p,
// and solves L y = r on the way: y stands in the place of A p, which it reads for the last time. The second solves
// L^T z = y, and makes x, p and A p at once, A p in the place of z.
template <class Kind>
class Steps {
 public:
  Steps(const Skewed& skewed, const Kind& kind, const Array<Real>& diagonal, const Array<Real>& inverse,
        const linear::Work<Real>& work)
      : skewed_(skewed), kind_(kind), diagonal_(diagonal), inverse_(inverse), work_(work) {}

  // r is not what `descend` left.
  void begin_anew() { rz_.reset(); }

  double precondition() {
    if (!rz_) descend(0);
    return *std::exchange(rz_, std::nullopt);
  }

  double descend(Real a) {
    const auto [x, r, z, p] = work_;
    // The threads share parts as the kind says. A part writes its own cells, and to its tile's sums.
#pragma omp parallel
    kind_.ascending([&](const Stretch& part, const Coupled& c) {
      doublev rr = first_.lines(part), rz = second_.lines(part);
      floatv before = low_x(&z[skewed_.at(part.tile, part.z, part.begin)]);
      for_each_vector(skewed_, part, [&](std::size_t i) {
        Real* const at = &z[i];
        prefetch<ahead>(&inverse_[i], &r[i], at);
        const floatv rest = load(&r[i]) - a * load(at);
        const floatv ey = forward(rest, before, low_y(skewed_, at, before, c), low_z(skewed_, at, c));
        before = ey * load(&inverse_[i]);
        store(&r[i], rest), store(at, before);
        rr = rr + to_double(rest) * to_double(rest);
        rz = rz + to_double(ey) * to_double(before);
      });
      const bool is_last = part.end == skewed_.tiles()[part.of].end;
      first_.go_on(part, rr, is_last), second_.go_on(part, rz, is_last);
    });
    rz_ = second_.total();
    return first_.total();
  }

  double advance(Real a, Real b) {
    const auto [x, r, z, p] = work_;
    const auto direct = [&](const Stretch& part, const Coupled& c) {
      floatv after = load(&z[skewed_.at(part.tile, part.z, part.end)]);
      for_each_vector_backward(skewed_, part, [&](std::size_t i) {
        Real* const at = &z[i];
        prefetch<-ahead>(&inverse_[i], at, &x[i], &p[i]);
        const floatv upper_y = high_y(skewed_, at, after, c), along = load(&p[i]);
        after = backward(load(&inverse_[i]), load(at), after, upper_y, high_z(skewed_, at, c));
        store(at, after);
        store(&x[i], load(&x[i]) + a * along);
        store(&p[i], after + b * along);
      });
    };
    const auto multiply = [&](const Stretch& part) {
      doublev pq = first_.lines(part);
      for_each_vector_backward(skewed_, part, [&](std::size_t i) {
        const Real* const at = &p[i];
        const floatv here = load(at), d = load(&diagonal_[i]);
        prefetch<-ahead>(&diagonal_[i]);
        const floatv row = product(d, here, low_x(at), high_x(at), low_y(skewed_, at), high_y(skewed_, at),
                                   low_z(skewed_, at), high_z(skewed_, at));
        const floatv found = select(d > 0.f, row, 0.f);
        store(&z[i], found);
        pq = pq + to_double(here) * to_double(found);
      });
      first_.go_on(part, pq, part.begin == skewed_.tiles()[part.of].begin);
    };
    // The threads share parts as the kind says. A part writes its own cells, and to its tile's sum.
#pragma omp parallel
    kind_.descending(direct, multiply);
    return first_.total();
  }

 private:
  const Skewed& skewed_;
  const Kind& kind_;
  const Array<Real>&diagonal_, &inverse_;
  const linear::Work<Real> work_;
  Sum first_{skewed_}, second_{skewed_};
  std::optional<double> rz_;  // r . M^-1 r, once y is solved for
};

Array<Real> skew(const Skewed& skewed, const Array<Real>& of_cells, PressureMemory<Real>& memory) {
  Array<Real> to = take_zeros(memory, skewed.size());
  for_each_tile(
      skewed, [&](const Stretch& tile) { fill(skewed, tile, to, [&](std::size_t i) { return load(&of_cells[i]); }); });
  return to;
}

// Adds x to the pressure, sets x to 0, and computes the residual of the pressure.
double refresh(const System<Real>& system, const Skewed& skewed, Array<double>& q, std::span<Real> x,
               std::span<Real> r) {
  for_each_tile(skewed, [&](const Stretch& tile) {
    add(skewed, tile, x, q);
    for_each_vector(skewed, tile, [&](std::size_t i) { store(&x[i], floatv(0.f)); });
  });
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
  const linear::Work<Real> work = {x, r, z, p};
  Steps<Kind> steps(skewed, kind, diagonal, inverse, work);
  const auto refresh_and_begin_anew = [&](std::span<Real> x, std::span<Real> r) {
    steps.begin_anew();
    return refresh(system, skewed, q, x, r);
  };
  const linear::System<Real> operators = {
      .multiply = nullptr, .precondition = nullptr, .residual = nullptr, .refresh = refresh_and_begin_anew};
  const linear::Solution solution = linear::iterate(Vectors{skewed}, operators, right, work, settings.stop, steps);
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
