// Solves the system of the pressure by conjugate gradients.
//
// The algorithm and its serial form stand in serial/production_fluid/pressure_solve.cpp. All vectors of the solve are
// in the order of skewed.h, so that the triangular solves take sixteen cells at once with neighbours in the same order
// as ever, and every other operation goes straight through memory. The system comes into that order once, and the
// pressure leaves it whenever it is refreshed.
//
// The contract stands in common/production_fluid/pressure_solve.h.
#include "common/production_fluid/pressure_solve.h"

#include <vector>

#include "common/linear/iterate.h"
#include "common/real.h"
#include "common/simd.h"
#include "common/simd_double.h"
#include "openmp/production_fluid/guess.h"
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
  void advance(Real a, std::span<const Real> z, Real b, std::span<Real> x, std::span<Real> p) const {
    for_each_tile(skewed, [&](const Stretch& tile) {
      for_each_vector(skewed, tile, [&](std::size_t i) {
        const floatv along = load(&p[i]);
        store(&x[i], load(&x[i]) + a * along);
        store(&p[i], load(&z[i]) + b * along);
      });
    });
  }
  double descend(Real a, std::span<const Real> q, std::span<Real> r) const {
    return sum(skewed, [&](const Stretch& tile) {
      doublev lines = 0.;
      for_each_vector(skewed, tile, [&](std::size_t i) {
        const floatv rest = load(&r[i]) - a * load(&q[i]);
        store(&r[i], rest);
        lines = lines + to_double(rest) * to_double(rest);
      });
      return lines;
    });
  }
};

double multiply(const Skewed& skewed, const Array<Real>& diagonal, std::span<const Real> x, std::span<Real> y) {
  return sum(skewed, [&](const Stretch& tile) {
    doublev lines = 0.;
    for_each_vector(skewed, tile, [&](std::size_t i) {
      const Real* const at = &x[i];
      const floatv here = load(at), d = load(&diagonal[i]);
      prefetch<ahead>(at + skewed.along_z(), &diagonal[i]);
      const floatv row = product(d, here, low_x(at), high_x(at), low_y(skewed, at), high_y(skewed, at),
                                 low_z(skewed, at), high_z(skewed, at));
      const floatv found = select(d > 0.f, row, 0.f);
      store(&y[i], found);
      lines = lines + to_double(here) * to_double(found);
    });
    return lines;
  });
}

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
  template <class F>
  void descending(const F& f) const {
    for (auto parts = skewed.stages().rbegin(); parts != skewed.stages().rend(); ++parts) of_stage(*parts, f);
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
  template <class F>
  void descending(const F& f) const {
    of_blocks([&](const std::vector<Stretch>& block) {
      for (auto part = block.rbegin(); part != block.rend(); ++part) f(*part, coupled(*part));
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

// Neighbours that count; those along x are given. A solve has just found them: they need not come back from memory.
LOCKSTEP_INLINE floatv low_y(const Skewed& skewed, const Real* at, floatv low_x, const Coupled& coupled) {
  return shift_up(low_x, coupled.y ? at[skewed.to_low_tile() + lanes - 1] : 0.f);
}
LOCKSTEP_INLINE floatv high_y(const Skewed& skewed, const Real* at, floatv high_x, const Coupled& coupled) {
  return shift_down(high_x, coupled.y ? at[skewed.to_high_tile()] : 0.f);
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
      const floatv upper_neighbours = row(high_x(d)) + row(high_y(skewed, d, high_x(d), c)) + row(high_z(skewed, d, c));
      const Pivot<floatv> p =
          pivot(load(d), low_x(s), low_y(skewed, s, low_x(s), c), low_z(skewed, s, c), upper_neighbours, tau, sigma);
      store(&inverse[i], p.inverse), store(&share[i], p.share);
    });
  });
  memory.give_back(share);
  return inverse;
}

// A sum over all cells in a pass that comes to the parts of a tile one after another: a lane goes on where the part
// before left it.
class Sum {
 public:
  explicit Sum(const Skewed& skewed)
      : skewed_(skewed), lines_(skewed.tiles().size(), doublev(0.)), tiles_(lines_.size()) {}

  doublev lines(const Stretch& part) const { return lines_[part.of]; }
  void go_on(const Stretch& part, doublev lines) {
    lines_[part.of] = lines;
    if (part.end == skewed_.tiles()[part.of].end) tiles_[part.of] = reduce_add(lines);
  }
  double total() const {
    double total = 0;
    for (const double tile : tiles_) total += tile;
    return total;
  }

 private:
  const Skewed& skewed_;
  std::vector<doublev> lines_;
  std::vector<double> tiles_;
};

// z = M^-1 r. Returns r . z.
template <class Kind>
double precondition(const Skewed& skewed, const Kind& kind, const Array<Real>& inverse, std::span<const Real> r,
                    std::span<Real> z) {
  Sum rz(skewed);
  // The threads share parts as the kind says. A part writes its own cells, and its tile's sums.
#pragma omp parallel
  {
    kind.ascending([&](const Stretch& part, const Coupled& c) {
      doublev lines = rz.lines(part);
      floatv y = low_x(&z[skewed.at(part.tile, part.z, part.begin)]);  // of the vector before
      for_each_vector(skewed, part, [&](std::size_t i) {
        Real* const at = &z[i];
        prefetch<ahead>(&inverse[i], &r[i]);
        const floatv ey = forward(load(&r[i]), y, low_y(skewed, at, y, c), low_z(skewed, at, c));
        y = ey * load(&inverse[i]);
        store(at, y);
        lines = lines + to_double(ey) * to_double(y);
      });
      rz.go_on(part, lines);
    });
    kind.descending([&](const Stretch& part, const Coupled& c) {
      floatv after = load(&z[skewed.at(part.tile, part.z, part.end)]);
      for_each_vector_backward(skewed, part, [&](std::size_t i) {
        Real* const at = &z[i];
        prefetch<-ahead>(&inverse[i], at);
        after = backward(load(&inverse[i]), load(at), after, high_y(skewed, at, after, c), high_z(skewed, at, c));
        store(at, after);
      });
    });
  }
  return rz.total();
}

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
  const auto start = start_of(system, settings.guess, memory, q);
  const Skewed skewed(system);
  const Kind kind{skewed};
  Array<Real> diagonal = skew(skewed, system.diagonal, memory), right = skew(skewed, system.right, memory),
              inverse = make_inverses(skewed, kind, diagonal, settings.modification, memory);
  const linear::System<Real> operators = {
      .multiply = [&](std::span<const Real> x, std::span<Real> y) { return multiply(skewed, diagonal, x, y); },
      .precondition = [&](auto r, auto z) { return precondition(skewed, kind, inverse, r, z); },
      .residual = nullptr,
      .refresh = [&](std::span<Real> x, std::span<Real> r) { return refresh(system, skewed, q, x, r); },
      .start = start};
  const auto zeros = [&] { return take_zeros(memory, skewed.size()); };
  Array<Real> x = zeros(), r = zeros(), z = zeros(), p = zeros();
  const linear::Solution solution = linear::iterate(Vectors{skewed}, operators, right, {x, r, z, p}, settings.stop);
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
