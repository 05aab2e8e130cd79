// The game cloth's kernels, as the verifier and the benchmark see them.
//
// Each kernel is compared on a scene's state after a few steps, where the kernel finds it within a step, and bitwise: lanes do what
// the serial form of the same order does. What the order itself costs is asked in rows of their own, `chains_for_original` and so
// on: how many iterations a form takes to leave no more of the residual than the original order leaves.
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "common/cloth/collide.h"
#include "common/cloth/make.h"
#include "common/cloth/residual.h"
#include "common/cloth/scene.h"
#include "common/cloth/verlet.h"
#include "common/scene.h"
#include "verify/cloth_forms.h"
#include "verify/cloth_run.h"
#include "verify/compare.h"
#include "verify/kernel.h"

namespace lockstep::verify {
namespace {

using namespace cloth;

constexpr int settling_steps = 30;  // so that the cloth has left its plane and met what it falls on

// A scene as each kernel finds it. Made once a scene; shared by all kernels.
struct Inputs {
  Scene scene;
  Cloth<float> start;                                        // as the scene says
  Cloth<float> before_verlet, before_relax, before_collide;  // within the step after the settling
};

const ClothForm& default_form(const Cloth<float>& cloth) {
  return *std::find_if(std::begin(cloth_forms), std::end(cloth_forms),
                       [&](const ClothForm& f) { return f.for_meshes || cloth.sheet.rows > 0; });
}

std::shared_ptr<const Inputs> inputs(const std::string& path) {
  static std::map<std::string, std::shared_ptr<const Inputs>> known;
  if (const auto found = known.find(path); found != known.end()) return found->second;
  auto in = std::make_shared<Inputs>(
      Inputs{.scene = load_scene(path), .start = {}, .before_verlet = {}, .before_relax = {}, .before_collide = {}});
  in->start = in->before_verlet = convert<float>(in->scene.cloth);
  const ClothForm& form = default_form(in->start);
  for (int step = 0; step < settling_steps; ++step) form.serial_step(in->before_verlet);
  in->before_relax = in->before_verlet;
  serial::verlet(in->before_relax);
  in->before_collide = in->before_relax;
  form.serial_relax(in->before_collide, in->before_collide.model.iterations);
  return known[path] = in;
}

// Names the elements of a component: which particle of a sheet or a mesh.
ElementName particle_name(const Cloth<float>& cloth, const char* what) {
  return [&cloth, what](std::size_t i) {
    if (cloth.sheet.rows == 0) return std::string(what) + " of point " + std::to_string(i);
    return std::string(what) + " of particle (" + std::to_string(i / cloth.sheet.pitch) + ", " + std::to_string(i % cloth.sheet.pitch) +
           ")";
  };
}

void same_bits(Judgement& judgement, const Vectors<float>& openmp, const Vectors<float>& serial, const Cloth<float>& cloth) {
  const auto component = [&](const Array<float>& a, const Array<float>& b, const char* what) {
    const std::size_t n = cloth.count;
    same_bits(judgement, std::span<const float>(a.data(), n), std::span<const float>(b.data(), n), particle_name(cloth, what));
  };
  component(openmp.x, serial.x, "x"), component(openmp.y, serial.y, "y"), component(openmp.z, serial.z, "z");
}

std::uint64_t hash_of(const Cloth<float>& cloth) {
  std::uint64_t hash = 0;
  for (const Vectors<float>* v : {&cloth.position, &cloth.previous})
    for (const Array<float>* component : {&v->x, &v->y, &v->z})
      hash = hash_bytes(std::span<const float>(component->data(), cloth.count), hash);
  return hash;
}

using Change = std::function<void(Cloth<float>&)>;
Change change(void (*kernel)(Cloth<float>&)) { return kernel; }  // of all overloads, the one for float

// A kernel that changes a cloth, compared bitwise with its twin from `start` on.
Case bitwise_case(std::shared_ptr<const Inputs> in, const Cloth<float>& start, Change twin, Change best, Change openmp, Work work) {
  struct State {
    std::shared_ptr<const Inputs> in;
    const Cloth<float>& start;
    Cloth<float> openmp, serial, expected;
  };
  auto s = std::make_shared<State>(State{in, start, start, start, start});
  twin(s->expected);
  return {
      .reset = [s] { s->openmp = s->serial = s->start; },
      .serial = [s, twin] { twin(s->serial); },
      .best_serial = best ? std::function<void()>([s, best] { best(s->serial); }) : nullptr,
      .openmp = [s, openmp] { openmp(s->openmp); },
      .judge =
          [s] {
            Judgement judgement{.verdict = Verdict::bitwise, .worst_at = ""};
            same_bits(judgement, s->openmp.position, s->expected.position, s->start);
            same_bits(judgement, s->openmp.previous, s->expected.previous, s->start);
            return judgement;
          },
      .hash = [s] { return hash_of(s->openmp); },
      .work = std::move(work),
  };
}

// Bytes: position, previous position and inverse mass of each particle read, the first two written. Flops as the texts count them.
double free_particles(const Cloth<float>& cloth) {
  return std::count_if(cloth.inverse_mass.begin(), cloth.inverse_mass.begin() + cloth.count, [](float w) { return w > 0; });
}
double verlet_flops(const Cloth<float>& c) { return 24 * free_particles(c) + (c.model.drag > 0 ? 65. : 0.) * c.triangles.size(); }
double projections(const Cloth<float>& c) { return double(c.constraints.count) * c.model.iterations; }
constexpr double flops_of_projection = 27;

// The share of lanes that hold a constraint. Along a row, colours take 2 G particles at a time, of which G lanes each hold one of a pair;
// of 32 particles at the end of a row, only those that are there. Chains along rows run sixteen rows at a time.
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
      for (const int colour : {0, 1}) add(0, sheet.rows * std::ceil(double(sheet.columns - colour * right) / (2 * lanes)));
      used += double(n) * sheet.rows;
    }
  }
  return used / there;
}

Case verlet_case(const std::string& path) {
  const auto in = inputs(path);
  const Cloth<float>& start = in->before_verlet;
  const double n = free_particles(start);
  return bitwise_case(in, start, change(serial::verlet), nullptr, change(openmp::verlet), {n, "particles", 52 * n, verlet_flops(start)});
}

Case relax_case(const std::string& path, const ClothForm& form) {
  const auto in = inputs(path);
  const Cloth<float>& start = in->before_relax;
  const auto with = [](Relax<float>* relax) { return [relax](Cloth<float>& cloth) { relax(cloth, cloth.model.iterations); }; };
  return bitwise_case(in, start, with(form.serial_relax), with(serial::relax_original), with(form.openmp_relax),
                      {projections(start), "projections", 28 * free_particles(start), flops_of_projection * projections(start),
                       lane_use(start, form.name)});
}

Case collide_case(const std::string& path) {
  const auto in = inputs(path);
  const Cloth<float>& start = in->before_collide;
  const Bodies<float>& bodies = start.bodies;
  const double n = free_particles(start);
  const double flops = 6. * bodies.planes.size() + 30. * bodies.capsules.size() + 27. * bodies.boxes.size();
  return bitwise_case(in, start, change(serial::collide), nullptr, change(openmp::collide), {n, "particles", 40 * n, flops * n});
}

// A whole run: as many steps as the scene says. Timed is one step.
Case step_case(const std::string& path, const ClothForm& form) {
  const auto in = inputs(path);
  const Cloth<float>& start = in->before_verlet;
  const double n = free_particles(start), substeps = start.model.substeps;
  Case run = bitwise_case(
      in, start, form.serial_step, change(serial::step_original), form.openmp_step,
      {substeps * projections(start), "projections", 52 * n, substeps * (verlet_flops(start) + flops_of_projection * projections(start))});
  run.judge = [in, form, one_step = run.judge] {
    Judgement judgement = one_step();
    check_run(judgement, in->scene, *serial_run(in->scene, form.name, form.serial_step), form.openmp_step);
    return judgement;
  };
  return run;
}

// Whether a form leaves no more of the residual than the original order does, and how many more iterations that takes. Timed are
// the runs that leave the same.
Case convergence_case(const std::string& path, const ClothForm& form) {
  constexpr int most_times = 20;  // the iterations of the original order; a form that stalls above its residual stops there, and fails
  struct State {
    std::shared_ptr<const Inputs> in;
    double target = 0, left = 0;
    int needed = 0;
  };
  auto s = std::make_shared<State>(State{.in = inputs(path)});
  const Cloth<float>& start = s->in->start;
  const int iterations = start.model.iterations;
  s->target = residual_left(start, serial::relax_original, iterations);
  for (int n = iterations / 2; n <= most_times * iterations; n += std::max(1, n / 20)) {
    s->needed = n;
    if (residual_left(start, form.openmp_relax, n) <= s->target) break;
  }
  return {
      .reset = [] {},
      .serial = [s, iterations] { residual_left(s->in->start, serial::relax_original, iterations); },
      .best_serial = nullptr,
      .openmp = [s, form] { s->left = residual_left(s->in->start, form.openmp_relax, s->needed); },
      .judge =
          [s, iterations] {
            char text[120];
            std::snprintf(text, sizeof text, "%d iterations for the original order's %d: %.2f times", s->needed, iterations,
                          double(s->needed) / iterations);
            return Judgement{
                .verdict = Verdict::converged, .passed = s->left <= s->target, .error = s->left, .bound = s->target, .worst_at = text};
          },
      .hash = [s] { return hash_bytes(std::span<const double>(&s->left, 1)); },
      .work = {projections(start), "projections", 28 * free_particles(start), flops_of_projection * projections(start)},
  };
}

}  // namespace

std::vector<Kernel> cloth_kernels() {
  using Scenes = std::vector<std::string>;
  const auto scenes = [](Scenes names) {
    for (std::string& name : names) name = "scenes/cloth/" + name + ".toml";
    return names;
  };
  const auto with = [](Scenes some, const Scenes& others) {
    some.insert(some.end(), others.begin(), others.end());
    return some;
  };
  const Scenes short_runs = scenes({"flag_33", "curtain", "sheet_on_sphere", "pulled_edge", "rope"});
  const Scenes sheets = with(short_runs, scenes({"tiny", "sheet_over_box_and_capsule", "flag_128"})),
               meshes = scenes({"garment", "napkin"});
  const Scenes more = scenes({"flag_128_substeps", "flag_256"});

  std::vector<Kernel> kernels;
  const auto add = [&](const char* name, const std::string& form, bool for_meshes, const Scenes& sheet_scenes, Scenes more_scenes,
                       Scenes bench_scenes, std::function<Case(const std::string&)> make) {
    const auto takes = [for_meshes](const std::string& path) {
      return kind_of_scene(path) == "cloth" && (for_meshes || inputs(path)->start.sheet.rows > 0);
    };
    kernels.push_back({name, form, false, for_meshes ? with(sheet_scenes, meshes) : sheet_scenes, std::move(more_scenes),
                       std::move(bench_scenes), takes, std::move(make)});
  };
  add("cloth/verlet", "", true, sheets, more, scenes({"flag_128", "garment"}), verlet_case);
  for (const ClothForm& form : cloth_forms)
    if (form.openmp_relax) {
      add("cloth/relax", form.name, form.for_meshes, sheets, more,
          form.for_meshes ? scenes({"flag_128", "garment"}) : scenes({"flag_128", "flag_256"}),
          [form](auto& path) { return relax_case(path, form); });
      add("cloth/relax", form.name + "_for_original", form.for_meshes, short_runs, {}, {},
          [form](auto& path) { return convergence_case(path, form); });
    }
  add("cloth/collide", "", true, sheets, more, scenes({"sheet_over_box_and_capsule", "garment"}), collide_case);
  for (const ClothForm& form : cloth_forms)
    if (form.openmp_step)
      add("cloth/step", form.name, form.for_meshes, sheets, more,
          form.for_meshes ? scenes({"garment"}) : scenes({"flag_128", "flag_128_substeps"}),
          [form](auto& path) { return step_case(path, form); });
  return kernels;
}

}  // namespace lockstep::verify
