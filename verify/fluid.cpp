// The game fluid's kernels, as the verifier and the benchmark see them.
//
// Kernels are compared on a scene's state after a few frames, each on the same inputs: what the serial float run hands it.
// notes/fluid.md derives the bounds; notes/verification.md says what each verdict asserts.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>

#include "common/fluid/advance.h"
#include "common/fluid/collisions.h"
#include "common/fluid/convert.h"
#include "common/fluid/densities.h"
#include "common/fluid/forces.h"
#include "common/fluid/rebuild_grid.h"
#include "common/fluid/scene.h"
#include "openmp/fluid/candidates.h"
#include "verify/compare.h"
#include "verify/fluid_bounds.h"
#include "verify/fluid_forms.h"
#include "verify/fluid_run.h"
#include "verify/domain.h"
#include "verify/kernel.h"

namespace lockstep::verify {
namespace {

using namespace fluid;

// Frames before kernels are compared: particles have left their lattice and meet walls; or what was shot is still under way, and some of it
// beyond a wall: splash hits one in its 12th frame and one in its 13th, at up to two cells and more a frame.
constexpr int settling_frames = 40, frames_of_a_shot = 13;

int frames_before(const Scene& scene) {
  if (scene.holds.lattice_density) return 0;  // a lattice stays one, so that its analytic density can be asked for
  const Vectors<float>& v = scene.particles.velocity;
  for (int i = 0; i < scene.particles.count; ++i)
    if (v.x[i] != 0 || v.y[i] != 0 || v.z[i] != 0) return frames_of_a_shot;
  return settling_frames;
}

// What a kernel must overwrite before it reads it.
constexpr float left_over = std::numeric_limits<float>::quiet_NaN();

// A scene as each kernel finds it, with the serial answers and the truth. Made once a scene; shared by all kernels.
struct Inputs {
  Scene scene;
  Particles<float> unsorted;  // rebuild_grid's
  Fluid<float> fluid;         // sorted, with the density and acceleration that the serial kernels give
  Fluid<double> truth;        // the same numbers, widened
  std::vector<double> true_density;
  std::vector<double> density_rounding;
  double tested_pairs = 0, near_pairs = 0;  // in neighbouring cells; within h
};

std::span<const float> first(const Array<float>& array, int count) { return {array.data(), static_cast<std::size_t>(count)}; }
std::span<const double> first(const Array<double>& array, int count) { return {array.data(), static_cast<std::size_t>(count)}; }

void count_pairs(Inputs& in) {
  const Grid<float>& grid = in.fluid.grid;
  const Vectors<float>& p = in.fluid.particles.position;
  for (int z = 0; z < grid.z.cells; ++z)
    for (int y = 0; y < grid.y.cells; ++y)
      for (int x = 0; x < grid.x.cells; ++x) {
        const Run own = row_run(grid, x, x, y, z);
        for (int i = own.begin; i < own.end; ++i)
          for (const Run& run : forward_runs(grid, x, y, z))
            for (int j = std::max(run.begin, i + 1); j < run.end; ++j) {
              const float dx = p.x[i] - p.x[j], dy = p.y[i] - p.y[j], dz = p.z[i] - p.z[j];
              in.tested_pairs += 1;
              in.near_pairs += dx * dx + dy * dy + dz * dz < in.fluid.model.smoothing_length_2;
            }
      }
}

std::shared_ptr<const Inputs> make_inputs(const std::string& path) {
  Scene scene = load_scene(path);
  auto in = std::make_shared<Inputs>();
  in->fluid = make_fluid(fluid::convert<float>(scene.model), scene.particles);
  in->scene = std::move(scene);
  Fluid<float>& f = in->fluid;
  const int frames = frames_before(in->scene);
  for (int frame = 0; frame < frames; ++frame) serial::step_symmetric(f);
  in->unsorted = f.particles;
  serial::rebuild_grid(f.grid, f.particles, f.sorted);
  serial::densities_owner_gather(f.model, f.grid, f.particles, f.neighbours, f.density);
  serial::forces_symmetric(f.model, f.grid, f.particles, f.neighbours, f.density, f.acceleration);
  in->truth = convert<double>(f);
  Fluid<double> truth = in->truth;
  serial::densities_symmetric(truth.model, truth.grid, truth.particles, truth.neighbours, truth.density);
  in->true_density.assign(truth.density.begin(), truth.density.begin() + f.particles.count);
  in->density_rounding = density_rounding(in->truth, in->true_density);
  count_pairs(*in);
  return in;
}

// Kept for the scenes of one kernel after another; a user's scene may be large, so only while there are few.
std::shared_ptr<const Inputs> inputs(const std::string& path) {
  static std::map<std::string, std::shared_ptr<const Inputs>> known;
  const auto found = known.find(path);
  return found != known.end() ? found->second : known[path] = make_inputs(path);
}

ElementName particle_name(const Inputs& in, const char* what) {
  return [&in, what](std::size_t i) {
    const auto& p = in.fluid.particles;
    char text[160];
    std::snprintf(text, sizeof text, "%s of particle %d at (%.4g %.4g %.4g)", what, p.id[i], p.position.x[i], p.position.y[i],
                  p.position.z[i]);
    return std::string(text);
  };
}

std::uint64_t hash_of(const Vectors<float>& v, int count, std::uint64_t hash) {
  return hash_bytes(first(v.z, count), hash_bytes(first(v.y, count), hash_bytes(first(v.x, count), hash)));
}

std::uint64_t hash_of(const Particles<float>& p) {
  const std::uint64_t ids = hash_bytes(std::span<const std::int32_t>(p.id.data(), p.count));
  return hash_of(p.velocity, p.count, hash_of(p.half_velocity, p.count, hash_of(p.position, p.count, ids)));
}

void same_bits(Judgement& judgement, const Vectors<float>& openmp, const Vectors<float>& serial, int count, const ElementName& name) {
  same_bits(judgement, first(openmp.x, count), first(serial.x, count), name);
  same_bits(judgement, first(openmp.y, count), first(serial.y, count), name);
  same_bits(judgement, first(openmp.z, count), first(serial.z, count), name);
}

void same_bits(Judgement& judgement, const Particles<float>& openmp, const Particles<float>& serial, const ElementName& name) {
  same_bits(judgement, std::span<const std::int32_t>(openmp.id.data(), openmp.count), {serial.id.data(), std::size_t(serial.count)}, name);
  same_bits(judgement, openmp.position, serial.position, serial.count, name);
  same_bits(judgement, openmp.half_velocity, serial.half_velocity, serial.count, name);
  same_bits(judgement, openmp.velocity, serial.velocity, serial.count, name);
}

constexpr double particle_bytes = 10 * 4;  // id, position and two velocities

Case rebuild_grid_case(const std::string& path, RebuildGrid<float>* openmp) {
  struct State {
    std::shared_ptr<const Inputs> in;
    Grid<float> grid;
    Particles<float> openmp, sorted;
  };
  auto s = std::make_shared<State>(State{inputs(path), {}, {}, {}});
  const double n = s->in->fluid.particles.count, cells = s->in->fluid.grid.cells();
  return {
      .reset =
          [s] {
            s->grid = s->in->fluid.grid, s->openmp = s->sorted = s->in->unsorted;
            std::ranges::fill(s->grid.cell_begin, -1);
          },
      .serial = [s] { serial::rebuild_grid(s->grid, s->openmp, s->sorted); },
      .best_serial = nullptr,
      .openmp = [s, openmp] { openmp(s->grid, s->openmp, s->sorted); },
      .judge =
          [s] {
            const ElementName name = particle_name(*s->in, "place");
            Judgement judgement{.verdict = Verdict::bitwise, .worst_at = ""};
            same_bits(judgement, std::span<const std::int32_t>(s->grid.cell_begin),
                      std::span<const std::int32_t>(s->in->fluid.grid.cell_begin),
                      [](std::size_t c) { return "begin of cell " + std::to_string(c); });
            same_bits(judgement, s->openmp, s->in->fluid.particles, name);
            return judgement;
          },
      .hash = [s] { return hash_of(s->openmp); },
      .work = {n, "particles", 2 * particle_bytes * n + 4 * cells, 9 * n, lanes_in_use(std::array{n})},
  };
}

// The lists of neighbours that densities leave for the forces: the same ones, in the same order.
void same_lists(Judgement& judgement, const Inputs& in, const Neighbours<float>& openmp, const Neighbours<float>& serial) {
  const Grid<float>& grid = in.fluid.grid;
  const int count = in.fluid.particles.count;
  Judgement lists{.verdict = Verdict::bitwise, .worst_at = ""};
  same_bits(lists, std::span(openmp.end.data(), count), std::span(serial.end.data(), count), particle_name(in, "end of the list"));
  const auto same = [&](const auto& of_openmp, const auto& of_serial, const Run& run, const std::string& where) {
    if (!lists.passed || of_serial.empty() || run.begin == run.end) return;
    const std::size_t n = serial.end[run.end - 1];
    const ElementName name = [&](std::size_t k) { return "entry " + std::to_string(k) + " of the list of " + where; };
    if (of_openmp.size() < n)
      lists.passed = false, lists.worst_at = "the list of " + where + " is too short";
    else
      same_bits(lists, std::span(of_openmp.data(), n), std::span(of_serial.data(), n), name);
  };
  for (int z = 0; z < grid.z.cells; ++z) {
    for (int y = 0; y < grid.y.cells; ++y) {
      const int row = z * grid.y.cells + y;
      same(openmp.row[row], serial.row[row], row_run(grid, 0, grid.x.cells - 1, y, z), "row " + std::to_string(row));
    }
    same(openmp.plane[z], serial.plane[z], plane_run(grid, z, z), "plane " + std::to_string(z));
    same(openmp.distance_2[z], serial.distance_2[z], plane_run(grid, z, z), "distances in plane " + std::to_string(z));
  }
  if (lists.passed) return;
  judgement.passed = false;
  judgement.worst_at = lists.worst_at;
}

// How many candidates each particle is tested against in vectors of their own; none for the forms that test them where they are.
std::vector<int> numbers_of_candidates(const Fluid<float>& fluid, Densities<float>* form) {
  const bool pairs = form == openmp::densities_pair_lists;
  if (!pairs && form != openmp::densities_owner_gather) return {};
  const Grid<float>& grid = fluid.grid;
  const Vectors<float>& position = fluid.particles.position;
  const int block = pairs ? openmp::block_cells : 1;
  openmp::Candidates candidates;
  std::vector<int> numbers;
  for (int z = 0; z < grid.z.cells; ++z)
    for (int y = 0; y < grid.y.cells; ++y)
      for (int x = 0; x < grid.x.cells; x += block) {
        const Run own = row_run(grid, x, x + block - 1, y, z);
        if (pairs)
          candidates.pack_near(own, forward_runs(grid, x, x + block - 1, y, z), position, fluid.model.smoothing_length_2);
        else
          candidates.pack(neighbour_runs(grid, x, y, z), position);
        numbers.insert(numbers.end(), own.end - own.begin, candidates.count);
      }
  return numbers;
}

Case densities_case(const std::string& path, Densities<float>* twin, Densities<float>* openmp) {
  struct State {
    std::shared_ptr<const Inputs> in;
    Neighbours<float> openmp_neighbours, serial_neighbours;
    Array<float> openmp, serial, unused;
  };
  auto s = std::make_shared<State>(State{inputs(path), {}, {}, {}, {}, {}});
  const Fluid<float>& f = s->in->fluid;
  const double n = f.particles.count;
  Densities<float>* best = serial::densities_symmetric;
  const auto with = [s](Densities<float>* densities, Neighbours<float>& neighbours, Array<float>& density) -> std::function<void()> {
    return [s, densities, &neighbours, &density] {
      densities(s->in->fluid.model, s->in->fluid.grid, s->in->fluid.particles, neighbours, density);
    };
  };
  s->openmp_neighbours = s->serial_neighbours = make_neighbours(f.grid, f.particles.count);
  s->openmp = s->serial = s->unused = Array<float>(padded(f.particles.count));
  return {
      .reset =
          [s] {
            Neighbours<float>& n = s->openmp_neighbours;
            std::ranges::fill(s->openmp, left_over), std::ranges::fill(n.scratch, left_over), std::ranges::fill(n.end, 0);
            for (auto& list : n.row) std::ranges::fill(list, 0);
            for (auto& list : n.plane) std::ranges::fill(list, 0);
            for (auto& list : n.distance_2) std::ranges::fill(list, left_over);
          },
      .serial = with(twin, s->serial_neighbours, s->serial),
      .best_serial = twin == best ? nullptr : with(best, s->serial_neighbours, s->unused),
      .openmp = with(openmp, s->openmp_neighbours, s->openmp),
      .judge =
          [s] {
            const Inputs& in = *s->in;
            const int count = in.fluid.particles.count;
            Judgement judgement{.verdict = Verdict::bounded, .worst_at = ""};
            within_bound(judgement, first(s->openmp, count), first(s->serial, count), in.true_density, in.density_rounding,
                         particle_name(in, "density"));
            same_lists(judgement, in, s->openmp_neighbours, s->serial_neighbours);
            if (in.scene.holds.lattice_density) check_lattice_density(judgement, in.truth, s->openmp);
            return judgement;
          },
      .hash = [s] { return hash_bytes(first(s->openmp, s->in->fluid.particles.count)); },
      .work = {n, "particles", 16 * n, 8 * s->in->tested_pairs + 5 * s->in->near_pairs, lanes_in_use(numbers_of_candidates(f, openmp))},
  };
}

// How long the lists are that start in a vector of their own: a particle's of the owner-gather lists, a row's of the pair lists.
std::vector<int> lengths_of_lists(const Grid<float>& grid, const Neighbours<float>& neighbours) {
  std::vector<int> lengths;
  for (int z = 0; z < grid.z.cells; ++z)
    for (int y = 0, of_plane = 0; y < grid.y.cells; ++y) {
      const Run row = row_run(grid, 0, grid.x.cells - 1, y, z);
      if (row.begin == row.end) continue;
      if (!neighbours.plane[z].empty()) {
        lengths.push_back(neighbours.end[row.end - 1] - of_plane);
        of_plane = neighbours.end[row.end - 1];
      } else {
        for (int i = row.begin, begin = 0; i < row.end; begin = neighbours.end[i++]) lengths.push_back(neighbours.end[i] - begin);
      }
    }
  return lengths;
}

Case forces_case(const std::string& path, Densities<float>* lists, Forces<float>* twin, Forces<float>* openmp) {
  struct State {
    std::shared_ptr<const Inputs> in;
    Neighbours<float> neighbours;  // those of the serial densities; a copy, for the scratch in it
    Vectors<float> openmp, serial, unused;
    Vectors<double> truth, rounding;
  };
  auto s = std::make_shared<State>(State{inputs(path), {}, {}, {}, {}, {}, {}});
  const Fluid<float>& f = s->in->fluid;
  s->neighbours = make_neighbours(f.grid, f.particles.count);
  Array<float> density = f.density;
  if (lists) lists(f.model, f.grid, f.particles, s->neighbours, density);
  Fluid<double> truth = s->in->truth;
  const int count = f.particles.count;
  const double n = count;
  for (Vectors<float>* v : {&s->openmp, &s->serial, &s->unused}) v->resize(count);
  s->truth.resize(count);
  serial::forces_symmetric(truth.model, truth.grid, truth.particles, truth.neighbours, truth.density, s->truth);
  s->rounding = force_rounding(truth, truth.density, std::vector<double>(count, 0));
  Forces<float>* best = serial::forces_symmetric;
  const auto with = [s](Forces<float>* forces, Vectors<float>& a) -> std::function<void()> {
    return
        [s, forces, &a] { forces(s->in->fluid.model, s->in->fluid.grid, s->in->fluid.particles, s->neighbours, s->in->fluid.density, a); };
  };
  return {
      .reset =
          [s, count] {
            s->openmp = Vectors<float>(), s->openmp.resize(count);
            std::ranges::fill(s->neighbours.scratch, left_over);
          },
      .serial = with(twin, s->serial),
      .best_serial = twin == best ? nullptr : with(best, s->unused),
      .openmp = with(openmp, s->openmp),
      .judge =
          [s, count] {
            Judgement judgement{.verdict = Verdict::bounded, .worst_at = ""};
            const auto axis = [&](const auto& openmp, const auto& serial, const auto& truth, const auto& rounding, const char* what) {
              within_bound(judgement, first(openmp, count), first(serial, count), first(truth, count), first(rounding, count),
                           particle_name(*s->in, what));
            };
            axis(s->openmp.x, s->serial.x, s->truth.x, s->rounding.x, "x acceleration");
            axis(s->openmp.y, s->serial.y, s->truth.y, s->rounding.y, "y acceleration");
            axis(s->openmp.z, s->serial.z, s->truth.z, s->rounding.z, "z acceleration");
            return judgement;
          },
      .hash = [s, count] { return hash_of(s->openmp, count, 0); },
      .work = {n, "particles", 40 * n, 8 * s->in->tested_pairs + 33 * s->in->near_pairs,
               lists ? lanes_in_use(lengths_of_lists(f.grid, s->neighbours)) : 0},
  };
}

Case collisions_case(const std::string& path) {
  struct State {
    std::shared_ptr<const Inputs> in;
    Vectors<float> openmp, serial;
  };
  auto s = std::make_shared<State>(State{inputs(path), {}, {}});
  const double n = s->in->fluid.particles.count;
  const auto with = [s](Collisions<float>* collisions, Vectors<float>& a) {
    return [s, collisions, &a] { collisions(s->in->fluid.model, s->in->fluid.grid, s->in->fluid.particles, a); };
  };
  return {
      .reset = [s] { s->openmp = s->serial = s->in->fluid.acceleration; },
      .serial = with(serial::collisions, s->serial),
      .best_serial = nullptr,
      .openmp = with(openmp::collisions, s->openmp),
      .judge =
          [s] {
            Judgement judgement{.verdict = Verdict::bitwise, .worst_at = ""};
            Vectors<float> serial = s->in->fluid.acceleration;
            serial::collisions(s->in->fluid.model, s->in->fluid.grid, s->in->fluid.particles, serial);
            same_bits(judgement, s->openmp, serial, s->in->fluid.particles.count, particle_name(*s->in, "acceleration"));
            return judgement;
          },
      .hash = [s] { return hash_of(s->openmp, s->in->fluid.particles.count, 0); },
      .work = {n, "particles", 60 * n, 3 * 16 * n, lanes_in_use(std::array{n})},
  };
}

Case advance_case(const std::string& path) {
  struct State {
    std::shared_ptr<const Inputs> in;
    Particles<float> openmp, serial;
  };
  auto s = std::make_shared<State>(State{inputs(path), {}, {}});
  const double n = s->in->fluid.particles.count;
  const auto with = [s](Advance<float>* advance, Particles<float>& particles) {
    return [s, advance, &particles] { advance(s->in->fluid.model, s->in->fluid.grid, s->in->fluid.acceleration, particles); };
  };
  return {
      .reset = [s] { s->openmp = s->serial = s->in->fluid.particles; },
      .serial = with(serial::advance, s->serial),
      .best_serial = nullptr,
      .openmp = with(openmp::advance, s->openmp),
      .judge =
          [s] {
            Judgement judgement{.verdict = Verdict::bitwise, .worst_at = ""};
            Particles<float> serial = s->in->fluid.particles;
            serial::advance(s->in->fluid.model, s->in->fluid.grid, s->in->fluid.acceleration, serial);
            same_bits(judgement, s->openmp, serial, particle_name(*s->in, "state"));
            return judgement;
          },
      .hash = [s] { return hash_of(s->openmp); },
      .work = {n, "particles", 72 * n, 3 * 10 * n, lanes_in_use(std::array{n})},
  };
}

Case step_case(const std::string& path, const StepForm& form) {
  struct State {
    std::shared_ptr<const Inputs> in;
    Fluid<float> start, openmp, serial;
  };
  auto s = std::make_shared<State>();
  s->in = inputs(path);
  s->start = s->in->fluid;
  s->start.particles = s->in->unsorted;
  s->openmp = s->serial = s->start;
  const double n = s->start.particles.count, cells = s->start.grid.cells();
  Step<float>*best = serial::step_symmetric, *twin = best;
  if (form.name == "owner_gather") twin = serial::step_owner_gather;
  if (form.name == "pair_lists") twin = serial::step_pair_lists;
  return {
      // Particles are what a step starts from; all else it makes, or, like the room in lists, has from the frame before.
      .reset = [s] { s->openmp.particles = s->serial.particles = s->start.particles; },
      .serial = [s, twin] { twin(s->serial); },
      .best_serial = twin == best ? std::function<void()>() : [s, best] { best(s->serial); },
      .openmp = [s, form] { form.step(s->openmp); },
      .judge =
          [s, path, form, twin] {
            static std::map<std::string, FreeRuns> known;
            if (!known.contains(path)) known[path] = run_freely(s->start, s->in->scene.frames);
            Judgement judgement{.verdict = Verdict::physical, .worst_at = ""};
            Fluid<float> serial = s->start;
            twin(serial);
            check_one_step(judgement, s->start, s->openmp, serial);
            check_free_run(judgement, known[path], s->in->scene.holds, s->start, form.step);
            return judgement;
          },
      .hash = [s] { return hash_of(s->openmp.particles); },
      .work = {n, "particles", 2 * particle_bytes * n + 4 * cells + (16 + 40 + 60 + 72) * n,
               16 * s->in->tested_pairs + 38 * s->in->near_pairs + 87 * n},
  };
}

}  // namespace

std::vector<Kernel> fluid_kernels() {
  const auto scene = [](const char* name) { return std::string("scenes/fluid/") + name + ".toml"; };
  const std::vector<std::string> scenes = {scene("dam_break_5k"), scene("lattice_5k"), scene("splash"),      scene("clump"),
                                           scene("single"),       scene("adrift"),     scene("lattice_35k"), scene("dam_break_100k")};
  const std::vector<std::string> more_scenes = {scene("dam_break_35k"), scene("lattice_100k"), scene("dam_break_500k"),
                                                scene("lattice_500k")};
  const std::vector<std::string> bench_scenes = {scene("dam_break_100k")};
  std::vector<Kernel> kernels;
  const auto add = [&](const char* name, const char* form, bool order_dependent, std::function<Case(const std::string&)> make) {
    const auto takes = [](const std::string& path) { return domain_of_scene(path).name == "fluid"; };
    kernels.push_back({name, form, order_dependent, scenes, more_scenes, bench_scenes, takes, std::move(make)});
  };
  using namespace openmp;
  add("fluid/rebuild_grid", "counting_sort", false, [](auto& path) { return rebuild_grid_case(path, rebuild_grid_counting_sort); });
  add("fluid/rebuild_grid", "linked_lists", false, [](auto& path) { return rebuild_grid_case(path, rebuild_grid_linked_lists); });
  add("fluid/densities", "owner_gather", false,
      [](auto& path) { return densities_case(path, serial::densities_owner_gather, densities_owner_gather); });
  add("fluid/densities", "pair_lists", false,
      [](auto& path) { return densities_case(path, serial::densities_pair_lists, densities_pair_lists); });
  add("fluid/densities", "sub_grid", true,
      [](auto& path) { return densities_case(path, serial::densities_symmetric, densities_sub_grid); });
  add("fluid/densities", "cell_locks", true,
      [](auto& path) { return densities_case(path, serial::densities_symmetric, densities_cell_locks); });
  add("fluid/forces", "owner_gather", false,
      [](auto& path) { return forces_case(path, serial::densities_owner_gather, serial::forces_owner_gather, forces_owner_gather); });
  add("fluid/forces", "pair_lists", false,
      [](auto& path) { return forces_case(path, serial::densities_pair_lists, serial::forces_pair_lists, forces_pair_lists); });
  add("fluid/forces", "sub_grid", true, [](auto& path) { return forces_case(path, nullptr, serial::forces_symmetric, forces_sub_grid); });
  add("fluid/forces", "cell_locks", true,
      [](auto& path) { return forces_case(path, nullptr, serial::forces_symmetric, forces_cell_locks); });
  add("fluid/collisions", "", false, collisions_case);
  add("fluid/advance", "", false, advance_case);
  for (const StepForm& form : step_forms)
    if (form.variant == "openmp")
      add("fluid/step", form.name.c_str(), form.name != "owner_gather" && form.name != "pair_lists",
          [form](auto& path) { return step_case(path, form); });
  for (Kernel& kernel : kernels)
    if (kernel.name == "fluid/step")
      kernel.bench_scenes = {scene("dam_break_5k"), scene("dam_break_35k"), scene("dam_break_100k"), scene("dam_break_500k")};
  return kernels;
}

}  // namespace lockstep::verify
