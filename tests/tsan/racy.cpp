// The racy twin of openmp/fluid/: its kernels' loops over the same building blocks, each with one mistake planted, which
// thread sanitizer must flag. `make tsan` runs it; a sanitizer that misses these proves nothing by its silence on the others.
//
// usage: racy MISTAKE, from the top of the repository; it ends with exit code 0 where nothing flags it. Without an argument it
// lists the mistakes and their scenes: the clump, where every particle is in one cell and any two threads meet in it, and the
// dam break, where threads meet at the borders of their shares alone.
#include <algorithm>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "common/fluid/convert.h"
#include "common/fluid/fluid.h"
#include "common/fluid/rebuild_grid.h"
#include "common/fluid/scene.h"
#include "common/simd.h"
#include "openmp/fluid/sub_grids.h"

namespace {

using namespace lockstep;
using namespace lockstep::fluid;
using namespace lockstep::openmp;
using namespace lockstep::fluid::openmp;

int cell_of(const Grid<float>& grid, const Vectors<float>& p, int i) {
  return grid.cell(cell_coordinate(grid.x, p.x[i]), cell_coordinate(grid.y, p.y[i]), cell_coordinate(grid.z, p.z[i]));
}

// Particles pushed on per-cell lists: no lock.
void list_without_lock(Fluid<float>& fluid) {
  std::vector<int> head(fluid.grid.cells(), -1), next(fluid.particles.count);
#pragma omp parallel for schedule(static)
  for (int i = 0; i < fluid.particles.count; ++i) {
    const int cell = cell_of(fluid.grid, fluid.particles.position, i);
    next[i] = head[cell];
    head[cell] = i;
  }
}

// The same under the wrong lock: the particle's, not its cell's.
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

// Each thread's counts, then their sums over threads: no barrier in between.
void sort_without_barrier(Fluid<float>& fluid) {
  std::vector<std::vector<int>> counts(omp_get_max_threads(), std::vector<int>(fluid.grid.cells()));
#pragma omp parallel
  {
    const Share mine = my_share(fluid.particles.count), cells = my_share(fluid.grid.cells());
    for (int i = mine.begin; i < mine.end; ++i) ++counts[omp_get_thread_num()][cell_of(fluid.grid, fluid.particles.position, i)];
    for (int cell = cells.begin; cell < cells.end; ++cell) {
      int sum = 0;
      for (int thread = 0; thread < omp_get_num_threads(); ++thread) sum += counts[thread][cell];
      fluid.grid.cell_begin[cell] = sum;
    }
  }
}

// Pairs counted at both of their particles, in sub-grids: the cells at their borders without locks.
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

// What lies in each cell, copied to one side: one buffer for all threads.
void buffer_shared(Fluid<float>& fluid) {
  serial::rebuild_grid(fluid.grid, fluid.particles, fluid.sorted);
  Array<float> buffer(padded(fluid.particles.count));
  // Not dynamic: one thread might take every cell before the other wakes up, and then there is no race to see.
#pragma omp parallel for schedule(static)
  for (int cell = 0; cell < fluid.grid.cells(); ++cell)
    for (int i = fluid.grid.cell_begin[cell]; i < fluid.grid.cell_begin[cell + 1]; ++i)
      buffer[i - fluid.grid.cell_begin[cell]] = fluid.particles.position.x[i];
}

// Numbers set by one loop and scaled by the next, in other shares: `nowait` between them.
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

struct Mistake {
  const char *name, *scene;
  void (*make)(Fluid<float>&);
};
constexpr Mistake mistakes[] = {
    {"list_without_lock", "clump", list_without_lock},       {"list_under_wrong_lock", "clump", list_under_wrong_lock},
    {"sort_without_barrier", "clump", sort_without_barrier}, {"pairs_without_lock", "dam_break_5k", pairs_without_lock},
    {"buffer_shared", "dam_break_5k", buffer_shared},        {"loops_without_barrier", "dam_break_5k", loops_without_barrier}};

}  // namespace

int main(int argc, char** argv) {
  for (const Mistake& mistake : mistakes) {
    if (argc < 2) std::printf("%s %s\n", mistake.name, mistake.scene);
    if (argc < 2 || std::strcmp(argv[1], mistake.name) != 0) continue;
    Scene scene = load_scene(std::string("scenes/fluid/") + mistake.scene + ".toml");
    Fluid<float> fluid = make_fluid(fluid::convert<float>(scene.model), std::move(scene.particles));
    mistake.make(fluid);
    return 0;
  }
  return argc < 2 ? 0 : 2;
}
