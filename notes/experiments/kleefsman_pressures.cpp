// Pressures on the box of the dam break of Kleefsman et al. (2005; scene kleefsman_161): prints the greatest of each of
// the four gauges in the first .6 s, and when. notes/production_fluid.md has the table and the command.
//
// Frames have no pressure. What the last substep's solve leaves is p dt / (rho h), so frames are as short as a substep:
// .002 s. Of frames with more than one substep (three cells at the front are that fast) nothing is taken.
#include <cstdio>

#include "common/production_fluid/scene.h"
#include "common/production_fluid/step.h"

using namespace lockstep::production_fluid;

int main() {
  constexpr double heights[] = {.021, .061, .101, .141}, face = .8245, across = .471, density = 1000;
  Scene scene = load_scene("scenes/production_fluid/kleefsman_161.toml");
  scene.model.frame = .002;
  const double h = scene.fluid.spacing;
  Liquid<float> liquid;
  StepMemory<float> memory;
  liquid.fluid = scene.fluid;
  serial::start(scene.model, liquid, memory);
  double most[4] = {}, when[4] = {};
  int left_out = 0;
  for (int frame = 1; frame <= 300; ++frame) {
    openmp::step_mic(scene.model, liquid, memory);
    left_out += memory.substeps > 1;
    if (memory.substeps > 1) continue;
    // The first cells in front of the box, and of their centres the two around the gauge's height.
    const int x = static_cast<int>(face / h + .5), z = static_cast<int>(across / h);
    for (int gauge = 0; gauge < 4; ++gauge) {
      const double at = heights[gauge] / h - .5;
      const int y = static_cast<int>(at);
      const double* const q = &liquid.q[memory.system.cells.index(x, y, z)];
      const double above = liquid.q[memory.system.cells.index(x, y + 1, z)];
      const double p = (*q + (at - y) * (above - *q)) * density * h / scene.model.frame;
      if (p > most[gauge]) most[gauge] = p, when[gauge] = frame * scene.model.frame;
    }
  }
  for (int gauge = 0; gauge < 4; ++gauge)
    std::printf("P%d: %.2f kPa at %.3f s\n", gauge + 1, most[gauge] / 1000, when[gauge]);
  std::printf("%d of 300 frames left out\n", left_out);
}
