// The racy twin of openmp/: loops of its kernels over the same building blocks, each with one planted mistake, which
// the thread sanitizer must flag. `make tsan` runs it. A sanitizer that misses these mistakes proves nothing about the
// kernels.
//
// Usage: racy MISTAKE, from the root of the repository. The exit code is 0 if nothing flags the mistake. Without an
// argument it lists the mistakes and their scenes: the clump, with all particles in one cell, where any two threads
// meet; the dam break, where threads meet only at the borders of their shares; and a flag with rows for several bands
// at each thread count.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "common/cloth/make.h"
#include "common/cloth/project.h"
#include "common/cloth/scene.h"
#include "common/fluid/convert.h"
#include "common/fluid/fluid.h"
#include "common/fluid/rebuild_grid.h"
#include "common/fluid/scene.h"
#include "common/rigid/contact_solver.h"
#include "common/rigid/scene.h"
#include "common/simd.h"
#include "openmp/cloth/schedule.h"
#include "openmp/fluid/sub_grids.h"

namespace {

using namespace lockstep;
using namespace lockstep::fluid;
using namespace lockstep::openmp;
using namespace lockstep::fluid::openmp;

int cell_of(const Grid<float>& grid, const Vectors<float>& p, int i) {
  return grid.cell(cell_coordinate(grid.x, p.x[i]), cell_coordinate(grid.y, p.y[i]), cell_coordinate(grid.z, p.z[i]));
}

// Particles are pushed on lists of cells without a lock.
void list_without_lock(Fluid<float>& fluid) {
  std::vector<int> head(fluid.grid.cells(), -1), next(fluid.particles.count);
#pragma omp parallel for schedule(static)
  for (int i = 0; i < fluid.particles.count; ++i) {
    const int cell = cell_of(fluid.grid, fluid.particles.position, i);
    next[i] = head[cell];
    head[cell] = i;
  }
}

// The same under the wrong lock: the particle's instead of its cell's.
void list_under_wrong_lock(Fluid<float>& fluid) {
  std::vector<int> head(fluid.grid.cells(), -1), next(fluid.particles.count);
  Locks locks(fluid.particles.count);
#pragma omp parallel for schedule(static)
  for (int i = 0; i < fluid.particles.count; ++i) {
    const int cell = cell_of(fluid.grid, fluid.particles.position, i);
    const Guard guard(locks, i);
    next[i] = head[cell];
    head[cell] = i;
  }
}

// Each thread counts, then sums over threads are taken, with no barrier in between.
void sort_without_barrier(Fluid<float>& fluid) {
  std::vector<std::vector<int>> counts(omp_get_max_threads(), std::vector<int>(fluid.grid.cells()));
#pragma omp parallel
  {
    const Share mine = my_share(fluid.particles.count), cells = my_share(fluid.grid.cells());
    for (int i = mine.begin; i < mine.end; ++i)
      ++counts[omp_get_thread_num()][cell_of(fluid.grid, fluid.particles.position, i)];
    for (int cell = cells.begin; cell < cells.end; ++cell) {
      int sum = 0;
      for (int thread = 0; thread < omp_get_num_threads(); ++thread) sum += counts[thread][cell];
      fluid.grid.cell_begin[cell] = sum;
    }
  }
}

// Pairs in sub-grids are counted at both particles, without locks for the cells at the borders.
void pairs_without_lock(Fluid<float>& fluid) {
  serial::rebuild_grid(fluid.grid, fluid.particles, fluid.sorted);
  const SubGrids sub_grids = make_sub_grids(fluid.grid, omp_get_max_threads());
  Array<float> pairs(padded(fluid.particles.count));
#pragma omp parallel for schedule(static, 1)
  for (const SubGrid& sub_grid : sub_grids.sub_grid)
    for (int z = sub_grid.z.begin; z < sub_grid.z.end; ++z)
      for (int y = sub_grid.y.begin; y < sub_grid.y.end; ++y)
        for (int x = sub_grid.x.begin; x < sub_grid.x.end; ++x) {
          const Run own = row_run(fluid.grid, x, x, y, z);
          forward_pieces(fluid.grid, sub_grids, x, y, z, [&](const Piece& piece) {
            for (int i = own.begin; i < own.end; ++i)
              for (int j = std::max(piece.run.begin, i + 1); j < piece.run.end; j += lanes) {
                const maskv inside = first_lanes(piece.run.end - j);
                store(&pairs[j], load(&pairs[j], inside) + 1.f, inside);
                pairs[i] += static_cast<float>(std::min(piece.run.end - j, lanes));
              }
          });
        }
}

// The contents of each cell are copied to one buffer that all threads share.
void buffer_shared(Fluid<float>& fluid) {
  serial::rebuild_grid(fluid.grid, fluid.particles, fluid.sorted);
  Array<float> buffer(padded(fluid.particles.count));
  // Not dynamic: one thread might take every cell before the other wakes up, and then no race happens.
#pragma omp parallel for schedule(static)
  for (int cell = 0; cell < fluid.grid.cells(); ++cell)
    for (int i = fluid.grid.cell_begin[cell]; i < fluid.grid.cell_begin[cell + 1]; ++i)
      buffer[i - fluid.grid.cell_begin[cell]] = fluid.particles.position.x[i];
}

// One loop sets numbers and the next scales them, in other shares, with `nowait` between the loops.
void loops_without_barrier(Fluid<float>& fluid) {
  Array<float> density(padded(fluid.particles.count));
#pragma omp parallel
  {
#pragma omp for simd schedule(static) nowait
    for (int i = 0; i < fluid.particles.count; ++i) density[i] = 1;
#pragma omp for schedule(static, 16)
    for (int i = 0; i < fluid.particles.count; ++i) density[i] *= 2;
  }
}

// --- Cloth. Constraints along a row stay within it, so these sweeps omit them.

using cloth::Cloth;
using cloth::openmp::Units;

void enforce(Cloth<float>& cloth, int a, int b, float rest_2) {
  Vectors<float>& p = cloth.position;
  cloth::Point<float> pa = {p.x[a], p.y[a], p.z[a], cloth.inverse_mass[a]},
                      pb = {p.x[b], p.y[b], p.z[b], cloth.inverse_mass[b]};
  cloth::project(pa, pb, rest_2);
  if (pa.w > 0) p.x[a] = pa.x, p.y[a] = pa.y, p.z[a] = pa.z;
  if (pb.w > 0) p.x[b] = pb.x, p.y[b] = pb.y, p.z[b] = pb.z;
}

void enforce_row(Cloth<float>& cloth, const cloth::Family<float>& family, int row) {
  const cloth::Sheet& sheet = cloth.sheet;
  for (int c = std::max(0, -family.right); c < sheet.columns - std::max(0, family.right); ++c)
    enforce(cloth, sheet.index(row, c), sheet.index(row + family.down, c + family.right), family.rest_2);
}

// Bands of the sheet, then the seams between them, with no barrier in between.
void seams_without_barrier(Cloth<float>& cloth) {
  Units units;
  const int passes = 2 * static_cast<int>(cloth.families.size());
  for (int pass = 0; pass < passes; ++pass)
    if (const int down = cloth.families[pass / 2].down; down > 0)
      for (int r = 0; r + down < cloth.sheet.rows; ++r)
        if (r / down % 2 == pass % 2) units.push_back({pass, r, r + down + 1, down});
  constexpr int period = 4;  // rows: colours alternate every row, and every two rows
  const cloth::openmp::Bands shared =
      cloth::openmp::cut_into_bands(units, cloth.sheet.rows, period, omp_get_max_threads());
  const int bands = static_cast<int>(shared.bands.size());
#pragma omp parallel
  {
#pragma omp for schedule(static, 1) nowait
    for (int band = 0; band < bands; ++band)
      for (const auto& unit : shared.bands[band]) enforce_row(cloth, cloth.families[unit.pass / 2], unit.begin);
#pragma omp for schedule(static, 1)
    for (int seam = 0; seam < bands; ++seam)
      for (const auto& unit : shared.seams[seam]) enforce_row(cloth, cloth.families[unit.pass / 2], unit.begin);
  }
}

// Bands by stages, two apart within a stage, with no barrier between stages.
void stages_without_barrier(Cloth<float>& cloth) {
  constexpr int iterations = 2;
  Units units;
  for (int f = 0; f < static_cast<int>(cloth.families.size()); ++f)
    if (const int down = cloth.families[f].down; down > 0)
      for (int r = 0; r + down < cloth.sheet.rows; ++r) units.push_back({f, r, r + down + 1, down});
  const std::vector<Units> stages = cloth::openmp::cut_into_stages(units, cloth.sheet.rows, 2 * omp_get_max_threads());
  const int bands = static_cast<int>(stages.size());
#pragma omp parallel
  for (int stage = 0; stage < 2 * (iterations - 1) + bands; ++stage) {
#pragma omp for schedule(static, 1) nowait
    for (int band = stage % 2; band < bands; band += 2) {
      if (band > stage || (stage - band) / 2 >= iterations) continue;
      for (const auto& unit : stages[band]) enforce_row(cloth, cloth.families[unit.pass], unit.begin);
    }
  }
}

// Contacts of neighbouring bodies in a ring, all in one batch, although each body is in two contacts.
void batch_sharing_bodies(rigid::World<float>& world) {
  const int n = world.bodies.count;
  Array<rigid::Manifold<float>> manifolds(n);
  Batches batches{{}, {0, n}};
  std::vector<std::int32_t> body(n);
  for (int i = 0; i < n; ++i) {
    manifolds[i] = {.normal = {1, 0, 0},
                    .count = 1,
                    .a = i,
                    .b = (i + 1) % n,
                    .unused = {},
                    .point = {},
                    .feature = {},
                    .more_unused = {}};
    manifolds[i].point[0] = {world.bodies.pose[i].position, 0};
    batches.order.push_back(i);
    body[i] = i;
  }
  Array<rigid::Impulses<float>> impulses(n);
  Array<rigid::Motion<float>> moving;
  rigid::SolverSettings settings;
  settings.time_step = .01, settings.gravity = {0, 0, 0};
  const std::span<const rigid::Manifold<float>> contacts(manifolds);
  rigid::openmp::contact_solver_batches(settings, contacts, body, batches, world.bodies, std::span(impulses), moving);
}

rigid::World<float> load_rigid(const std::string& scene) {
  return rigid::load_scene("scenes/rigid/" + scene + ".toml").world;
}

// Two batches are run as one, so each particle is in two constraints.
void batches_sharing_particles(Cloth<float>& cloth) {
  const cloth::Constraints<float>& list = cloth.batched;
#pragma omp parallel for schedule(static)
  for (int k = cloth.batch_begin[0]; k < cloth.batch_begin[2]; ++k)
    enforce(cloth, list.a[k], list.b[k], list.rest_2[k]);
}

template <class State>
struct Mistake {
  const char *name, *scene;
  void (*make)(State&);
};
constexpr Mistake<Fluid<float>> fluid_mistakes[] = {{"list_without_lock", "clump", list_without_lock},
                                                    {"list_under_wrong_lock", "clump", list_under_wrong_lock},
                                                    {"sort_without_barrier", "clump", sort_without_barrier},
                                                    {"pairs_without_lock", "dam_break_5k", pairs_without_lock},
                                                    {"buffer_shared", "dam_break_5k", buffer_shared},
                                                    {"loops_without_barrier", "dam_break_5k", loops_without_barrier}};
constexpr Mistake<Cloth<float>> cloth_mistakes[] = {
    {"seams_without_barrier", "flag_128", seams_without_barrier},
    {"stages_without_barrier", "flag_128", stages_without_barrier},
    {"batches_sharing_particles", "flag_128", batches_sharing_particles}};
constexpr Mistake<rigid::World<float>> rigid_mistakes[] = {
    {"batch_sharing_bodies", "pyramid_15", batch_sharing_bodies}};

Fluid<float> load_fluid(const std::string& name) {
  Scene scene = load_scene("scenes/fluid/" + name + ".toml");
  return make_fluid(fluid::convert<float>(scene.model), std::move(scene.particles));
}

Cloth<float> load_cloth(const std::string& name) {
  return cloth::convert<float>(cloth::load_scene("scenes/cloth/" + name + ".toml").cloth);
}

// Runs the mistake of this name, or lists all mistakes if the name is empty. Returns whether the mistake exists.
template <class Mistakes, class Load>
bool make_or_list(const Mistakes& mistakes, const char* name, Load load) {
  for (const auto& mistake : mistakes) {
    if (!name) std::printf("%s %s\n", mistake.name, mistake.scene);
    if (!name || std::strcmp(name, mistake.name) != 0) continue;
    auto state = load(mistake.scene);
    mistake.make(state);
    return true;
  }
  return false;
}

}  // namespace

int main(int argc, char** argv) {
  const char* const name = argc < 2 ? nullptr : argv[1];
  const bool made = make_or_list(fluid_mistakes, name, load_fluid) || make_or_list(cloth_mistakes, name, load_cloth) ||
                    make_or_list(rigid_mistakes, name, load_rigid);
  return made || !name ? 0 : 2;
}
