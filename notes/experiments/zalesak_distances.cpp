// Where Zalesak's sphere loses its volume: prints it by part of the surface after a whole turn, with the distances that
// redistance makes and with those from the closest point of a cubic interpolation. notes/production_fluid.md has the
// table and the command. One argument: 0 for redistance's distances, else how far from the surface, in cells, others
// replace them.
//
// The closest point p to a cell's centre c by Newton's method (Chopp, SIAM J. Sci. Comput. 23, 2001), on polynomials of
// third degree through four values along each axis. Where it does not converge, or is half a cell from the distance
// that redistance found, that one stays.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
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

struct Weights {
  int first;
  std::array<double, 4> value, slope;
};

Weights weights_at(double x, int n) {
  const int cell = std::clamp(static_cast<int>(std::floor(x)), 1, n - 3);
  const double t = x - cell;
  return {
      cell - 1,
      {-t * (t - 1) * (t - 2) / 6, (t + 1) * (t - 1) * (t - 2) / 2, -(t + 1) * t * (t - 2) / 2,
       (t + 1) * t * (t - 1) / 6},
      {-(3 * t * t - 6 * t + 2) / 6, (3 * t * t - 4 * t - 1) / 2, -(3 * t * t - 2 * t - 2) / 2, (3 * t * t - 1) / 6}};
}

struct Cubic {
  double value;
  Vector3<double> slope;
};

// Positions are in cells from the first centre.
Cubic cubic_at(const Field<float>& phi, const Vector3<double>& p) {
  const Weights a = weights_at(p.x, phi.nx), b = weights_at(p.y, phi.ny), c = weights_at(p.z, phi.nz);
  Cubic sum = {0, {0, 0, 0}};
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i) {
        const double v = phi(a.first + i, b.first + j, c.first + k);
        sum.value += v * a.value[i] * b.value[j] * c.value[k];
        sum.slope =
            sum.slope + v * Vector3<double>{a.slope[i] * b.value[j] * c.value[k], a.value[i] * b.slope[j] * c.value[k],
                                            a.value[i] * b.value[j] * c.slope[k]};
      }
  return sum;
}

// In cells; negative where the closest point is not found.
double closest(const Field<float>& phi, const Vector3<double>& centre) {
  Vector3<double> p = centre;
  for (int k = 0; k < 12; ++k) {
    const Cubic at = cubic_at(phi, p);
    const double square = dot(at.slope, at.slope);
    if (!(square > 1e-12 * phi.spacing * phi.spacing)) return -1;
    const Vector3<double> to_surface = (-at.value / square) * at.slope, back = centre - p,
                          across = back - (dot(back, at.slope) / square) * at.slope, move = to_surface + across;
    p = p + move;
    if (dot(move, move) < 1e-6) return std::sqrt(dot(p - centre, p - centre));
    if (dot(p - centre, p - centre) > 36) return -1;
  }
  return -1;
}

void redistance(double within, Field<float>& phi, Distances<float>& distances) {
  const Field<float> before = phi;
  const double h = phi.spacing;
  openmp::redistance_sweeping(phi, band_of_level_set * phi.spacing, distances);
  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y)
      for (int x = 0; x < phi.nx; ++x) {
        const double swept = std::abs(phi(x, y, z)) / h;
        if (swept >= within) continue;
        const double d = closest(before, {double(x), double(y), double(z)});
        if (d >= 0 && std::abs(d - swept) < .5) phi(x, y, z) = static_cast<float>(before(x, y, z) < 0 ? -d * h : d * h);
      }
}

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

int main(int, char** arguments) {
  const double within = std::atof(arguments[1]);
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
      redistance(within, phi, memory.distances);
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
  const auto share = [h](float d) { return std::clamp(.5 - d / h, 0., 1.); };
  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y)
      for (int x = 0; x < phi.nx; ++x) {
        const double before = share(start(x, y, z)), change = share(phi(x, y, z)) - before;
        const int part = part_of({(x + .5) * h, (y + .5) * h, (z + .5) * h}, h);
        all += before, lost[part] -= change, misplaced[part] += std::abs(change);
      }
  constexpr const char* names[] = {"sphere", "slot", "edges of the slot's mouth", "edges of its bottom"};
  for (int part = 0; part < 4; ++part)
    std::printf("%s: lost %.2f %%, misplaced %.2f %%\n", names[part], 100 * lost[part] / all,
                100 * misplaced[part] / all);
}
