// The game fluid where memory is short: what it needs was counted before it started, and what is not granted inside a
// parallel region ends as std::bad_alloc outside of it.
#include <gtest/gtest.h>
#include <omp.h>

#include <atomic>
#include <new>
#include <string>

#include "common/fluid/densities.h"
#include "common/fluid/fluid.h"
#include "common/fluid/forces.h"
#include "common/fluid/limits.h"
#include "common/fluid/rebuild_grid.h"
#include "tests/temporary_folder.h"

namespace lockstep::fluid {
namespace {

// Runs `work` on so many threads, which exist before the process's address space is limited to `bytes` more than it
// has.
template <class Work>
void with_memory(int threads, double bytes, const Work& work) {
  const int before = omp_get_max_threads();
  omp_set_num_threads(threads);
  std::atomic<int> started = 0;
#pragma omp parallel
  ++started;
  ASSERT_EQ(started, threads);
  {
    const Limit limit(RLIMIT_AS, address_space() + static_cast<rlim_t>(bytes));
    work();
  }
  omp_set_num_threads(before);
}

// `count` particles on the line between two corners of a cube of `size` metres in the middle of the domain.
Fluid<float> line(double particles_per_metre, int count, double size) {
  Particles<float> particles;
  particles.resize(count);
  for (int i = 0; i < count; ++i) {
    particles.id[i] = i;
    particles.position.x[i] = particles.position.y[i] = particles.position.z[i] =
        static_cast<float>(size * (i + .5) / count);
  }
  return make_fluid(convert<float>(make_model(particles_per_metre)), std::move(particles));
}

// A fine grid and few particles: on many threads, a histogram of all cells for each would be 2.5 GB.
TEST(FluidMemory, RebuildGridTakesWhatWasCountedOnAnyNumberOfThreads) {
  Fluid<float> fluid = line(2530, 1000, .01);
  ASSERT_GT(fluid.grid.cells(), 9'800'000);
  const double histograms = sizeof(std::int32_t) * histogram_entries(1000, fluid.grid.cells()), small = 1e6;
  for (const int threads : {1, 8, 64})
    with_memory(threads, histograms + small, [&] {
      EXPECT_NO_THROW(openmp::rebuild_grid_counting_sort(fluid.grid, fluid.particles, fluid.sorted));
    });
}

}  // namespace
}  // namespace lockstep::fluid
