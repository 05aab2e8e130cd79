// The numbers behind the figures: one CSV a figure, which notes/figures/NAME.py draws.
#include <omp.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <ostream>
#include <string>

#include "common/atomic_file.h"
#include "common/cloth/make.h"
#include "common/input_error.h"
#include "common/levelset/blocks.h"
#include "common/levelset/fast_marching.h"
#include "common/levelset/fast_sweeping.h"
#include "common/levelset/initialize.h"
#include "common/levelset/scene.h"
#include "common/rigid/batches.h"
#include "common/rigid/scene.h"
#include "common/rigid/step.h"
#include "verify/cloth_forms.h"
#include "verify/cloth_run.h"
#include "verify/options.h"
#include "verify/report.h"
#include "verify/rigid_run.h"

namespace lockstep::verify {
namespace {

// Residual over iterations, by the order in which constraints are enforced.
void cloth_convergence(std::ostream& csv) {
  csv << "scene,form,iterations,residual\n";
  for (const std::string scene : {"flag_33", "sheet_on_sphere", "rope", "pulled_edge"}) {
    const cloth::Cloth<float> start = cloth::convert<float>(cloth::load_scene("scenes/cloth/" + scene + ".toml").cloth);
    for (const ClothForm& form : cloth_forms)
      for (const int n : {5, 7, 10, 14, 20, 28, 40, 57, 80, 113, 160}) {
        progress("cloth_convergence: " + scene + ' ' + form.name + ", " + std::to_string(n) + " iterations");
        cloth::Relax<float>* const relax = form.openmp_relax ? form.openmp_relax : form.serial_relax;
        csv << scene << ',' << form.name << ',' << n << ',' << residual_left(start, relax, n) << '\n';
      }
  }
}

// What blocks cost and what they give: marching and sweeping in blocks of 256^3, at the threads that this machine has; and how much
// of the work is done more than once, which does not depend on a machine.
void levelset_blocks(std::ostream& csv) {
  const levelset::Scene scene = levelset::load_scene("scenes/levelset/spheres_and_box_256.toml");
  const auto band = static_cast<float>(scene.band);
  levelset::Distances<float> start, whole;
  levelset::openmp::initialize(scene.phi, start);
  whole = start;
  levelset::openmp::fast_sweeping_sweeps(whole, band, 1);
  const auto points_within = [](const levelset::Distances<float>& d) {
    return double(std::ranges::count_if(d.distance.value, [](float v) { return v < levelset::far<float>; }));
  };

  csv << "blocks,threads,algorithm,ms,work_points,band_points\n";
  for (const int side : {1, 2, 3, 4}) {
    const int size = (scene.grid.nx + side - 1) / side;
    // Each block on its own computes the distances of its padding, too.
    double work = 0;
    for (const levelset::Block& block : levelset::make_blocks(start, band, size)) {
      levelset::Distances<float> padded = levelset::cut_out(start, block);
      levelset::openmp::fast_sweeping_sweeps(padded, band, 1);
      work += points_within(padded);
    }
    for (int threads = 1; threads <= omp_get_num_procs(); threads *= 2)
      for (const std::string algorithm : {"fast_marching", "fast_sweeping"}) {
        progress("levelset_blocks: " + algorithm + ", " + std::to_string(side * side * side) + " blocks, " + std::to_string(threads) +
                 " threads");
        omp_set_num_threads(threads);
        double best = std::numeric_limits<double>::infinity();
        for (int repeat = 0; repeat < 3; ++repeat) {
          levelset::Distances<float> d = start;
          const double begin = now();
          if (algorithm == "fast_marching")
            levelset::openmp::fast_marching_blocks(d, band, size);
          else
            levelset::openmp::fast_sweeping_blocks(d, band, 1, size);
          best = std::min(best, now() - begin);
        }
        csv << side * side * side << ',' << threads << ',' << algorithm << ',' << 1e3 * best << ',' << work << ',' << points_within(whole)
            << '\n';
      }
  }
}

// The distances of a slice through the middle of the spheres and the box, and what first-order upwind makes of them.
void levelset_slice(std::ostream& csv) {
  const levelset::Scene scene = levelset::load_scene("scenes/levelset/spheres_and_box_128_full.toml");
  levelset::Distances<float> d;
  levelset::openmp::initialize(scene.phi, d);
  levelset::openmp::fast_sweeping_sweeps(d, static_cast<float>(scene.band), 4);
  csv << "x,y,distance,error_in_spacings\n";
  const int z = scene.grid.nz / 2;
  for (int y = 0; y < scene.grid.ny; ++y)
    for (int x = 0; x < scene.grid.nx; ++x) {
      const double exact = levelset::signed_distance(scene.shapes, scene.grid.position(x, y, z));
      const double found = scene.phi(x, y, z) < 0 ? -d.distance(x, y, z) : d.distance(x, y, z);
      csv << x << ',' << y << ',' << found << ',' << (found - exact) / scene.grid.spacing << '\n';
    }
}

// What reordering contacts into batches gives, and costs: ten sweeps over the settled contacts of a scene, in the original order (in
// parallel as far as that lets), and in batches, with the time to make them; and how large the batches are.
void contact_batches(std::ostream& csv) {
  using namespace rigid;
  csv << "scene,kind,threads,batch,value\n";
  for (const std::string scene_name : {"pyramid_24", "box_pit_4000", "hull_pit_2000", "castle_hit"}) {
    const Scene scene = load_scene("scenes/rigid/" + scene_name + ".toml");
    const StepSettings settings = settings_of(scene);
    World<float> world = scene.world;
    StepMemory<float> memory;
    for (int step = 0; step < std::max(scene.settle, 1); ++step) {
      progress("contact_batches: " + scene_name + ", step " + std::to_string(step));
      openmp::step_batches(settings, world, memory);
    }
    const std::span<const std::int32_t> body(world.colliders.body.data(), world.colliders.count);
    const auto median_ms = [&](const auto& solve) {
      constexpr int repeats = 15;
      std::vector<double> ms;
      for (int repeat = 0; repeat < repeats; ++repeat) {
        Bodies<float> bodies = world.bodies;
        Array<Impulses<float>> impulses = memory.impulses;
        const double begin = now();
        solve(bodies, std::span<Impulses<float>>(impulses));
        ms.push_back(1e3 * (now() - begin));
      }
      std::ranges::nth_element(ms, ms.begin() + repeats / 2);
      return ms[repeats / 2];
    };
    const auto row = [&](const char* kind, int threads, int batch, double value) {
      csv << scene_name << ',' << kind << ',' << threads << ',' << batch << ',' << value << '\n';
    };
    Array<Motion<float>> moving;
    const auto original = [&](SolveOriginal<float>* solve) {
      return median_ms([&](Bodies<float>& bodies, std::span<Impulses<float>> impulses) {
        solve(settings.solver, memory.manifolds, body, bodies, impulses, moving);
      });
    };
    const auto batched = [&](SolveBatches<float>* solve, ReorderContacts<float>* reorder) {
      return median_ms([&](Bodies<float>& bodies, std::span<Impulses<float>> impulses) {
        solve(settings.solver, memory.manifolds, body, reorder(memory.manifolds, body, bodies), bodies, impulses, moving);
      });
    };
    row("serial_original_ms", 1, 0, original(serial::solve_contacts_original));
    row("serial_batches_ms", 1, 0, batched(serial::solve_contacts_batches, serial::reorder_contacts));
    for (int threads = 1; threads <= omp_get_num_procs(); ++threads) {
      omp_set_num_threads(threads);
      row("original_ms", threads, 0, original(openmp::solve_contacts_original));
      row("batches_ms", threads, 0, batched(openmp::solve_contacts_batches, openmp::reorder_contacts));
      row("reorder_ms", threads, 0,
          median_ms([&](Bodies<float>& bodies, std::span<Impulses<float>>) { openmp::reorder_contacts(memory.manifolds, body, bodies); }));
    }
    const Batches batches = serial::reorder_contacts(memory.manifolds, body, world.bodies);
    for (int k = 0; k < batches.count(); ++k) row("batch_size", 0, k, batches.begin[k + 1] - batches.begin[k]);
  }
}

struct Figure {
  const char* name;
  void (*write)(std::ostream& csv);
};

constexpr Figure all_figures[] = {{"cloth_convergence", cloth_convergence},
                                  {"levelset_blocks", levelset_blocks},
                                  {"levelset_slice", levelset_slice},
                                  {"contact_batches", contact_batches}};

}  // namespace

int figures(const FigureOptions& options) {
  std::error_code error;
  std::filesystem::create_directories(options.out, error);
  if (error) throw InputError(options.out + ": cannot be made: " + error.message());
  for (const Figure& figure : all_figures) {
    const std::string path = options.out + '/' + figure.name + ".csv";
    write_file(path, figure.write);
    progress("");
    std::printf("%s\n", path.c_str());
  }
  return 0;
}

}  // namespace lockstep::verify
