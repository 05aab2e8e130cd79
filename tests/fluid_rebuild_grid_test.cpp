// The game fluid's sort into cells against a stable sort.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "tests/fluid_states.h"

namespace lockstep::fluid {
namespace {

std::vector<std::int32_t> stable_order(const Grid<float>& grid, const Particles<float>& p, std::vector<int>& cells) {
  cells.clear();
  for (int i = 0; i < p.count; ++i)
    cells.push_back(grid.cell(cell_coordinate(grid.x, p.position.x[i]), cell_coordinate(grid.y, p.position.y[i]),
                              cell_coordinate(grid.z, p.position.z[i])));
  std::vector<std::int32_t> order(p.count);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return cells[a] < cells[b]; });
  return order;
}

// The cell of a point by the definition in double; none where rounding may decide.
std::optional<int> cell_of(const Axis<float>& axis, double p) {
  const double x = (p - axis.min) / (double(axis.max) - axis.min) * axis.cells;
  if (std::abs(x - std::round(x)) < 1e-4) return std::nullopt;
  return static_cast<int>(std::clamp(std::floor(x), 0., axis.cells - 1.));
}

TEST(FluidRebuildGrid, IsAStableSortByCell) {
  struct Sort {
    const char* name;
    RebuildGrid<float>* rebuild_grid;
    bool threaded;
  };
  const Sort sorts[] = {{"serial", serial::rebuild_grid, false},
                        {"counting_sort", openmp::rebuild_grid_counting_sort, true},
                        {"linked_lists", openmp::rebuild_grid_linked_lists, true}};
  Random random(7);
  for (const double particles_per_metre : resolutions)
    for (const int count : {0, 1, 15, 16, 17, 100, 3001})
      for (const Cloud cloud : {Cloud::clumped, Cloud::wild}) {
        SCOPED_TRACE(std::to_string(count) + " particles, " + std::to_string(particles_per_metre) + " a metre");
        Fluid<float> start =
            fluid_of(particles_per_metre, random_cloud(random, model_at(particles_per_metre), count, cloud, 1));
        Particles<float>& p = start.particles;
        std::shuffle(p.id.begin(), p.id.begin() + count, random.engine);
        if (count > 20) p.position.y[20] = std::numeric_limits<float>::quiet_NaN();

        std::vector<int> cells;
        const std::vector<std::int32_t> order = stable_order(start.grid, p, cells);
        Particles<float> expected = p;
        for (int k = 0; k < count; ++k) {
          expected.id[k] = p.id[order[k]];
          for (const auto vectors :
               {&Particles<float>::position, &Particles<float>::half_velocity, &Particles<float>::velocity})
            for (const auto component : {&Vectors<float>::x, &Vectors<float>::y, &Vectors<float>::z})
              (expected.*vectors.*component)[k] = (p.*vectors.*component)[order[k]];
        }
        std::sort(cells.begin(), cells.end());

        for (const Sort& sort : sorts) {
          SCOPED_TRACE(sort.name);
          at_thread_counts(sort.threaded ? thread_counts : std::vector{1}, [&](int) {
            Fluid<float> f = start;
            sort.rebuild_grid(f.grid, f.particles, f.sorted);
            expect_same_bits(f.particles, expected);
            for (int c = 0; c <= f.grid.cells(); ++c)
              ASSERT_EQ(f.grid.cell_begin[c], std::lower_bound(cells.begin(), cells.end(), c) - cells.begin())
                  << "cell " << c;
          });
        }
      }
}

TEST(FluidRebuildGrid, CellsAreWhereTheyAreSaidToBe) {
  Random random(11);
  for (const double particles_per_metre : resolutions) {
    const Grid<float> grid = make_grid(model_at(particles_per_metre));
    for (const Axis<float>& axis : {grid.x, grid.y, grid.z}) {
      for (int trial = 0; trial < 2000; ++trial) {
        const auto p = static_cast<float>(random.in(axis.min - .1, axis.max + .1));
        if (const auto expected = cell_of(axis, p)) {
          ASSERT_EQ(cell_coordinate(axis, p), *expected) << p;
        }
      }
      EXPECT_EQ(cell_coordinate(axis, -1e30f), 0);
      EXPECT_EQ(cell_coordinate(axis, 1e30f), axis.cells - 1);
      EXPECT_EQ(cell_coordinate(axis, std::numeric_limits<float>::max()), axis.cells - 1);
    }
  }
}

}  // namespace
}  // namespace lockstep::fluid
