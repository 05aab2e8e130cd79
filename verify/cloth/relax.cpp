// The game cloth's relaxation, as the verifier and the benchmark see it: bitwise with the serial form of the same
// order.
//
// What the order itself costs is asked in forms of their own, `chains_for_original` and so on: how many iterations a
// form takes to leave no more of the residual than the original order leaves.
#include "common/cloth/relax.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "verify/cloth/forms.h"
#include "verify/cloth/inputs.h"
#include "verify/cloth/run.h"
#include "verify/twin.h"

namespace lockstep::verify::cloth_relax {
namespace {

using namespace cloth;
using namespace cloth_inputs;

// The share of lanes that hold a constraint. Along a row, colours take 2 G particles at a time, of which G lanes each
// hold one of a pair; of 32 particles at the end of a row, only those that are there. Chains along rows run sixteen
// rows at a time.
double lane_use(const Cloth<float>& cloth, const std::string& form) {
  std::vector<int> lengths;
  const Sheet& sheet = cloth.sheet;
  if (form == "batches") {
    for (std::size_t batch = 0; batch + 1 < cloth.batch_begin.size(); ++batch)
      lengths.push_back(cloth.batch_begin[batch + 1] - cloth.batch_begin[batch]);
    return lanes_in_use(lengths);
  }
  double used = 0, there = 0;
  const auto add = [&](double constraints, double vectors) { used += constraints, there += lanes * vectors; };
  for (const auto& [down, right, rest_2] : cloth.families) {
    const int n = sheet.columns - std::abs(right);
    if (down > 0) {
      add(double(n) * (sheet.rows - down), std::ceil(double(n) / lanes) * (sheet.rows - down));
    } else if (form == "chains") {
      add(double(n) * sheet.rows, n * std::ceil(double(sheet.rows) / lanes));
    } else {
      for (const int colour : {0, 1})
        add(0, sheet.rows * std::ceil(double(sheet.columns - colour * right) / (2 * lanes)));
      used += double(n) * sheet.rows;
    }
  }
  return used / there;
}

Work work_of(const Cloth<float>& start) {
  return {projections(start), "projections", 28 * free_particles(start), flops_of_projection * projections(start)};
}

Case relax_case(const std::string& path, const ClothForm& form) {
  const auto in = inputs(path);
  const auto start = in->before_relax;
  const auto with = [](Relax<float>* relax) {
    return [relax](Cloth<float>& cloth) { relax(cloth, cloth.model.iterations); };
  };
  Work work = work_of(*start);
  work.lane_use = lane_use(*start, form.name);
  return make_case<Cloth<float>>({
      .start = start,
      .serial = with(form.serial_relax),
      .best_serial = with(serial::relax_original),
      .openmp = with(form.openmp_relax),
      .compare = [start](const auto& openmp,
                         const auto& serial) { return bitwise(openmp, serial, particle_name(*start)); },
      .work = work,
  });
}

// Whether a form leaves no more of the residual than the original order does, and how many more iterations that takes.
// Timed are the runs that leave the same.
Case convergence_case(const std::string& path, const ClothForm& form) {
  // The iterations of the original order; a form that stalls above its residual stops there, and fails.
  constexpr int most_times = 20;
  struct State {
    std::shared_ptr<const Inputs> in;
    double target = 0, left = 0;
    int needed = 0;
  };
  auto s = std::make_shared<State>(State{.in = inputs(path)});
  const Cloth<float>& start = *s->in->start;
  const int iterations = start.model.iterations;
  s->target = residual_left(start, serial::relax_original, iterations);
  for (int n = iterations / 2; n <= most_times * iterations; n += std::max(1, n / 20)) {
    s->needed = n;
    if (residual_left(start, form.openmp_relax, n) <= s->target) break;
  }
  return {
      .reset = [] {},
      .serial = [s, iterations] { residual_left(*s->in->start, serial::relax_original, iterations); },
      .best_serial = nullptr,
      .openmp = [s, form] { s->left = residual_left(*s->in->start, form.openmp_relax, s->needed); },
      .judge =
          [s, iterations] {
            char text[120];
            std::snprintf(text, sizeof text, "%d iterations for the original order's %d: %.2f times", s->needed,
                          iterations, double(s->needed) / iterations);
            return Judgement{.verdict = Verdict::converged,
                             .passed = s->left <= s->target,
                             .error = s->left,
                             .bound = s->target,
                             .worst_at = text};
          },
      .hash = [s] { return hash_bytes(std::span<const double>(&s->left, 1)); },
      .work = work_of(start),
  };
}

std::vector<Form> forms() {
  std::vector<Form> all;
  for (const ClothForm& form : cloth_forms) {
    if (!form.openmp_relax) continue;
    const auto takes = form.for_meshes ? has_one_cloth : is_sheet;
    const Scenes scenes =
        form.for_meshes ? scenes_of_all({"flag_128", "garment"}) : scenes_of_sheets({"flag_128", "flag_256"});
    Scenes short_runs = {.verify = {"flag_33", "curtain", "sheet_on_sphere", "pulled_edge", "rope"},
                         .more = {},
                         .bench = {},
                         .tsan = {}};
    if (form.for_meshes) short_runs.verify.insert(short_runs.verify.end(), {"garment", "napkin"});
    all.push_back({.name = form.name,
                   .make = [form](const std::string& path) { return relax_case(path, form); },
                   .scenes = scenes,
                   .takes = takes});
    all.push_back({.name = form.name + "_for_original",
                   .make = [form](const std::string& path) { return convergence_case(path, form); },
                   .scenes = short_runs,
                   .covered_by = form.name,
                   .takes = takes});
  }
  return all;
}

const Register relax{{.name = "cloth/relax", .place = 2, .serial_forms = serial_cloth_forms, .forms = forms()}};

}  // namespace
}  // namespace lockstep::verify::cloth_relax
