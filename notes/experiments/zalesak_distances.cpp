// Where Zalesak's sphere loses its volume: prints it by part of the surface after a whole turn, with the distances that
// redistance makes. notes/production_fluid.md has the table and the command.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "common/production_fluid/adjust_radii.h"
#include "common/production_fluid/advect_level_set.h"
#include "common/production_fluid/advect_particles.h"
#include "common/production_fluid/correct_level_set.h"
#include "common/production_fluid/redistance.h"
#include "common/production_fluid/reseed.h"
#include "common/production_fluid/scene.h"
#include "common/production_fluid/sort_particles.h"
#include "common/production_fluid/step.h"
#include "common/production_fluid/time_step.h"

using namespace lockstep;
using namespace lockstep::production_fluid;

namespace {

// The part of the surface that a cell is nearest to: the sphere, the slot's walls and bottom, the edges that it has
// with the sphere, and those at its bottom.
int part_of(const Vector3<double>& p, double h) {
  const Vector3<double> away = p - Vector3<double>{.5, .75, .5};
  const bool sphere = std::abs(std::sqrt(dot(away, away)) - .15) < 3 * h;
  const bool wall = p.y < .85 + 2 * h && std::abs(std::abs(p.x - .5) - .025) < 3 * h;
  const bool bottom = std::abs(p.x - .5) < .025 + 2 * h && std::abs(p.y - .85) < 3 * h;
  if (wall && bottom) return 3;
  if (wall && sphere) return 2;
  return wall || bottom ? 1 : 0;
}

}  // namespace

int main() {
  Scene scene = load_scene("scenes/production_fluid/zalesak_100.toml");
  scene.model.frame = 2 * std::numbers::pi / scene.frames;  // the scene's own frames overshoot by a thousandth
  Liquid<float> liquid;
  StepMemory<float> memory;
  liquid.fluid = scene.fluid;
  serial::start(scene.model, liquid, memory);
  Field<float>& phi = liquid.fluid.phi;
  const Field<float> start = phi;
  for (int frame = 1; frame <= scene.frames; ++frame) {
    for (double left = scene.model.frame, dt; left > 0; left -= dt) {
      dt = next_substep(openmp::time_step(memory.given, 0, static_cast<float>(scene.model.cfl)), left);
      const float length = static_cast<float>(dt);
      openmp::advect_level_set_maccormack(phi, memory.given, length, memory.phi, memory.arrived);
      std::swap(phi, memory.phi);
      openmp::advect_particles(liquid.fluid, memory.given, length, liquid.particles);
      openmp::sort_particles(phi, liquid.particles, memory.particles);
      std::swap(liquid.particles, memory.particles);
      openmp::correct_level_set(liquid.particles, phi);
      openmp::redistance_sweeping(phi, band_of_level_set * phi.spacing, memory.distances);
      openmp::correct_level_set(liquid.particles, phi);
      openmp::adjust_radii(phi, liquid.particles);
    }
    if (frame % 20 != 0) continue;
    openmp::reseed(liquid.fluid, {.per_block = scene.model.per_block, .round = static_cast<std::uint32_t>(frame / 20)},
                   liquid.particles, memory.particles);
    std::swap(liquid.particles, memory.particles);
  }
  const double h = phi.spacing;
  double lost[4] = {}, misplaced[4] = {}, all = 0;
  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y)
      for (int x = 0; x < phi.nx; ++x) {
        const double before = liquid_share(start(x, y, z), h), change = liquid_share(phi(x, y, z), h) - before;
        const int part = part_of({(x + .5) * h, (y + .5) * h, (z + .5) * h}, h);
        all += before, lost[part] -= change, misplaced[part] += std::abs(change);
      }
  constexpr const char* names[] = {"sphere", "slot", "edges of the slot's mouth", "edges of its bottom"};
  for (int part = 0; part < 4; ++part)
    std::printf("%s: lost %.2f %%, misplaced %.2f %%\n", names[part], 100 * lost[part] / all,
                100 * misplaced[part] / all);
}
