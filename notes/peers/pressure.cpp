#include "notes/peers/pressure.h"

#include <cmath>
#include <vector>

#include "verify/production_fluid/inputs.h"

namespace lockstep::peers {
namespace {

using namespace production_fluid;

Problem problem_of(const System<float>& system, double tolerance) {
  Problem problem{system, {}, {}, tolerance};
  std::vector<int> number(system.cells.size(), -1);
  linear::Rows<double>& matrix = problem.matrix;
  for_each_run(system, [&](std::size_t first, int count, int) {
    for (int k = 0; k < count; ++k) number[first + k] = matrix.rows++;
  });
  matrix.columns = matrix.rows;
  const std::ptrdiff_t line = system.cells.line(), plane = system.cells.plane();
  const std::ptrdiff_t steps[] = {-plane, -line, -1, 0, 1, line, plane};
  for_each_run(system, [&](std::size_t first, int count, int) {
    for (int k = 0; k < count; ++k) {
      const std::ptrdiff_t cell = first + k;
      for (const std::ptrdiff_t step : steps)
        if (const int column = number[cell + step]; column >= 0) {
          matrix.column.push_back(column);
          matrix.value.push_back(step == 0 ? system.diagonal[cell] : -1.);
        }
      matrix.begin.push_back(static_cast<std::int32_t>(matrix.column.size()));
      problem.right.push_back(system.right[cell]);
    }
  });
  return problem;
}

// |b - A x| / |b|
double residual(const Problem& problem, const Array<double>& x) {
  const linear::Rows<double>& a = problem.matrix;
  double left = 0, all = 0;
  for (int i = 0; i < a.rows; ++i) {
    double r = problem.right[i];
    for (int k = a.begin[i]; k < a.begin[i + 1]; ++k) r -= a.value[k] * x[a.column[k]];
    left += r * r, all += problem.right[i] * problem.right[i];
  }
  return std::sqrt(left / all);
}

Array<double> numbered(const System<float>& system, const Array<double>& q) {
  Array<double> x;
  for_each_run(system, [&](std::size_t first, int count, int) { x.insert(x.end(), &q[first], &q[first] + count); });
  return x;
}

}  // namespace

void compare_solvers(Json& rows, const Asked& asked, const std::string& form, PressureSolve<float>* ours,
                     const MakeSolver& make, const std::string& not_the_same, bool held) {
  for (const std::string& name : asked.scenes) {
    const auto in = verify::production_fluid_inputs::inputs(path_of("production_fluid", name));
    const PressureSettings& settings = verify::production_fluid_inputs::pressure_settings;
    const Problem problem = problem_of(in->system, settings.stop.tolerance);
    for (const int threads : asked.threads) {
      const std::function<Answer()> solver = make(problem, threads);
      Answer answer;
      linear::Solution solution;
      PressureMemory<float> memory;
      Array<double> q;
      Json row = {{"work", "the pressure of a liquid"},
                  {"scene", in->scene.name},
                  {"ours", "production_fluid/pressure_solve " + form},
                  {"items", {{"unknowns", problem.matrix.rows}}}};
      row.update(take_turns(threads, 1, {[] {}, [&] { answer = solver(); }, held},
                            {[] {}, [&] { solution = ours(in->system, settings, memory, q); }}));
      row["quality"] = {{"residual", residual(problem, answer.x)},
                        {"iterations", answer.iterations},
                        {"setup_ms", 1e3 * answer.setup_s}};
      row["ours_quality"] = {{"residual", residual(problem, numbered(in->system, q))},
                             {"iterations", solution.iterations}};
      row["not_the_same"] = not_the_same;
      rows.push_back(row);
    }
  }
}

}  // namespace lockstep::peers
