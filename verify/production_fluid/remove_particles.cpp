// Particles that are removed, as the verifier and the benchmark see it: bitwise with the serial twin.
#include "common/production_fluid/remove_particles.h"

#include <cmath>
#include <cstdint>

#include "verify/production_fluid/inputs.h"
#include "verify/production_fluid/particles.h"
#include "verify/production_fluid/spray.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_remove_particles {

// What the kernel changes.
struct RemovedParticles {
  production_fluid::Particles<float> kept;
  production_fluid::Spray<float> spray;
};
template <Same<RemovedParticles> R, class F>
void for_each_array(R& removed, const F& f) {
  for_each_array(removed.kept, f);
  for_each_array(removed.spray, f);
}

namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

// The fluid of a scene in which every rule has something to remove. The particles have been placed up to three cells
// from the surface, outside obstacles, and one in sixteen on the wrong side. Now phi is half as large again, obstacles
// reach half a cell further, and one in eight of the cells beside the surface is air: a bubble if none beside it is
// higher.
Fluid<float> made_rough(Fluid<float> fluid) {
  const float h = fluid.spacing;
  std::uint64_t cell = 0;
  for (int z = 0; z < fluid.nz; ++z)
    for (int y = 0; y < fluid.ny; ++y)
      for (int x = 0; x < fluid.nx; ++x, ++cell) {
        float& phi = fluid.phi(x, y, z);
        phi *= 1.5f;
        if (random_of(cell) < 1. / 8 && std::abs(phi) < h) phi = std::abs(phi);
        fluid.solid(x, y, z) -= .5f * h;
      }
  return fluid;
}

Case make(const std::string& path) {
  const auto in = inputs(path);
  const auto before = particles(path);
  const auto fluid = std::make_shared<const Fluid<float>>(made_rough(in->scene.fluid));
  RemovedParticles start{*before, {}};
  poison(start);
  start.spray = spray(*fluid, 100);
  const auto with = [before, fluid](RemoveParticles<float>* remove_particles) {
    return [before, fluid, remove_particles](RemovedParticles& removed) {
      remove_particles(*fluid, *before, removed.kept, removed.spray);
    };
  };
  const double count = before->count, cells = cells_of(*in);
  return make_case<RemovedParticles>({
      .start = std::make_shared<const RemovedParticles>(std::move(start)),
      .serial = with(serial::remove_particles),
      .best_serial = nullptr,
      .openmp = with(openmp::remove_particles),
      .compare = nullptr,
      // Five numbers of a particle read and written; where blocks begin, likewise; phi and solid of a block. Where it
      // is: 3, and six fractions; two values of seven interpolations of 3; the distance of its cell's centre, 3 of 2
      // and 5.
      .work = {count, "particles", 40 * count + 8 * cells + 8 * count / 16, (3 + 6 + 2 * 21 + 11) * count},
  });
}

const Register remove_particles{
    {.name = "production_fluid/remove_particles", .place = 14, .forms = {{.make = make, .scenes = spray_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_remove_particles
