// The data of all figures: NAME.json, {"machine": ..., "rows": ...}, for notes/figures. The reports of `bench` and
// `scale` are among them, so that one process makes all: many kernels share a scene that takes long to settle.
#include <omp.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>

#include "common/cloth/make.h"
#include "common/input_error.h"
#include "common/levelset/blocks.h"
#include "common/levelset/fast_marching.h"
#include "common/levelset/fast_sweeping.h"
#include "common/levelset/initialize.h"
#include "common/levelset/scene.h"
#include "common/rigid/batches.h"
#include "common/rigid/contact_blocks.h"
#include "common/rigid/contact_solver.h"
#include "verify/busy.h"
#include "verify/cloth/forms.h"
#include "verify/cloth/run.h"
#include "verify/curves.h"
#include "verify/modules.h"
#include "verify/names.h"
#include "verify/options.h"
#include "verify/report.h"
#include "verify/rigid/inputs.h"
#include "verify/rows_of.h"
#include "verify/scale.h"
#include "verify/sensitivity.h"
#include "verify/sizes.h"
#include "verify/team.h"

namespace lockstep::verify {
namespace {

std::vector<int> cores_of(const FigureOptions& options) {
  return options.quick ? std::vector<int>{1, 2, 64} : std::vector<int>{1, 2, 4, 8, 16, 32, 64};
}

// 1, 2, 4, ... and as many as the machine has, two at least, and 64.
std::vector<int> few_cores() {
  std::vector<int> cores = doubling_to(std::max(2, omp_get_num_procs()));
  cores.insert(std::ranges::lower_bound(cores, 64), 64);
  cores.erase(std::unique(cores.begin(), cores.end()), cores.end());
  return cores;
}

// The least time of `repeats` runs, as in scale_row.
double least_ms(int repeats, const std::function<void()>& reset, const std::function<void()>& work) {
  double least = std::numeric_limits<double>::infinity();
  for (int repeat = 0; repeat < repeats; ++repeat) {
    reset();
    const double begin = now();
    work();
    least = std::min(least, 1e3 * (now() - begin));
  }
  return least;
}

// Residual over iterations, by the order in which constraints are enforced.
void cloth_convergence(const FigureOptions& options, const Model&, RowsOf& rows) {
  const std::vector<int> iterations =
      options.quick ? std::vector<int>{5, 20, 80} : std::vector<int>{5, 7, 10, 14, 20, 28, 40, 57, 80, 113, 160};
  for (const std::string scene : {"flag_33", "sheet_on_sphere", "rope", "pulled_edge"}) {
    const cloth::Cloth<float> start = cloth::convert<float>(cloth::load_scene("scenes/cloth/" + scene + ".toml").cloth);
    for (const ClothForm& form : cloth_forms)
      for (const int n : iterations) {
        progress("cloth_convergence: " + scene + ' ' + form.name + ", " + std::to_string(n) + " iterations");
        cloth::Relax<float>* const relax = form.openmp_relax ? form.openmp_relax : form.serial_relax;
        rows.add({{"scene", scene}, {"form", form.name}, {"iterations", n}}, [&] {
          return Rows{{"residual", residual_left(start, relax, n)}};
        });
      }
  }
}

// Cost and gain of blocks: marching and sweeping of 256^3 points in blocks, and the undivided serial forms. Also the
// amount of repeated work, which does not depend on the machine.
void levelset_blocks(const FigureOptions& options, const Model& model, RowsOf& rows) {
  const std::string name = options.quick ? "spheres_and_box_128" : "spheres_and_box_256";
  const levelset::Scene scene = levelset::load_scene("scenes/levelset/" + name + ".toml");
  const auto band = static_cast<float>(scene.band);
  levelset::Distances<float> start, d;
  levelset::openmp::initialize(scene.phi, start);
  const auto points_within = [](const levelset::Distances<float>& distances) {
    return double(std::ranges::count_if(distances.distance.value, [](float v) { return v < levelset::far<float>; }));
  };
  const auto reset = [&] { d = start; };
  const int repeats = options.quick ? 1 : 3;

  const auto serial_row = [&](const char* algorithm, const std::function<void()>& run) {
    rows.add({{"scene", name}, {"algorithm", algorithm}, {"blocks", 1}, {"variant", "serial"}}, [&] {
      return Rows{{"measured_ms", least_ms(repeats, reset, run)}};
    });
  };
  progress("levelset_blocks: serial");
  serial_row("fast_marching", [&] { levelset::serial::fast_marching_heap(d, band); });
  serial_row("fast_sweeping", [&] { levelset::serial::fast_sweeping_sweeps(d, band, 1); });
  reset();
  levelset::openmp::fast_sweeping_sweeps(d, band, 1);
  const double band_points = points_within(d);

  for (const int side : options.quick ? std::vector<int>{1, 4} : std::vector<int>{1, 2, 3, 4, 5, 6}) {
    const int size = (scene.grid.nx + side - 1) / side;
    // Each block also computes the distances of its padding.
    double work = 0;
    for (const levelset::Block& block : levelset::make_blocks(start, band, size)) {
      levelset::Distances<float> padded = levelset::cut_out(start, block);
      levelset::openmp::fast_marching_blocks(padded, band, 2 * scene.grid.nx);
      work += points_within(padded);
    }
    const int blocks = side * side * side;
    for (const int cores : cores_of(options)) {
      if (cores >= 2 * blocks) continue;  // one core works on a block, so most of these cores would be idle
      for (const std::string algorithm : {"fast_marching", "fast_sweeping"}) {
        progress("levelset_blocks: " + algorithm + ", " + std::to_string(blocks) + " blocks, " + std::to_string(cores) +
                 " cores");
        const auto run = [&] {
          if (algorithm == "fast_marching")
            levelset::openmp::fast_marching_blocks(d, band, size);
          else
            levelset::openmp::fast_sweeping_blocks(d, band, 1, size);
        };
        rows.add({{"scene", name},
                  {"algorithm", algorithm},
                  {"blocks", blocks},
                  {"variant", "openmp"},
                  {"work_points", work},
                  {"band_points", band_points},
                  {"cores", cores}},
                 [&] {
                   const double bytes = 8. * static_cast<double>(start.distance.value.size());
                   return scale_row(model, {reset, run, bytes}, cores, effort_of(options));
                 });
      }
    }
  }
}

// The distances of a slice through the middle of the spheres and the box, and their first-order error.
void levelset_slice(const FigureOptions&, const Model&, RowsOf& rows) {
  const levelset::Scene scene = levelset::load_scene("scenes/levelset/spheres_and_box_128_full.toml");
  levelset::Distances<float> d;
  levelset::openmp::initialize(scene.phi, d);
  levelset::openmp::fast_sweeping_sweeps(d, static_cast<float>(scene.band), 4);
  const int z = scene.grid.nz / 2;
  for (int y = 0; y < scene.grid.ny; ++y)
    for (int x = 0; x < scene.grid.nx; ++x) {
      const double exact = levelset::signed_distance(scene.shapes, scene.grid.position(x, y, z));
      const double found = scene.phi(x, y, z) < 0 ? -d.distance(x, y, z) : d.distance(x, y, z);
      rows.add({{"x", x}, {"y", y}, {"distance", found}, {"error_in_spacings", (found - exact) / scene.grid.spacing}});
    }
}

// Gain and cost of reordering contacts: one step over the settled contacts of a scene, in the original order (as
// parallel as it allows), and in batches and in blocks with the time to make them. Also the sizes of the batches.
void contact_batches(const FigureOptions& options, const Model& model, RowsOf& rows) {
  using namespace rigid;
  using namespace rigid_inputs;
  const std::vector<std::string> scenes =
      options.quick
          ? std::vector<std::string>{"pyramid_15"}
          : std::vector<std::string>{"pyramid_24", "box_pit_4000", "hull_pit_2000", "castle_hit", "castles_4"};
  for (const std::string& name : scenes) {
    progress("contact_batches: " + name);
    const auto in = inputs("scenes/rigid/" + name + ".toml");
    const SolverSettings& solver = in->settings.solver;
    const Array<Manifold<float>>& manifolds = in->now.manifolds;
    const std::span<const std::int32_t> body = in->body();
    const Array<Impulses<float>> start = warm_start(*in);
    Bodies<float> bodies;
    Array<Impulses<float>> impulses;
    Array<Motion<float>> moving;
    Batches batches;
    ContactBlocks blocks;
    const auto reset = [&] { bodies = in->world.bodies, impulses = start; };
    const auto original = [&](ContactSolverOriginal<float>* solve) {
      return [&, solve] { solve(solver, manifolds, body, bodies, std::span(impulses), moving); };
    };
    const auto reordered = [&](ReorderContacts<float>* reorder, ContactSolverReordered<float, Batches>* solve) {
      return [&, reorder, solve] {
        batches = reorder(manifolds, body, bodies);
        solve(solver, manifolds, body, batches, bodies, std::span(impulses), moving);
      };
    };
    const auto cut = [&](CutIntoBlocks<float>* cut_into_blocks, ContactSolverReordered<float, ContactBlocks>* solve) {
      return [&, cut_into_blocks, solve] {
        cut_into_blocks(manifolds, body, bodies, blocks);
        solve(solver, manifolds, body, blocks, bodies, std::span(impulses), moving);
      };
    };
    const int repeats = options.quick ? 1 : 3;
    const auto serial_row = [&](const char* form, const std::function<void()>& solve) {
      rows.add({{"scene", name}, {"form", form}, {"variant", "serial"}}, [&] {
        return Rows{{"measured_ms", least_ms(repeats, reset, solve)}};
      });
    };
    serial_row("original", original(serial::contact_solver_original));
    serial_row("batches", reordered(serial::batches, serial::contact_solver_batches));
    serial_row("blocks", cut(serial::contact_blocks, serial::contact_solver_blocks));
    const double bytes =
        static_cast<double>(manifolds.size() * (sizeof(Manifold<float>) + 2 * sizeof(Impulses<float>)));
    for (const int cores : cores_of(options)) {
      const auto scaled = [&](const char* form, const std::function<void()>& solve) {
        rows.add({{"scene", name}, {"form", form}, {"variant", "openmp"}, {"cores", cores}}, [&] {
          return scale_row(model, {reset, solve, bytes}, cores, effort_of(options));
        });
      };
      scaled("original", original(openmp::contact_solver_original));
      scaled("batches", reordered(openmp::batches, openmp::contact_solver_batches));
      scaled("blocks", cut(openmp::contact_blocks, openmp::contact_solver_blocks));
      scaled("reorder", [&] { batches = openmp::batches(manifolds, body, bodies); });
    }
    reset();
    batches = openmp::batches(manifolds, body, bodies);
    for (int k = 0; k < batches.count(); ++k)
      rows.add({{"scene", name},
                {"variant", "batch_size"},
                {"batch", k},
                {"contacts", batches.begin[k + 1] - batches.begin[k]}});
  }
}

struct Figure {
  const char* name;
  void (*compute)(const FigureOptions& options, const Model& model, RowsOf& rows);
};

constexpr Figure all_figures[] = {{"cloth_convergence", cloth_convergence},   {"levelset_blocks", levelset_blocks},
                                  {"levelset_slice", levelset_slice},         {"contact_batches", contact_batches},
                                  {"production_modules", production_modules}, {"face_modules", face_modules},
                                  {"cloth_modules", cloth_modules},           {"sensitivity", sensitivity},
                                  {"problem_sizes", problem_sizes},           {"curves", curves}};

}  // namespace

int figures(const FigureOptions& options) {
  std::vector<std::string> names = {"bench", "scale"};
  for (const Figure& figure : all_figures) names.push_back(figure.name);
  for (const std::string& report : options.reports)
    if (std::ranges::find(names, report) == names.end())
      throw InputError("--report " + report + ": expected some of: " + joined(names, ", "));
  const auto is_wanted = [&](const char* report) {
    return options.reports.empty() || std::ranges::find(options.reports, report) != options.reports.end();
  };
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) throw InputError(options.out + ": cannot be made: " + error.message());
  const auto file_of = [&](const char* report) { return options.out + '/' + report + ".json"; };
  if (is_wanted("bench")) {
    Options its = options;
    its.json = file_of("bench");
    its.full = false;  // `full` would add scenes, which `lockstep bench` does not have
    bench(its);
  }
  if (is_wanted("scale")) {
    ScaleOptions its{options, few_cores(), {}};
    its.json = file_of("scale");
    scale(its);
  }
  std::optional<Model> measured;  // for the first report that needs it
  for (const Figure& figure : all_figures) {
    if (!is_wanted(figure.name)) continue;
    if (!measured) measured = measure_model();
    const Model& model = *measured;
    ReportOptions its = options;
    its.json = file_of(figure.name);
    Report report(its);
    report.on["busy_cores"] = busy_cores();
    report.on["costs"] = describe(model);
    RowsOf rows(report, options.shard);
    figure.compute(options, model, rows);
    rows.finish();
    progress("");
    std::printf("%s\n", its.json.c_str());
  }
  return 0;
}

}  // namespace lockstep::verify
