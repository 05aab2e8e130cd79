// The solve for the pressure, as the verifier and the benchmark see it: bitwise with the serial twin, iteration by
// iteration, and a true residual, computed in double, within the tolerance.
#include "common/production_fluid/pressure_solve.h"

#include <cstdio>

#include "verify/production_fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify {

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

constexpr PressureSettings settings = {.modification = {.tau = .97, .sigma = .25},
                                       .stop = {.tolerance = 1e-6, .iterations = 1000}};

// An iteration multiplies by A and by M^-1, takes three dot products, and updates three vectors. Bytes: of the product
// three vectors, of the two solves five, of r . z two, of x and p five, of r three.
Work work_of(double liquid, int iterations) {
  return {liquid * iterations, "cells", liquid * iterations * 4 * 18, liquid * iterations * (9. + 9 + 6 + 6)};
}

Case make(const std::string& path, PressureSolve<float>* serial, PressureSolve<float>* openmp) {
  const auto in = inputs(path);
  Pressure start = {Array<double>(in->system.cells.size()), Array<double>(3)};
  poison(start);
  const auto with = [in](PressureSolve<float>* solve) {
    return [in, solve](Pressure& p) {
      const linear::Solution s = solve(in->system, settings, p.q);
      p.number = {double(s.iterations), s.recursive_residual, s.true_residual};
    };
  };
  Pressure solved = start;
  with(openmp)(solved);
  return make_case<Pressure>({
      .start = std::make_shared<const Pressure>(std::move(start)),
      .serial = with(serial),
      .best_serial = nullptr,
      .openmp = with(openmp),
      .compare =
          [](const Pressure& openmp, const Pressure& serial) {
            Judgement judgement = bitwise(openmp, serial);
            if (!judgement.passed) return judgement;
            char text[100];
            std::snprintf(text, sizeof text, "%.0f iterations, |r|/|b| %.2e, true %.2e of at most %.2e",
                          openmp.number[0], openmp.number[1], openmp.number[2], settings.stop.tolerance);
            judgement.worst_at = text;
            judgement.passed = openmp.number[2] <= settings.stop.tolerance;
            return judgement;
          },
      .work = work_of(liquid_cells_of(*in), static_cast<int>(solved.number[0])),
  });
}

const Register pressure_solve{{.name = "production_fluid/pressure_solve",
                               .place = 2,
                               .serial_forms = {"mic"},
                               .forms = {{.name = "mic",
                                          .make =
                                              [](const std::string& path) {
                                                return make(path, serial::pressure_solve_mic,
                                                            openmp::pressure_solve_mic);
                                              },
                                          .scenes = pressure_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify
