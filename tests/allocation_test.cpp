// Kernels of the games where memory runs out (failing_allocation.h). To that end this file replaces the program's
// operator new, which then fails when it is told to.
#include <gtest/gtest.h>

#include <cstdlib>

#include "common/cloth/make.h"
#include "common/cloth/relax.h"
#include "common/fluid/densities.h"
#include "common/fluid/fluid.h"
#include "common/fluid/forces.h"
#include "common/fluid/rebuild_grid.h"
#include "common/levelset/fast_marching.h"
#include "common/levelset/fast_sweeping.h"
#include "common/levelset/initialize.h"
#include "common/rigid/broad_phase.h"
#include "common/rigid/narrow_phase.h"
#include "tests/failing_allocation.h"
#include "tests/rigid_shapes.h"

std::atomic<long> lockstep::succeed = -1;

namespace {

using lockstep::succeed;

void* aligned(std::size_t size, std::size_t alignment) {
  return std::aligned_alloc(alignment, (size + alignment) / alignment * alignment);
}
void* allocate(std::size_t size, std::size_t alignment) {
  if (succeed.load() >= 0 && succeed.fetch_sub(1) == 0) throw std::bad_alloc();
  void* const memory = aligned(size, alignment);
  if (!memory) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t size) { return allocate(size, __STDCPP_DEFAULT_NEW_ALIGNMENT__); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
// Does not fail: who asks so, such as std::stable_sort, does without. Replaced because a sanitizer's own takes memory
// that free() may not give back.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return aligned(size, __STDCPP_DEFAULT_NEW_ALIGNMENT__);
}
// Not inlined: gcc warns where it sees free() of what operator new gave.
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace lockstep {
namespace {

namespace fluid_kernels {

using namespace fluid;

// Particles on a line, nearly all of them neighbours: their lists grow many times.
Fluid<float> crowd() {
  Particles<float> particles;
  particles.resize(300);
  for (int i = 0; i < particles.count; ++i) {
    particles.id[i] = i;
    particles.position.x[i] = particles.position.y[i] = particles.position.z[i] = 1e-5f * static_cast<float>(i);
  }
  Fluid<float> fluid = make_fluid(convert<float>(make_model(100)), std::move(particles));
  openmp::rebuild_grid_counting_sort(fluid.grid, fluid.particles, fluid.sorted);
  return fluid;
}

TEST(Allocation, FailsOutsideOfTheFluidsDensitiesAndForces) {
  for (Densities<float>* densities : {openmp::densities_owner_gather, openmp::densities_pair_lists})
    every_allocation_may_fail<Fluid<float>>(
        crowd(), [&](Fluid<float>& f) { densities(f.model, f.grid, f.particles, f.neighbours, f.density); });
  Fluid<float> start = crowd();
  openmp::densities_pair_lists(start.model, start.grid, start.particles, start.neighbours, start.density);
  every_allocation_may_fail<Fluid<float>>(start, [](Fluid<float>& f) {
    openmp::forces_pair_lists(f.model, f.grid, f.particles, f.neighbours, f.density, f.acceleration);
  });
}

}  // namespace fluid_kernels

namespace levelset_kernels {

using namespace levelset;

Field<float> checkers_and_a_slope() {  // interface points in every plane, and a wide region without
  Field<float> phi = make_field<float>(40, 21, 19, 1.f, 1.f);
  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y)
      for (int x = 0; x < phi.nx; ++x) phi(x, y, z) = x < 6 && (x + y + z) % 2 ? -1.f : x - 5.5f;
  return phi;
}

Distances<float> started() {
  Distances<float> distances;
  serial::initialize(checkers_and_a_slope(), distances);
  return distances;
}

TEST(Allocation, FailsOutsideOfInitialize) {
  const Field<float> phi = checkers_and_a_slope();
  every_allocation_may_fail<Distances<float>>({}, [&](Distances<float>& d) { openmp::initialize(phi, d); });
}

TEST(Allocation, FailsOutsideOfMarchingInBlocks) {
  every_allocation_may_fail<Distances<float>>(started(),
                                              [](Distances<float>& d) { openmp::fast_marching_blocks(d, 3.f, 16); });
}

TEST(Allocation, FailsOutsideOfSweeping) {
  every_allocation_may_fail<Distances<float>>(started(),
                                              [](Distances<float>& d) { openmp::fast_sweeping_sweeps(d, 3.f, 1); });
}

TEST(Allocation, FailsOutsideOfSweepingInBlocks) {
  every_allocation_may_fail<Distances<float>>(started(),
                                              [](Distances<float>& d) { openmp::fast_sweeping_blocks(d, 3.f, 1, 16); });
}

}  // namespace levelset_kernels

namespace cloth_kernels {

using namespace cloth;

TEST(Allocation, FailsOutsideOfRelaxation) {
  const Model<double> model = {.time_step = .01,
                               .substeps = 1,
                               .iterations = 1,
                               .gravity = {0, -9.81, 0},
                               .wind = {0, 0, 0},
                               .drag = 0,
                               .velocity_factor = 1};
  const SheetPlan plan = {.rows = 60,
                          .columns = 20,
                          .origin = {0, 0, 0},
                          .across = {.1, 0, 0},
                          .down = {0, -.1, 0},
                          .mass = 1,
                          .bending = true,
                          .pinned = {0}};
  const Cloth<float> sheet = convert<float>(make_sheet(model, {}, plan));
  for (Relax<float>* const relax : {openmp::relax_chains, openmp::relax_colours, openmp::relax_batches})
    every_allocation_may_fail<Cloth<float>>(sheet, [relax](Cloth<float>& c) { relax(c, 2); });
}

}  // namespace cloth_kernels

namespace rigid_kernels {

using namespace rigid;

TEST(Allocation, FailsOutsideOfPlanePairs) {
  constexpr int count = 3000;  // so many that several strips have pairs
  Colliders<float> colliders;
  colliders.count = count;
  Array<Pose<float>> placed;
  Bounds<float> bounds;
  bounds.resize(count);
  for (int k = 0; k < count; ++k) {
    colliders.kind.push_back(static_cast<std::int32_t>(k == 0 ? Kind::plane : Kind::sphere));
    colliders.group.push_back(k - 1);
    placed.push_back({{0, 0, 0}, {0, 0, 0, 1}, 0});
    bounds.set(k, k == 0 ? whole_space<float> : Box<float>{{-1, -1, -1}, {1, 1, 1}});
  }
  colliders.group.resize(padded(count));
  every_allocation_may_fail<Pairs>({}, [&](Pairs& pairs) { openmp::plane_pairs(colliders, placed, bounds, pairs); });
}

TEST(Allocation, FailsOutsideOfTheNarrowPhase) {
  Shapes shapes;
  std::vector<Vector3<double>> corners;
  for (int k = 0; k < 8; ++k) corners.push_back({k & 1 ? .5 : -.5, k & 2 ? .5 : -.5, k & 4 ? .5 : -.5});
  const int hull = make_hull(shapes.hulls, corners);
  for (int k = 0; k < 20; ++k) {
    shapes.box({.5, .5, .5}, at({0, .9 * k, 0}));
    shapes.hull(hull, at({.2, .9 * k + .3, 0}));
  }
  Pairs pairs;
  for (int a = 0; a < 40; ++a)
    for (int b = a + 1; b < 40 && b < a + 4; ++b) pairs.push_back({a, b});
  const Rounded<float> rounded(shapes);
  struct State {
    NarrowPhaseState state;
    KeptContacts<float> kept;
    Array<Manifold<float>> manifolds;
  };
  every_allocation_may_fail<State>(
      {}, [&](State& s) { openmp::narrow_phase(rounded.placed(), pairs, .01f, s.state, s.manifolds); });
  every_allocation_may_fail<State>(
      {}, [&](State& s) { openmp::narrow_phase_kept(rounded.placed(), pairs, .01f, s.state, s.kept, s.manifolds); });
}

}  // namespace rigid_kernels

}  // namespace
}  // namespace lockstep
