#include "common/fluid/scene.h"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <utility>
#include <vector>

#include "common/fluid/file.h"
#include "common/fluid/limits.h"
#include "common/scene_reader.h"

namespace lockstep::fluid {
namespace {

// --- Blocks of particles

struct Block {
  Vector3<double> min, velocity;
  double spacing, jitter;
  Vector3<double> points;  // along each axis: whole numbers, which need not fit an int before they are checked

  double count() const { return points.x * points.y * points.z; }
};

Block read_block(const toml::table& table, double particles_per_metre) {
  check_keys(table, {"min", "max"}, {"spacing", "jitter", "velocity"});
  const Vector3<double> min = *vector(table, "min", "m"), max = *vector(table, "max", "m");
  if (!(min.x < max.x && min.y < max.y && min.z < max.z))
    refuse_value(*table.get("max"), "max", "to be greater than min on every axis");
  const double spacing =
      number(table, "spacing", "a number > 0, in m", [](double x) { return x > 0; }).value_or(1 / particles_per_metre);
  const double jitter = number_between(table, "jitter", 0, 1, "").value_or(0);
  const Vector3<double> velocity = vector(table, "velocity", "m/s").value_or(Vector3<double>{0, 0, 0});
  // Lattice points min + (i + 1/2) spacing < max, i = 0, 1, ...
  const auto fit = [&](double from, double to) { return std::ceil((to - from) / spacing - .5); };
  const Vector3<double> points = {fit(min.x, max.x), fit(min.y, max.y), fit(min.z, max.z)};
  if (!(points.x >= 1 && points.y >= 1 && points.z >= 1))
    refuse(table.source(), "the block holds no particle, expected at least one");
  return {.min = min, .velocity = velocity, .spacing = spacing, .jitter = jitter, .points = points};
}

std::vector<Block> read_blocks(const toml::table& scene, const Model<double>& model) {
  std::vector<Block> blocks;
  double count = 0;
  for (const toml::table* table : subtables(scene, "block")) {
    const Block block = read_block(*table, model.particles_per_metre);
    count += block.count();
    require_size(model, count, position(table->source()));
    blocks.push_back(block);
  }
  return blocks;
}

// The k-th number of the splitmix64 sequence of `seed`, as a fraction 0 <= u < 1: the same on every platform, in any
// order.
double random_fraction(std::uint64_t seed, std::uint64_t k) {
  std::uint64_t x = seed + (k + 1) * 0x9e3779b97f4a7c15;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  x ^= x >> 31;
  return static_cast<double>(x >> 11) * 0x1p-53;
}

Particles<float> make_particles(const std::vector<Block>& blocks, std::uint64_t seed) {
  int count = 0;
  for (const Block& block : blocks) count += static_cast<int>(block.count());
  Particles<float> particles;
  particles.resize(count);
  auto& [_, id, p, hv, v] = particles;
  int i = 0;
  for (const auto& [min, velocity, spacing, jitter, points] : blocks)
    for (int z = 0; z < points.z; ++z)
      for (int y = 0; y < points.y; ++y)
        for (int x = 0; x < points.x; ++x, ++i) {
          const auto coordinate = [&, spacing = spacing, jitter = jitter](double min, int point, int axis) {
            const double shift = jitter * (random_fraction(seed, 3 * std::uint64_t(i) + axis) - .5);
            return static_cast<float>(min + (point + .5 + shift) * spacing);
          };
          id[i] = i;
          p.x[i] = coordinate(min.x, x, 0), p.y[i] = coordinate(min.y, y, 1), p.z[i] = coordinate(min.z, z, 2);
          v.x[i] = hv.x[i] = static_cast<float>(velocity.x);
          v.y[i] = hv.y[i] = static_cast<float>(velocity.y);
          v.z[i] = hv.z[i] = static_cast<float>(velocity.z);
        }
  return particles;
}

// --- Scenes

Holds read_holds(const toml::table& scene) {
  const toml::table* table = subtable(scene, "holds");
  if (!table) return {};
  check_keys(*table, {}, {"momentum_conserved", "inside_domain", "lattice_density", "energy_falls_after"});
  return {.momentum_conserved = truth(*table, "momentum_conserved").value_or(false),
          .inside_domain = truth(*table, "inside_domain").value_or(false),
          .lattice_density = truth(*table, "lattice_density").value_or(false),
          .energy_falls_after = whole_int(*table, "energy_falls_after", 0)};
}

// With the least and the most particles a metre, float holds 1 / h^9 times these densities, and its inverse.
Matter read_matter(const toml::table& scene) {
  const Matter otherwise;
  return {.stiffness = number_between(scene, "stiffness", 0, 1e6, "m^2/s^2").value_or(otherwise.stiffness),
          .viscosity = number_between(scene, "viscosity", 0, 1e6, "Pa s").value_or(otherwise.viscosity),
          .rest_density = number_between(scene, "rest_density", 1, 1e4, "kg/m^3").value_or(otherwise.rest_density),
          .time_step = number_between(scene, "time_step", 1e-6, 1, "s").value_or(otherwise.time_step),
          .cohesion = truth(scene, "cohesion").value_or(otherwise.cohesion)};
}

Scene load_toml(const std::string& path) {
  const toml::table scene = read_scene(path, "fluid", {"kind", "particles_per_metre", "block"},
                                       {"frames", "walls", "gravity", "stiffness", "viscosity", "rest_density",
                                        "time_step", "cohesion", "seed", "holds"});
  const double particles_per_metre =
      *number_between(scene, "particles_per_metre", min_particles_per_metre, max_particles_per_metre, "");
  Model<double> model = make_model(particles_per_metre, read_matter(scene));
  require_size(model, 0, position(scene.get("particles_per_metre")->source()));
  model.gravity = vector(scene, "gravity", "m/s^2").value_or(model.gravity);
  model.walls = truth(scene, "walls").value_or(model.walls);
  const int frames = whole_int(scene, "frames", 1).value_or(100);
  const std::uint64_t seed = whole(scene, "seed", 0, std::numeric_limits<std::int64_t>::max()).value_or(1);
  return {.name = scene_name(path),
          .path = path,
          .model = model,
          .particles = make_particles(read_blocks(scene, model), seed),
          .frames = frames,
          .holds = read_holds(scene)};
}

Scene load_fluid(const std::string& path) {
  FluidFile file = read_fluid(path);
  return {.name = scene_name(path),
          .path = path,
          .model = make_model(file.particles_per_metre),
          .particles = std::move(file.particles),
          .frames = 1,
          .holds = {}};
}

}  // namespace

Scene load_scene(const std::string& path) {
  return std::filesystem::path(path).extension() == ".fluid" ? load_fluid(path) : load_toml(path);
}

}  // namespace lockstep::fluid
