// Reseeding, as the verifier and the benchmark see it: bitwise with the serial twin.
#include "common/production_fluid/reseed.h"

#include "verify/production_fluid/advection.h"
#include "verify/production_fluid/inputs.h"
#include "verify/production_fluid/particles.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_reseed {
namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

// The liquid has risen by two fifths of a cell since its particles were in order: on one side some are beyond the band,
// on the other some blocks are new in it.
Fluid<float> risen(Fluid<float> fluid) {
  for (float& phi : fluid.phi.value) phi -= .4f * fluid.spacing;
  return fluid;
}

// The quarter of the box nearest to the origin along z has no particles yet.
Particles<float> thinned(const Fluid<float>& fluid, Particles<float> particles) {
  const std::size_t blocks = std::size_t(fluid.nz / 4) * fluid.nx * fluid.ny;
  const std::int32_t gone = particles.first[blocks];
  const auto drop = [&](Array<float>& array) { array.erase(array.begin(), array.begin() + gone); };
  drop(particles.position.x), drop(particles.position.y), drop(particles.position.z);
  drop(particles.radius), drop(particles.sign);
  resize(particles, particles.count - gone);
  for (std::int32_t& first : particles.first) first = std::max(first - gone, 0);
  return particles;
}

Case make(const std::string& path) {
  struct From {
    Fluid<float> fluid;
    Particles<float> particles;
  };
  const auto in = inputs(path);
  const auto from =
      std::make_shared<const From>(From{risen(in->scene.fluid), thinned(in->scene.fluid, *particles(path))});
  Particles<float> start = *particles(path);
  poison(start);
  const auto with = [from](Reseed<float>* reseed) {
    return [from, reseed](Particles<float>& reseeded) {
      // Most blocks have sixteen, so that in most some must go.
      reseed(from->fluid, {.per_block = 14, .seed = 5, .round = 3}, from->particles, reseeded);
    };
  };
  const double count = particles(path)->count, cells = cells_of(*in);
  return make_case<Particles<float>>({
      .start = std::make_shared<const Particles<float>>(std::move(start)),
      .serial = with(serial::reseed),
      .best_serial = nullptr,
      .openmp = with(openmp::reseed),
      .compare = nullptr,
      // A particle read and written; phi, solid and where a block's particles begin, before and after. phi at a
      // particle: into the block's place 6, seven interpolations of 3; its rank 2.
      .work = {count, "particles", 40 * count + 16 * cells, (6 + 21 + 2) * count},
  });
}

const Register reseed{
    {.name = "production_fluid/reseed", .place = 16, .forms = {{.make = make, .scenes = advection_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_reseed
