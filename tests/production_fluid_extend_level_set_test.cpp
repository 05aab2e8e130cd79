// The level set in obstacles: what goes on into them and from where, by hand, and what holds of any obstacles.
#include "common/production_fluid/extend_level_set.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "common/production_fluid/scene.h"
#include "tests/production_fluids.h"

namespace lockstep::production_fluid {
namespace {

ExtendLevelSet<float>* const versions[] = {serial::extend_level_set, openmp::extend_level_set};

constexpr double u = 0x1p-24;
constexpr float lost = 1e6f;  // phi in obstacles before

// Cells of side 1 m. Both are functions of a cell.
template <class Solid, class Phi>
Fluid<float> fluid_of(int nx, int ny, int nz, const Solid& solid, const Phi& phi) {
  Fluid<float> fluid = make_fluid<float>(nx, ny, nz, 1, [](double, double, double) { return 0.; });
  for_each_place(fluid.phi, [&](int x, int y, int z) {
    fluid.solid(x, y, z) = static_cast<float>(solid(x, y, z));
    fluid.phi(x, y, z) = is_solid(fluid.solid(x, y, z)) ? lost : static_cast<float>(phi(x, y, z));
  });
  return fluid;
}

Field<float> extended(ExtendLevelSet<float>* extend, const Fluid<float>& fluid) {
  Field<float> phi = fluid.phi;
  extend(make_extension(fluid), phi);
  return phi;
}

// A line of cells along x.
Fluid<float> line_of(const std::vector<float>& solid, const std::vector<float>& phi) {
  return fluid_of(
      static_cast<int>(solid.size()), 1, 1, [&](int x, int, int) { return solid[x]; },
      [&](int x, int, int) { return phi[x]; });
}
std::vector<float> extended_line(ExtendLevelSet<float>* extend, const std::vector<float>& solid,
                                 const std::vector<float>& phi) {
  const Field<float> after = extended(extend, line_of(solid, phi));
  return {&after(0, 0, 0), &after(0, 0, 0) + solid.size()};
}

TEST(ProductionFluidExtendLevelSet, ReachesThreeCellsDeep) {
  const float below_three = std::nextafter(-3.f, -4.f);
  for (ExtendLevelSet<float>* extend : versions) {
    const auto line = [&](const std::vector<float>& solid, const std::vector<float>& phi) {
      return extended_line(extend, solid, phi);
    };
    EXPECT_EQ(line({1, 0, -1, -2, -3, -4}, {5, -7, 0, 0, 0, 0}), (std::vector<float>{5, -7, -7, -7, -7, lost}));
    EXPECT_EQ(line({-3, -2, -1, 1}, {0, 0, 0, 2}), (std::vector<float>{2, 2, 2, 2}));
    EXPECT_EQ(line({1, -1, below_three}, {2, 0, 0}), (std::vector<float>{2, 2, lost}));
    // The nearer side counts, if only by a little.
    EXPECT_EQ(line({1, -1, 1.25f}, {2, 0, 3}), (std::vector<float>{2, 3, 3}));
    EXPECT_EQ(line({1, -1, -2, -1.5f, 1}, {2, 0, 0, 0, 3}), (std::vector<float>{2, 2, 2, 3, 3}));
  }
}

TEST(ProductionFluidExtendLevelSet, CellsThatNoAxisLeadsOutOfKeepTheirValues) {
  for (ExtendLevelSet<float>* extend : versions) {
    const auto line = [&](const std::vector<float>& solid, const std::vector<float>& phi) {
      return extended_line(extend, solid, phi);
    };
    // As deep as one another; a hollow within the obstacle, and what is deeper beside it.
    EXPECT_EQ(line({1, -1, -1}, {2, 0, 0}), (std::vector<float>{2, 2, lost}));
    EXPECT_EQ(line({1, -4, -2, -1, -2, -4}, {2, 0, 0, 0, 0, 0}), (std::vector<float>{2, lost, lost, lost, lost, lost}));
    EXPECT_EQ(line({-1}, {0}), std::vector{lost});
    EXPECT_EQ(line({1}, {2}), std::vector{2.f});
  }
  const auto solid = [](int, int, int) { return -1; };
  for (ExtendLevelSet<float>* extend : versions)
    for (const int nx : {0, 1, 17}) {
      const Fluid<float> full = fluid_of(nx, 2, 3, solid, solid);
      EXPECT_EQ(extended(extend, full).value, full.phi.value);
    }
}

// One solid cell among six others: w = 3 along x, none along y, 1 along z.
TEST(ProductionFluidExtendLevelSet, AxesCountByHowMuchNearerTheyLead) {
  const auto at = [](int x, int y, int z) { return x + 3 * y + 9 * z; };
  const std::map<int, float> solids = {{at(1, 1, 1), -2}, {at(0, 1, 1), 1},  {at(2, 1, 1), .5f},  {at(1, 0, 1), -2},
                                       {at(1, 2, 1), -5}, {at(1, 1, 0), -1}, {at(1, 1, 2), -2.5f}};
  const auto solid = [&](int x, int y, int z) {
    const auto found = solids.find(at(x, y, z));
    return found != solids.end() ? found->second : -9;
  };
  Fluid<float> fluid = fluid_of(3, 3, 3, solid, [](int x, int, int) { return x == 0 ? 8 : 100; });
  fluid.solid(1, 0, 0) = 1, fluid.phi(1, 0, 0) = -4;  // the way out of the cell at z = 0
  for (ExtendLevelSet<float>* extend : versions) {
    const Field<float> after = extended(extend, fluid);
    EXPECT_EQ(after(1, 1, 0), -4);
    EXPECT_EQ(after(1, 1, 1), (3 * 8 + 1 * -4) / 4.f);
    EXPECT_EQ(after(0, 1, 1), 8);
    EXPECT_EQ(after(1, 1, 2), 5);  // from the one before
    EXPECT_EQ(after(1, 2, 1), lost);
  }
}

// Obstacles with plane sides, in all directions, and a phi that is linear and constant along their normals: it goes on
// as it was. Beside the box's sides, axes lack neighbours.
TEST(ProductionFluidExtendLevelSet, LinearFieldsGoOnAtARightAngle) {
  constexpr int n = 20, from_sides = 5;
  const auto inside = [](int x) { return from_sides <= x && x < n - from_sides; };
  for (int direction = 0; direction < 27; ++direction) {
    const Vector3<int> normal = {direction % 3 - 1, direction / 3 % 3 - 1, direction / 9 - 1};
    const auto along = [](const Vector3<int>& a, int x, int y, int z) { return a.x * x + a.y * y + a.z * z; };
    const int middle = along(normal, n / 2, n / 2, n / 2);
    for (const Vector3<int>& p : {Vector3<int>{1, 0, 0},
                                  {0, 1, 0},
                                  {0, 0, 1},
                                  {1, 1, 0},
                                  {1, -1, 0},
                                  {0, 1, -1},
                                  {0, 1, 1},
                                  {1, 0, 1},
                                  {1, 0, -1},
                                  {1, 1, -2},
                                  {2, -1, 1}}) {
      if (dot(p, normal) != 0) continue;
      const auto phi = [&](int x, int y, int z) { return along(p, x - n / 2, y - n / 2, z - n / 2); };
      const Fluid<float> fluid = fluid_of(
          n, n, n, [&](int x, int y, int z) { return along(normal, x, y, z) - middle + .5f; }, phi);
      for (ExtendLevelSet<float>* extend : versions) {
        const Field<float> after = extended(extend, fluid);
        int wrong = 0;
        for_each_place(after, [&](int x, int y, int z) {
          if (!inside(x) || !inside(y) || !inside(z) || fluid.solid(x, y, z) < -3) return;
          // Thirds round: twice a cell 3 u of at most 4, and u of at most 2 n. Three cells follow one another.
          const double rounding = dot(normal, normal) == 3 ? 3 * 2 * (3 * 4 + 2 * n) * u : 0;
          wrong += std::abs(after(x, y, z) - phi(x, y, z)) > rounding;
        });
        EXPECT_EQ(wrong, 0) << "direction " << direction << ", phi " << p.x << ' ' << p.y << ' ' << p.z;
      }
    }
  }
}

// Around a ball of radius 1, phi depends on the direction alone: the largest error, up to three cells deep.
double worst_in_ball(int per_metre) {
  const int n = 5 * per_metre / 2;
  const double h = 1. / per_metre, middle = n / 2. + .123;
  const auto radius = [&](int x, int y, int z) {
    return h * std::hypot(x + .5 - middle, y + .5 - middle, z + .5 - middle);
  };
  const auto exact = [&](int x, int y, int z) {
    return h * (2 * (x + .5 - middle) + (y + .5 - middle) - (z + .5 - middle)) / radius(x, y, z);
  };
  Fluid<double> fluid = make_fluid<double>(n, n, n, h, [](double, double, double) { return 1e6; });
  for_each_place(fluid.phi, [&](int x, int y, int z) {
    fluid.solid(x, y, z) = radius(x, y, z) - 1;
    if (fluid.solid(x, y, z) >= 0) fluid.phi(x, y, z) = exact(x, y, z);
  });
  serial::extend_level_set(make_extension(fluid), fluid.phi);
  double worst = 0;
  for_each_place(fluid.phi, [&](int x, int y, int z) {
    if (fluid.solid(x, y, z) < -3 * h) return;
    worst = std::max(worst, std::abs(fluid.phi(x, y, z) - exact(x, y, z)));
  });
  return worst;
}

// A mean is off by the square of a cell's side, and the depth stays three cells.
TEST(ProductionFluidExtendLevelSet, HasSecondOrderInTheDepthItReaches) {
  const double coarse = worst_in_ball(16), fine = worst_in_ball(32);
  EXPECT_GT(coarse, 3 * fine);
  EXPECT_LT(coarse, 5 * fine);
}

// --- Any obstacles

// Random depths, of which no two are equal, down to 4 cells.
struct Noise {
  std::mt19937 random{3};

  double number(double least, double most) { return least + (most - least) * 0x1p-32 * random(); }
  Fluid<float> fluid(int nx, int ny, int nz) {
    const auto solid = [&](int, int, int) { return number(-4, 2); };
    return fluid_of(nx, ny, nz, solid, [&](int, int, int) { return number(-1, 1); });
  }
};

constexpr Vector3<int> sizes[] = {{1, 1, 1}, {2, 1, 3}, {15, 2, 1}, {16, 3, 2}, {17, 5, 7}, {33, 9, 4}, {1, 40, 3}};

// Cell by cell as the contract says, in double, from the nearest to the open inwards. Returns those that got a value.
std::vector<bool> asked(const Fluid<float>& fluid, std::vector<double>& value) {
  const auto& [nx, ny, nz] = Vector3<int>{fluid.nx, fluid.ny, fluid.nz};
  const int step[] = {1, nx, nx * ny}, size[] = {nx, ny, nz};
  std::vector<double> solid;
  for_each_place(fluid.solid, [&](int x, int y, int z) { solid.push_back(fluid.solid(x, y, z)); });
  std::vector<int> order;
  std::vector<bool> has(solid.size()), made(solid.size());
  for (std::size_t c = 0; c < solid.size(); ++c)
    if (solid[c] >= 0)
      has[c] = true;
    else if (solid[c] >= -3)
      order.push_back(static_cast<int>(c));
  std::ranges::sort(order, std::greater{}, [&](int c) { return solid[c]; });
  for (const int c : order) {
    double sum = 0, weights = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const int at = c / step[axis] % size[axis];
      int best = c;
      if (at > 0 && has[c - step[axis]] && solid[c - step[axis]] > solid[best]) best = c - step[axis];
      if (at + 1 < size[axis] && has[c + step[axis]] && solid[c + step[axis]] > solid[best]) best = c + step[axis];
      sum += (solid[best] - solid[c]) * value[best], weights += solid[best] - solid[c];
    }
    if (weights > 0) value[c] = sum / weights, has[c] = made[c] = true;
  }
  return made;
}

TEST(ProductionFluidExtendLevelSet, IsAsAskedInAnyObstacle) {
  Noise noise;
  for (const auto& [nx, ny, nz] : sizes)
    for (int trial = 0; trial < 5; ++trial) {
      const Fluid<float> fluid = noise.fluid(nx, ny, nz);
      const Extension<float> extension = make_extension(fluid);
      std::vector<double> expected;
      for_each_place(fluid.phi, [&](int x, int y, int z) { expected.push_back(fluid.phi(x, y, z)); });
      const std::vector<bool> made = asked(fluid, expected);
      EXPECT_EQ(std::ranges::count(made, true), extension.first.back());
      // Values are up to 1, differences up to 2. A share has five roundings, so each of two means rounds by 10 u of the
      // share, 2 u each of the difference and the product, and u of the sum. Cells that follow one another add up.
      const double rounding = 2 * 15 * u * double(extension.first.size());
      for (ExtendLevelSet<float>* extend : versions) {
        const Field<float> after = extended(extend, fluid);
        int c = 0, wrong = 0;
        for_each_place(after, [&](int x, int y, int z) {
          wrong += std::abs(after(x, y, z) - expected[c]) > (made[c] ? rounding : 0);
          ++c;
        });
        EXPECT_EQ(wrong, 0) << nx << ' ' << ny << ' ' << nz;
      }
    }
}

// What stood in the obstacle does not matter where it is replaced, and equal values give that value to the bit.
TEST(ProductionFluidExtendLevelSet, OnlyTheOpenCounts) {
  Noise noise;
  Fluid<float> fluid = noise.fluid(17, 9, 5);
  const Extension<float> extension = make_extension(fluid);
  for (ExtendLevelSet<float>* extend : versions) {
    Field<float> one = fluid.phi, other = fluid.phi, equal = fluid.phi;
    for_each_place(fluid.solid, [&](int x, int y, int z) {
      if (is_solid(fluid.solid(x, y, z)))
        other(x, y, z) = -7;
      else
        equal(x, y, z) = .1f;
    });
    for (Field<float>* phi : {&one, &other, &equal}) extend(extension, *phi);
    for (int k = 0; k < extension.first.back(); ++k) {
      EXPECT_EQ(one.value[extension.cell[k]], other.value[extension.cell[k]]);
      EXPECT_EQ(equal.value[extension.cell[k]], .1f);
    }
  }
}

// Threads may share out the cells of a level: each cell is made once, of cells that are complete by then.
TEST(ProductionFluidExtendLevelSet, LevelsReadEarlierLevelsAlone) {
  Noise noise;
  for (const auto& [nx, ny, nz] : sizes) {
    const Fluid<float> fluid = noise.fluid(nx, ny, nz);
    const Extension<float> extension = make_extension(fluid);
    std::vector<bool> complete(fluid.phi.value.size(), false);
    for_each_place(fluid.solid, [&](int x, int y, int z) {
      complete[fluid.solid.index(x, y, z)] = !is_solid(fluid.solid(x, y, z));
    });
    for (std::size_t level = 0; level + 1 < extension.first.size(); ++level) {
      for (int k = extension.first[level]; k < extension.first[level + 1]; ++k) {
        const int cell = extension.cell[k];
        EXPECT_FALSE(bool(complete[cell]));
        for (int axis = 0; axis < 3; ++axis) {
          const int neighbour = extension.neighbour[axis][k];
          EXPECT_TRUE(neighbour == cell ? extension.share[axis][k] == 0 : bool(complete[neighbour]));
        }
      }
      for (int k = extension.first[level]; k < extension.first[level + 1]; ++k) {
        EXPECT_FALSE(bool(complete[extension.cell[k]])) << "a cell twice";
        complete[extension.cell[k]] = true;
      }
    }
  }
}

void expect_same_for_all_threads(const Fluid<float>& fluid, const std::string& what) {
  const int threads_before = omp_get_max_threads();
  const Field<float> one = extended(serial::extend_level_set, fluid);
  for (const int threads : {1, 2, 3, 8}) {
    omp_set_num_threads(threads);
    EXPECT_TRUE(same_bits(extended(openmp::extend_level_set, fluid).value, one.value))
        << what << ", " << threads << " threads";
  }
  omp_set_num_threads(threads_before);
}

TEST(ProductionFluidExtendLevelSet, TwinsAgreeAtAnyNumberOfThreads) {
  Noise noise;
  for (const auto& [nx, ny, nz] : sizes)
    for (int trial = 0; trial < 5; ++trial)
      expect_same_for_all_threads(noise.fluid(nx, ny, nz), "noise of " + std::to_string(nx));
  for (const char* scene : {"obstacle_48", "two_pockets", "open_top", "one_cell", "full_box"})
    expect_same_for_all_threads(load_scene(std::string("scenes/production_fluid/") + scene + ".toml").fluid, scene);
}

}  // namespace
}  // namespace lockstep::production_fluid
