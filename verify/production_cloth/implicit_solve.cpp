// The implicit step, as the verifier and the benchmark see it: bitwise with the serial twin, matrix, right-hand side
// and velocities; and the true residual is what rounding explains.
#include "common/production_cloth/implicit_solve.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/production_cloth/forces.h"
#include "common/production_cloth/masses.h"
#include "verify/production_cloth/deformed.h"
#include "verify/twin.h"

namespace lockstep::production_cloth {

// What a step changes: velocities; iterations, and |r| / |b|. The matrix and the right-hand side stand in the memory of
// each version, and are compared besides.
struct ImplicitStep {
  Vectors<float> velocity;
  Array<double> number;
};

template <Same<ImplicitStep> S, class F>
void for_each_array(S& step, const F& f) {
  f("velocity", step.velocity, step.velocity.x.size());
  f("number", step.number, step.number.size());
}

struct ImplicitSystem {
  Array<float> matrix, b, x;
};

template <Same<ImplicitSystem> S, class F>
void for_each_array(S& system, const F& f) {
  f("matrix", system.matrix, system.matrix.size());
  f("b", system.b, system.b.size());
  f("x", system.x, system.x.size());
}

}  // namespace lockstep::production_cloth

namespace lockstep::verify::production_cloth_implicit_solve {
namespace {

using namespace production_cloth;
using namespace production_cloth_inputs;

struct ImplicitInputs {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Elements<float>> elements;
  Vectors<float> position, force;
  Array<float> mass, inverse_mass;
  float time_step;
  linear::Stop stop;
};

// A quarter of a frame, whatever explicit forces would need.
std::shared_ptr<const ImplicitInputs> implicit_inputs(const std::string& path) {
  const auto in = std::make_shared<ImplicitInputs>();
  in->scene = inputs(path), in->elements = elements_of(*in->scene);
  in->position = deformed_positions(*in->scene);
  State<float> state = production_cloth::serial::make_state(*in->elements);
  in->force.resize(in->elements->vertices);
  production_cloth::serial::forces(*in->elements, in->position, state, in->force);
  for (const double m : lumped_masses(in->scene->topology, in->scene->rest, in->scene->material.density))
    in->mass.push_back(static_cast<float>(m));
  in->inverse_mass = inverse_masses(*in->scene);
  in->time_step = static_cast<float>(.25 * in->scene->frame_time);
  in->stop = {.tolerance = in->scene->tolerance, .iterations = 1000};
  return in;
}

// The residual that rounding leaves beside the recursive one, of |b|: each iteration rounds x and r, and a product the
// sums of its rows. u (iterations + blocks of a row) times |A| |x|, of absolute values, covers them.
double attainable(const linear::BlockRows<float>& a, const Array<float>& b, const Array<float>& x, int iterations) {
  double squares = 0, bb = 0;
  int longest = 0;
  for (int i = 0; i < a.rows; ++i) {
    longest = std::max(longest, a.begin[i + 1] - a.begin[i]);
    for (int r = 0; r < 3; ++r) {
      double sum = 0;
      for (std::size_t k = a.begin[i]; k < std::size_t(a.begin[i + 1]); ++k)
        for (int c = 0; c < 3; ++c)
          sum += std::abs(double(a.value[9 * k + 3 * r + c]) * x[3 * std::size_t(a.column[k]) + c]);
      squares += sum * sum;
    }
  }
  for (const float e : b) bb += double(e) * e;
  return bb > 0 ? unit_roundoff * (iterations + 3 * longest) * std::sqrt(squares / bb) : 0;
}

// Adds how the solve went, and asks that it converged, in truth as well.
void require_convergence(const ImplicitInputs& in, const SerialImplicitMemory& memory, const ImplicitStep& step,
                         Judgement& judgement) {
  const std::span<const float> b = memory.b, x = memory.x;
  double bb = 0;
  for (const float e : b) bb += double(e) * e;
  const double truth = bb > 0 ? linear::residual_norm(memory.matrix, b, x) / std::sqrt(bb) : 0;
  const double bound = step.number[1] + attainable(memory.matrix, memory.b, memory.x, static_cast<int>(step.number[0]));
  char text[120];
  std::snprintf(text, sizeof text, "%.0f iterations, |r|/|b| %.2e, true %.2e of at most %.2e", step.number[0],
                step.number[1], truth, bound);
  judgement.worst_at = text;
  judgement.passed = step.number[1] <= in.stop.tolerance && truth <= bound;
}

// An iteration multiplies by A and by M^-1, takes three dot products, and updates three vectors of three numbers a
// vertex. Of what it reads and writes, the matrices apart: the products two vectors each, p . q two, r . z two, x and p
// five, r three; these are five vectors. Assembly, of which a block takes about 60 operations, is counted by what it
// writes of A.
Work work_of(const ImplicitInputs& in, const OpenmpImplicitMemory& memory, int iterations) {
  const double rows = 3. * in.elements->vertices, blocks = memory.pattern.blocks();
  return {double(in.elements->vertices) * iterations, "vertices",
          iterations * (linear::bytes_of(memory.matrix) + linear::bytes_of(memory.inverse) + 4 * rows * 16) +
              4. * double(memory.matrix.value.size()),
          iterations * (18 * (blocks + rows / 3) + 12 * rows) + 60 * blocks,
          blocks / double(memory.matrix.column.size()),
          linear::bytes_of(memory.matrix) + linear::bytes_of(memory.inverse) + 4 * rows * 5};
}

Case make(const std::string& path) {
  const auto in = implicit_inputs(path);
  const ImplicitStep start = {shaken_velocities(*in->scene), Array<double>(2)};
  const auto serial_memory = std::make_shared<SerialImplicitMemory>(
      production_cloth::serial::make_implicit_memory(*in->elements, in->inverse_mass));
  const auto openmp_memory = std::make_shared<OpenmpImplicitMemory>(
      production_cloth::openmp::make_implicit_memory(*in->elements, in->inverse_mass));
  const auto step = [in](ImplicitStep& s, auto* solve, auto& memory) {
    const linear::Solution solution =
        solve(*in->elements, in->position, in->mass, in->time_step, in->force, in->stop, s.velocity, memory);
    s.number = {double(solution.iterations), solution.recursive_residual};
  };
  ImplicitSolve<float, linear::BlockRows<float>>* const serial_solve = production_cloth::serial::implicit_solve;
  ImplicitStep once = start;
  step(once, serial_solve, *serial_memory);
  return make_case<ImplicitStep>({
      .start = std::make_shared<const ImplicitStep>(start),
      .serial = [=](ImplicitStep& s) { step(s, serial_solve, *serial_memory); },
      .best_serial = nullptr,
      .openmp = [=](ImplicitStep& s) { step(s, production_cloth::openmp::implicit_solve, *openmp_memory); },
      .compare =
          [=](const ImplicitStep& openmp, const ImplicitStep& serial) {
            const linear::SlicedBlockRows sliced = linear::slice(serial_memory->matrix);
            Judgement judgement =
                bitwise(ImplicitSystem{openmp_memory->matrix.value, openmp_memory->b, openmp_memory->x},
                        ImplicitSystem{sliced.value, serial_memory->b, serial_memory->x});
            if (judgement.passed) judgement = bitwise(openmp, serial);
            if (judgement.passed) require_convergence(*in, *serial_memory, openmp, judgement);
            return judgement;
          },
      .work = work_of(*in, *openmp_memory, static_cast<int>(once.number[0])),
  });
}

const Register implicit_solve{
    {.name = "production_cloth/implicit_solve", .place = 2, .forms = {{.make = make, .scenes = material_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_cloth_implicit_solve
