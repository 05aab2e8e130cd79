// The sort of particles, as the verifier and the benchmark see it: bitwise with the serial twin.
#include "common/production_fluid/sort_particles.h"

#include "common/production_fluid/advect_particles.h"
#include "verify/production_fluid/advection.h"
#include "verify/production_fluid/inputs.h"
#include "verify/production_fluid/particles.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_sort_particles {
namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

// Particles that were sorted before they moved by up to .9 of a cell, as in a step.
Case make(const std::string& path) {
  const auto in = inputs(path);
  const Motion motion = motion_of(in->scene.fluid);
  Particles<float> moved = *particles(path);
  serial::advect_particles(in->scene.fluid, motion.velocity, motion.dt, moved);
  Particles<float> start = moved;
  poison(start);
  const auto from = std::make_shared<const Particles<float>>(std::move(moved));
  const auto with = [in, from](SortParticles<float>* sort_particles) {
    return [in, from, sort_particles](Particles<float>& sorted) {
      sort_particles(in->scene.fluid.phi, *from, sorted);
    };
  };
  const double n = from->count;
  return make_case<Particles<float>>({
      .start = std::make_shared<const Particles<float>>(std::move(start)),
      .serial = with(serial::sort_particles),
      .best_serial = nullptr,
      .openmp = with(openmp::sort_particles),
      .compare = nullptr,
      // Five numbers read and written, and where the blocks begin.
      .work = {n, "particles", 40 * n + 4 * cells_of(*in), 0},
  });
}

const Register sort_particles{
    {.name = "production_fluid/sort_particles", .place = 11, .forms = {{.make = make, .scenes = advection_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_sort_particles
