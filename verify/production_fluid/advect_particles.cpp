// Particles that move, as the verifier and the benchmark see it: bitwise with the serial twin.
#include "common/production_fluid/advect_particles.h"

#include "verify/production_fluid/advection.h"
#include "verify/production_fluid/inputs.h"
#include "verify/production_fluid/particles.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_advect_particles {
namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

Case make(const std::string& path) {
  const auto in = inputs(path);
  const auto motion = std::make_shared<const Motion>(motion_of(in->scene.fluid));
  const auto start = particles(path);
  const auto with = [in, motion](AdvectParticles<float>* advect_particles) {
    return [in, motion, advect_particles](Particles<float>& p) {
      advect_particles(in->scene.fluid, motion->velocity, motion->dt, p);
    };
  };
  const double n = start->count;
  return make_case<Particles<float>>({
      .start = start,
      .serial = with(serial::advect_particles),
      .best_serial = nullptr,
      .openmp = with(openmp::advect_particles),
      .compare = nullptr,
      // Positions read and written; twice where a particle is in six grids of cells, and 3 x 7 interpolations of 3;
      // the way.
      .work = {n, "particles", 24 * n, (2 * (6 + 3 * 21) + 6 + 9) * n},
      .restore = [](Particles<float>& now, const Particles<float>& start) { now.position = start.position; },
  });
}

const Register advect_particles{
    {.name = "production_fluid/advect_particles",
     .place = 10,
     .forms = {{.make = make, .scenes = advection_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_advect_particles
