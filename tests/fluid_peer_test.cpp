// The game fluid against a peer: the frames of PARSEC's fluidanimate.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "common/fluid/convert.h"
#include "common/fluid/file.h"
#include "tests/fluid_states.h"

namespace lockstep::fluid {
namespace {

// Finds the nearest of a set of points.
class Nearest {
 public:
  Nearest(const Vectors<float>& points, int count) : points_(points) {
    for (int i = 0; i < count; ++i) cells_[key(cell(vec_at(points, i)))].push_back(i);
  }

  // -1 if none is within a cell's width, which is less than the distance of particles at rest.
  int find(const Vec& p) const {
    const std::array<long, 3> c = cell(p);
    int nearest = -1;
    double least = width;
    for (long z = c[2] - 1; z <= c[2] + 1; ++z)
      for (long y = c[1] - 1; y <= c[1] + 1; ++y)
        for (long x = c[0] - 1; x <= c[0] + 1; ++x)
          if (const auto found = cells_.find(key({x, y, z})); found != cells_.end())
            for (int i : found->second) {
              const Vec q = vec_at(points_, i);
              const double distance = std::max({std::abs(p[0] - q[0]), std::abs(p[1] - q[1]), std::abs(p[2] - q[2])});
              if (distance < least) least = distance, nearest = i;
            }
    return nearest;
  }

 private:
  static constexpr double width = .001;
  static std::array<long, 3> cell(const Vec& p) {
    return {std::lround(p[0] / width), std::lround(p[1] / width), std::lround(p[2] / width)};
  }
  static long key(const std::array<long, 3>& c) { return ((c[2] + 1024) * 2048 + c[1] + 1024) * 2048 + c[0] + 1024; }
  const Vectors<float>& points_;
  std::unordered_map<long, std::vector<int>> cells_;
};

// The largest component by which any particle is away from the peer's nearest, each of which is taken once.
template <class Real>
void expect_agrees(const Particles<Real>& ours, const Particles<float>& peer, const Nearest& nearest, double positions,
                   double velocities, const std::string& name) {
  std::vector<char> taken(peer.count, 0);
  double position = 0, velocity = 0;
  ASSERT_EQ(ours.count, peer.count);
  for (int i = 0; i < ours.count; ++i) {
    const int j = nearest.find(vec_at(ours.position, i));
    ASSERT_GE(j, 0) << "none near particle " << ours.id[i];
    ASSERT_FALSE(std::exchange(taken[j], 1)) << "two particles near the peer's " << j;
    for (int k = 0; k < 3; ++k) {
      position = std::max(position, std::abs(vec_at(ours.position, i)[k] - vec_at(peer.position, j)[k]));
      velocity = std::max(velocity, std::abs(vec_at(ours.velocity, i)[k] - vec_at(peer.velocity, j)[k]));
    }
  }
  EXPECT_LE(position, positions);
  EXPECT_LE(velocity, velocities);
  std::printf("  %-32s farthest from the peer: position %.2e m, velocity %.2e m/s\n", name.c_str(), position, velocity);
}

TEST(FluidPeer, FiveFramesAgree) {
  const std::string folder = "../shared/data/fluidanimate/", start_path = folder + "in_100K.fluid",
                    after_path = folder + "in_100K.after5.fluid";
  if (!std::filesystem::exists(start_path) || !std::filesystem::exists(after_path))
    GTEST_SKIP() << "the peer's frames are not there: " << start_path << " and in_100K.after5.fluid";
  constexpr int frames = 5;
  const FluidFile start = read_fluid(start_path);
  const Particles<float> peer = read_fluid(after_path).particles;
  const Nearest nearest(peer.position, peer.count);
  const Model<double> model = make_model(start.particles_per_metre);

  for (const Form& form : forms)
    at_thread_counts(form.threaded ? std::vector{1, 2, 3} : std::vector{1}, [&](int threads) {
      SCOPED_TRACE(form.name);
      Fluid<float> f = make_fluid(convert<float>(model), start.particles);
      for (int frame = 0; frame < frames; ++frame) form.step(f);
      expect_agrees(f.particles, peer, nearest, 5e-8, 2e-5,
                    std::string(form.name) + ", " + std::to_string(threads) + " threads");
    });

  // The model in double from the start, as the figures it is held to were found.
  Fluid<double> truth = make_fluid(model, convert<double>(start.particles));
  for (int frame = 0; frame < frames; ++frame) serial::step_symmetric(truth);
  expect_agrees(truth.particles, peer, nearest, 1.7e-8, 4.7e-6, "serial symmetric, double");
}

}  // namespace
}  // namespace lockstep::fluid
