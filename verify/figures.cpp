// The data of the figures that `bench` and `scale` do not provide: NAME.json, {"machine": ..., "rows": ...}, for
// notes/figures.
#include <omp.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <string>

#include "common/cloth/make.h"
#include "common/input_error.h"
#include "common/levelset/blocks.h"
#include "common/levelset/fast_marching.h"
#include "common/levelset/fast_sweeping.h"
#include "common/levelset/initialize.h"
#include "common/levelset/scene.h"
#include "common/production_face/scene.h"
#include "common/production_fluid/scene.h"
#include "common/rigid/batches.h"
#include "common/rigid/scene.h"
#include "common/rigid/step.h"
#include "verify/busy.h"
#include "verify/cloth/forms.h"
#include "verify/cloth/run.h"
#include "verify/curves.h"
#include "verify/held_team.h"
#include "verify/names.h"
#include "verify/options.h"
#include "verify/production_cloth/frame.h"
#include "verify/production_face/forms.h"
#include "verify/production_fluid/forms.h"
#include "verify/report.h"
#include "verify/rigid/run.h"
#include "verify/rows_of.h"
#include "verify/scale.h"
#include "verify/sensitivity.h"
#include "verify/sizes.h"

namespace lockstep::verify {
namespace {

std::vector<int> cores_of(const FigureOptions& options) {
  return options.quick ? std::vector<int>{1, 2, 64} : std::vector<int>{1, 2, 4, 8, 16, 32, 64};
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
    for (const int cores : cores_of(options))
      for (const std::string algorithm : {"fast_marching", "fast_sweeping"}) {
        progress("levelset_blocks: " + algorithm + ", " + std::to_string(side * side * side) + " blocks, " +
                 std::to_string(cores) + " cores");
        const auto run = [&] {
          if (algorithm == "fast_marching")
            levelset::openmp::fast_marching_blocks(d, band, size);
          else
            levelset::openmp::fast_sweeping_blocks(d, band, 1, size);
        };
        rows.add({{"scene", name},
                  {"algorithm", algorithm},
                  {"blocks", side * side * side},
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
  const std::vector<std::string> scenes =
      options.quick
          ? std::vector<std::string>{"pyramid_15"}
          : std::vector<std::string>{"pyramid_24", "box_pit_4000", "hull_pit_2000", "castle_hit", "castles_4"};
  for (const std::string& name : scenes) {
    const Scene scene = load_scene("scenes/rigid/" + name + ".toml");
    const StepSettings settings = settings_of(scene);
    World<float> world = scene.world;
    StepMemory<float> memory;
    for (int step = 0; step < std::max(scene.settle, 1); ++step) {
      progress("contact_batches: " + name + ", step " + std::to_string(step));
      openmp::step_batches(settings, world, memory);
    }
    const std::span<const std::int32_t> body(world.colliders.body.data(), world.colliders.count);
    Bodies<float> bodies;
    Array<Impulses<float>> impulses;
    Array<Motion<float>> moving;
    Batches batches;
    ContactBlocks blocks;
    const auto reset = [&] { bodies = world.bodies, impulses = memory.impulses; };
    const auto original = [&](ContactSolverOriginal<float>* solve) {
      return [&, solve] { solve(settings.solver, memory.manifolds, body, bodies, std::span(impulses), moving); };
    };
    const auto reordered = [&](ReorderContacts<float>* reorder, ContactSolverReordered<float, Batches>* solve) {
      return [&, reorder, solve] {
        batches = reorder(memory.manifolds, body, bodies);
        solve(settings.solver, memory.manifolds, body, batches, bodies, std::span(impulses), moving);
      };
    };
    const auto cut = [&](CutIntoBlocks<float>* cut_into_blocks, ContactSolverReordered<float, ContactBlocks>* solve) {
      return [&, cut_into_blocks, solve] {
        cut_into_blocks(memory.manifolds, body, bodies, blocks);
        solve(settings.solver, memory.manifolds, body, blocks, bodies, std::span(impulses), moving);
      };
    };
    const int repeats = options.quick ? 1 : 3;
    const auto serial_row = [&](const char* form, const std::function<void()>& solve) {
      rows.add({{"scene", name}, {"form", form}, {"variant", "serial"}}, [&] {
        return Rows{{"measured_ms", least_ms(repeats, reset, solve)}};
      });
    };
    progress("contact_batches: " + name);
    serial_row("original", original(serial::contact_solver_original));
    serial_row("batches", reordered(serial::batches, serial::contact_solver_batches));
    serial_row("blocks", cut(serial::contact_blocks, serial::contact_solver_blocks));
    const double bytes =
        static_cast<double>(memory.manifolds.size() * (sizeof(Manifold<float>) + 2 * sizeof(Impulses<float>)));
    for (const int cores : cores_of(options)) {
      const auto scaled = [&](const char* form, const std::function<void()>& solve) {
        rows.add({{"scene", name}, {"form", form}, {"variant", "openmp"}, {"cores", cores}}, [&] {
          return scale_row(model, {reset, solve, bytes}, cores, effort_of(options));
        });
      };
      scaled("original", original(openmp::contact_solver_original));
      scaled("batches", reordered(openmp::batches, openmp::contact_solver_batches));
      scaled("blocks", cut(openmp::contact_blocks, openmp::contact_solver_blocks));
      scaled("reorder", [&] { batches = openmp::batches(memory.manifolds, body, bodies); });
    }
    reset();
    batches = openmp::batches(memory.manifolds, body, bodies);
    for (int k = 0; k < batches.count(); ++k)
      rows.add({{"scene", name},
                {"variant", "batch_size"},
                {"batch", k},
                {"contacts", batches.begin[k + 1] - batches.begin[k]}});
  }
}

// Milliseconds of a frame of the production fluid by module, after one that is not timed.
void production_modules(const FigureOptions& options, const Model&, RowsOf& rows) {
  using namespace production_fluid;
  const std::string name = options.quick ? "drop_64" : options.full ? "drop_256" : "drop_128";
  const LiquidForm& form = liquid_forms[0];
  const Scene scene = load_scene("scenes/production_fluid/" + name + ".toml");
  Liquid<float> start;
  start.fluid = scene.fluid;
  StepMemory<float> memory;
  serial::start(scene.model, start, memory);
  form.openmp(scene.model, start, memory);
  const auto frame = [&](const std::string& variant, int threads, Step<float>* step) {
    progress("production_modules: " + name + ", " + variant + ", threads " + std::to_string(threads));
    rows.add({{"scene", name}, {"variant", variant}, {"form", form.name}, {"threads", threads}}, [&] {
      Liquid<float> liquid = start;
      hold_team(threads, [&] { step(scene.model, liquid, memory); });
      Rows row = {{"cells", scene.fluid.nx * scene.fluid.ny * scene.fluid.nz},
                  {"particles", liquid.particles.count},
                  {"substeps", memory.substeps},
                  {"iterations", memory.iterations}};
      for (int k = 0; k < int(Module::count); ++k)
        row["modules"].push_back({{"module", name_of_module[k]}, {"ms", 1e3 * memory.seconds[k]}});
      return row;
    });
  };
  const int most = omp_get_max_threads();
  frame("serial", 1, form.serial);
  for (int threads = 1; threads <= most; threads *= 2) frame("openmp", threads, form.openmp);
  omp_set_num_threads(most);
}

// Milliseconds of a frame of the production face by module: the third, from the serial pose of the second.
void face_modules(const FigureOptions&, const Model&, RowsOf& rows) {
  using namespace production_face;
  const std::string name = "face_381k";
  const Scene scene = load_scene("scenes/production_face/" + name + ".toml");
  const Face<float> face = make_face(scene.body, scene.flesh);
  const auto target = [&](int frame) { return target_at(scene.body, scene.motion, frame * frame_time); };
  SerialMemory in_rows = serial::make_memory(face);
  OpenmpMemory in_slices = openmp::make_memory(face);
  Pose<float> start = scene.pose;
  openmp::step_newton(face, target(2), scene.tolerance, start, in_slices);
  const auto frame = [&](const std::string& form, const std::string& variant, int threads, auto* step, auto& memory) {
    progress("face_modules: " + form + ", " + variant + ", threads " + std::to_string(threads));
    rows.add({{"scene", name}, {"variant", variant}, {"form", form}, {"threads", threads}}, [&] {
      Pose<float> pose = start;
      hold_team(threads, [&] { step(face, target(3), scene.tolerance, pose, memory); });
      Rows row = {{"tetrahedra", scene.body.tetrahedra},
                  {"steps", memory.frame.steps},
                  {"iterations", memory.frame.iterations}};
      for (int k = 0; k < int(Module::count); ++k)
        row["modules"].push_back({{"module", name_of_module[k]}, {"ms", 1e3 * memory.frame.seconds[k]}});
      return row;
    });
  };
  const int most = omp_get_max_threads();
  for (const FaceForm& form : face_forms) {
    frame(form.name, "serial", 1, form.serial, in_rows);
    for (int threads = 1; threads <= most; threads *= 2) frame(form.name, "openmp", threads, form.openmp, in_slices);
  }
  omp_set_num_threads(most);
}

// Milliseconds of a frame of the production cloth by module.
void cloth_modules(const FigureOptions&, const Model&, RowsOf& rows) {
  rows_of_cloth_frame([&](Rows fields, const auto& measure) { rows.add(std::move(fields), measure); });
}

struct Figure {
  const char* name;
  void (*compute)(const FigureOptions& options, const Model& model, RowsOf& rows);
};

constexpr Figure all_figures[] = {{"cloth_convergence", cloth_convergence},
                                  {"levelset_blocks", levelset_blocks},
                                  {"levelset_slice", levelset_slice},
                                  {"contact_batches", contact_batches},
                                  {"production_modules", production_modules},
                                  {"face_modules", face_modules},
                                  {"cloth_modules", cloth_modules},
                                  {"sensitivity", sensitivity},
                                  {"problem_sizes", problem_sizes},
                                  {"curves", curves}};

}  // namespace

int figures(const FigureOptions& options) {
  std::vector<std::string> names;
  for (const Figure& figure : all_figures) names.push_back(figure.name);
  if (!options.report.empty() && std::ranges::find(names, options.report) == names.end())
    throw InputError("--report " + options.report + ": expected one of: " + joined(names, ", "));
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) throw InputError(options.out + ": cannot be made: " + error.message());
  const Model model = measure_model();
  for (const Figure& figure : all_figures) {
    if (!options.report.empty() && options.report != figure.name) continue;
    ReportOptions its = options;
    its.json = options.out + '/' + figure.name + ".json";
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
