// The solve for the pressure, as the verifier and the benchmark see it: bitwise with the serial twin, iteration by
// iteration, and a true residual, computed in double, within the tolerance.
#include "common/production_fluid/pressure_solve.h"

#include <cstdio>

#include "verify/production_fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_pressure_solve {

// What a solve changes: the pressure; iterations, |r| / |b| as the iteration has it, and the true one.
struct Pressure {
  Array<double> q, number;
};
template <Same<Pressure> P, class F>
void for_each_array(P& pressure, const F& f) {
  f("q", pressure.q, pressure.q.size());
  f("number", pressure.number, pressure.number.size());
}

namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

// An iteration multiplies by A and by M^-1, takes three dot products, and updates three vectors. Bytes are those of
// openmp's two passes, thirteen values a cell: of the first, r, and y in the place of A p, each read and written, and
// 1 / e; of the second, x, p, and A p in the place of y, each read and written, 1 / e and the diagonal. The data are
// taken to be as many: a vector counts each time that it is read, since arrays have places without cells, too, which
// are not counted.
Work work_with_factor(double liquid, int iterations) {
  const double bytes = 4 * 13;
  return {liquid * iterations, "cells", liquid * iterations * bytes, liquid * iterations * (9. + 9 + 6 + 6), 0,
          liquid * bytes};
}

// The same with a cycle in place of the two solves, which sums r . z in its last sweep. Bytes: of the first guess three
// vectors, of the residual four, of restriction one, of correction three, of Jacobi's iteration four. Coarser grids add
// a seventh. The band is thin, and does not count.
Work work_with_cycle(double liquid, int iterations) {
  const double bytes = 4 * (3. + 5 + 3 + 8. / 7 * (3 + 4 + 1 + 3 + 4)),
               flops = 9. + 6 + 6 + 8. / 7 * (2 + 9 + 6 + 7 + 11);
  return {liquid * iterations, "cells", liquid * iterations * bytes, liquid * iterations * flops, 0, liquid * bytes};
}

// Adds to a comparison how the solve went, and asks that it converged.
void require_convergence(Judgement& judgement, const Pressure& openmp, const Pressure& serial) {
  if (!judgement.passed) return;
  char text[160];
  std::snprintf(text, sizeof text, "%.0f iterations, |r|/|b| %.2e, true %.2e of at most %.2e", openmp.number[0],
                openmp.number[1], openmp.number[2], pressure_settings.stop.tolerance);
  judgement.worst_at = text;
  if (judgement.verdict == Verdict::converged)
    judgement.worst_at += "; serial mic " + std::to_string(static_cast<int>(serial.number[0])) + " iterations";
  judgement.passed = openmp.number[2] <= pressure_settings.stop.tolerance;
}

Judgement same_solve(const Pressure& openmp, const Pressure& serial) {
  Judgement judgement = bitwise(openmp, serial);
  require_convergence(judgement, openmp, serial);
  return judgement;
}

// Another preconditioner, and so another number of iterations.
Judgement same_answer(const Pressure& openmp, const Pressure& serial) {
  Judgement judgement{.verdict = Verdict::converged,
                      .error = openmp.number[2],
                      .bound = pressure_settings.stop.tolerance,
                      .worst_at = ""};
  require_convergence(judgement, openmp, serial);
  return judgement;
}

// What an earlier substep might have left: nearly the solution, and pressure in cells that have no row now.
constexpr double factor_of_guess = .9;
Array<double> guess(const Inputs& in, const Array<double>& solution) {
  Array<double> q = solution;
  const Bordered& cells = in.system.cells;
  for (int z = 0; z < cells.nz; ++z)
    for (int y = 0; y < cells.ny; ++y)
      for (int x = 0; x < cells.nx; ++x) {
        const std::size_t i = cells.index(x, y, z);
        if (!(in.system.diagonal[i] > 0)) q[i] = 1;
      }
  return q;
}

Case make(const std::string& path, PressureSolve<float>* serial, PressureSolve<float>* openmp,
          Judgement (*compare)(const Pressure& openmp, const Pressure& serial),
          Work (*work_of)(double liquid, int iterations) = work_with_factor, bool from_guess = false) {
  const auto in = inputs(path);
  Pressure start = {Array<double>(in->system.cells.size()), Array<double>(3)};
  poison(start);
  if (from_guess) start.q = guess(*in, *pressure(path));
  PressureSettings settings = pressure_settings;
  if (from_guess) settings.guess = factor_of_guess;
  const auto with = [in, settings](PressureSolve<float>* solve) {
    return [in, settings, solve, memory = std::make_shared<PressureMemory<float>>()](Pressure& p) {
      const linear::Solution s = solve(in->system, settings, *memory, p.q);
      p.number = {double(s.iterations), s.recursive_residual, s.true_residual};
    };
  };
  // Of the serial forms, mic is the fastest on some scenes and multigrid on others.
  PressureSolve<float>*const mic = serial::pressure_solve_mic, *const block_mic = serial::pressure_solve_block_mic;
  Pressure solved = start;
  with(openmp)(solved);
  return make_case<Pressure>({
      .start = std::make_shared<const Pressure>(std::move(start)),
      .serial = with(serial),
      .best_serial = serial == block_mic ? with(mic) : std::function<void(Pressure&)>(),
      .openmp = with(openmp),
      .compare = compare,
      .work = work_of(liquid_cells_of(*in), static_cast<int>(solved.number[0])),
  });
}

const Register pressure_solve{
    {.name = "production_fluid/pressure_solve",
     .place = 5,
     .serial_forms = {"mic", "block_mic", "multigrid"},
     .forms = {{.name = "mic",
                .make =
                    [](const std::string& path) {
                      return make(path, serial::pressure_solve_mic, openmp::pressure_solve_mic, same_solve);
                    },
                .scenes = pressure_scenes()},
               {.name = "block_mic",
                .make =
                    [](const std::string& path) {
                      return make(path, serial::pressure_solve_block_mic, openmp::pressure_solve_block_mic, same_solve);
                    },
                .scenes = pressure_scenes()},
               {.name = "mic_from_guess",
                .make =
                    [](const std::string& path) {
                      return make(path, serial::pressure_solve_mic, openmp::pressure_solve_mic, same_solve,
                                  work_with_factor, true);
                    },
                .scenes = {.verify = {"drop_64", "obstacle_48", "full_box", "two_pockets"},
                           .more = {"drop_128"},
                           .bench = {},
                           .tsan = {}},
                .covered_by = "mic"},
               {.name = "block_mic_from_guess",
                .make =
                    [](const std::string& path) {
                      return make(path, serial::pressure_solve_block_mic, openmp::pressure_solve_block_mic, same_solve,
                                  work_with_factor, true);
                    },
                .scenes = {.verify = {"drop_64", "obstacle_48", "full_box", "two_pockets"},
                           .more = {"drop_128"},
                           .bench = {},
                           .tsan = {}},
                .covered_by = "block_mic"},
               {.name = "block_mic_for_mic",
                .make =
                    [](const std::string& path) {
                      return make(path, serial::pressure_solve_mic, openmp::pressure_solve_block_mic, same_answer);
                    },
                .scenes = {.verify = {"drop_64", "obstacle_48"}, .more = {"drop_128"}, .bench = {}, .tsan = {}},
                .covered_by = "block_mic"},
               {.name = "multigrid",
                .make =
                    [](const std::string& path) {
                      return make(path, serial::pressure_solve_multigrid, openmp::pressure_solve_multigrid, same_solve,
                                  work_with_cycle);
                    },
                .scenes = pressure_scenes()},
               {.name = "multigrid_from_guess",
                .make =
                    [](const std::string& path) {
                      return make(path, serial::pressure_solve_multigrid, openmp::pressure_solve_multigrid, same_solve,
                                  work_with_cycle, true);
                    },
                .scenes = {.verify = {"drop_64", "obstacle_48", "full_box", "two_pockets"},
                           .more = {"drop_128"},
                           .bench = {},
                           .tsan = {}},
                .covered_by = "multigrid"},
               {.name = "multigrid_for_mic",
                .make =
                    [](const std::string& path) {
                      return make(path, serial::pressure_solve_mic, openmp::pressure_solve_multigrid, same_answer,
                                  work_with_cycle);
                    },
                .scenes =
                    {.verify = {"drop_64", "obstacle_48"}, .more = {"drop_128", "drop_256"}, .bench = {}, .tsan = {}},
                .covered_by = "multigrid"}}}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_pressure_solve
