// With how many substeps do piles of rigid bodies come to rest? Runs scenes with the numbers of substeps given, and
// prints the table of notes/contact_solver.md: the kinetic energy a body after a third, two thirds and all of the
// steps, the deepest contact of two bodies and of one with what is fixed, how far bodies are from where they began, and
// in how many batches the last step's contacts are (0 in blocks).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "common/rigid/scene.h"
#include "common/rigid/step.h"
#include "verify/rigid/run.h"

using namespace lockstep;
using namespace lockstep::rigid;

namespace {

struct Run {
  const char* scene;
  int steps;
  int falls;  // bodies at the end of the scene that are left out of the drift: they must fall
};
constexpr Run runs[] = {{"stack_10", 1800, 0},      {"pyramid_24", 600, 0},    {"wall", 900, 1},
                        {"castle", 300, 0},         {"dominoes_1000", 240, 0}, {"slope", 120, 0},
                        {"box_pit_4000", 480, 0},   {"hull_pit_2000", 480, 0}};

double energy_a_body(const World<float>& world) {
  return verify::energy(world.bodies, {0, 0, 0}) / world.bodies.count;
}

void measure(const Run& run, Step<float>* step, int substeps) {
  const Scene scene = load_scene(std::string("scenes/rigid/") + run.scene + ".toml");
  StepSettings settings = verify::settings_of(scene);
  settings.solver.substeps = substeps;
  World<float> world = scene.world;
  StepMemory<float> memory;
  double energy[3];
  for (int part = 0; part < 3; ++part) {
    for (int k = 0; k < run.steps / 3; ++k) step(settings, world, memory);
    energy[part] = energy_a_body(world);
  }
  double between = 0, fixed = 0, mean = 0, most = 0;  // m
  for (const Manifold<float>& m : memory.manifolds)
    for (int k = 0; k < m.count; ++k) {
      double& deepest = world.colliders.group[m.a] < 0 || world.colliders.group[m.b] < 0 ? fixed : between;
      deepest = std::max(deepest, -double(m.point[k].separation));
    }
  int bodies = 0;
  for (int i = 0; i < world.bodies.count - run.falls; ++i) {
    if (!(world.bodies.inverse_mass[i].w > 0)) continue;
    const Vector3<float> off = world.bodies.pose[i].position - scene.world.bodies.pose[i].position;
    const double gone = std::sqrt(dot(off, off));
    mean += gone, most = std::max(most, gone), ++bodies;
  }
  std::printf("| %s | %d | %d | %.1e, %.1e, %.1e | %.2f / %.2f | %.1f, %.1f | %d |\n", run.scene, run.steps, substeps,
              energy[0], energy[1], energy[2], 1e3 * between, 1e3 * fixed, 1e3 * mean / bodies, 1e3 * most,
              std::max(memory.batches.count(), 0));
  std::fflush(stdout);
}

}  // namespace

// Arguments: the form of the step, `batches` or `blocks`; numbers of substeps.
int main(int argc, char** argv) {
  std::printf("| scene | steps | substeps | J a body after a third, two thirds, all steps | deepest, bodies / fixed, "
              "mm | moved, mean and most, mm | batches |\n|---|---|---|---|---|---|---|\n");
  for (const Run& run : runs)
    for (int k = 2; k < argc; ++k)
      measure(run, argv[1] == std::string("blocks") ? openmp::step_blocks : openmp::step_batches, std::atoi(argv[k]));
}
