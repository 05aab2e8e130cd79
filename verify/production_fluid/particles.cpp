#include "verify/production_fluid/particles.h"

#include <cmath>

#include "verify/inputs.h"
#include "verify/production_fluid/inputs.h"

namespace lockstep::verify::production_fluid_inputs {

using namespace production_fluid;
using Index = std::int32_t;

// Numerical Recipes, 3rd ed., 7.1.4: the hash of an integer.
double random_of(std::uint64_t x) {
  x = x * 3935559000370003845u + 2691343689449507681u;
  x ^= x >> 21, x ^= x << 37, x ^= x >> 4;
  x *= 4768777513237032717u;
  x ^= x << 20, x ^= x >> 41, x ^= x << 5;
  return 5.42101086242752217e-20 * static_cast<double>(x);
}

namespace {

Particles<float> scattered(const Fluid<float>& fluid) {
  constexpr int per_block = 16;
  const float h = fluid.spacing;
  Particles<float> made;
  Array<float>&px = made.position.x, &py = made.position.y, &pz = made.position.z;
  Index block = 0;
  for (int z = 0; z < fluid.nz; ++z)
    for (int y = 0; y < fluid.ny; ++y)
      for (int x = 0; x < fluid.nx; ++x, ++block) {
        made.first.push_back(static_cast<Index>(px.size()));
        if (std::abs(fluid.phi(x, y, z)) > (band_of_particles + 2) * h) continue;
        for (int k = 0; k < per_block; ++k) {
          const std::uint64_t number = 4 * (per_block * std::uint64_t(block) + k);
          const auto near = [&](int at, int axis) { return float(at + .5 + random_of(number + axis)); };
          const Vector3<float> position = {h * near(x, 0), h * near(y, 1), h * near(z, 2)};
          const Vector3<float> at = (1 / h) * position;
          const float phi = sample<Index>(fluid.phi, first_centre, at);
          if (std::abs(phi) > band_of_particles * h || sample<Index>(fluid.solid, first_centre, at) < 0) continue;
          if (!(at.x < fluid.nx && at.y < fluid.ny && at.z < fluid.nz) || block_of<Index>(fluid.phi, at) != block)
            continue;
          const float side = phi < 0 ? -1.f : 1.f, sign = random_of(number + 3) < 1. / 16 ? -side : side;
          px.push_back(position.x), py.push_back(position.y), pz.push_back(position.z);
          made.radius.push_back(radius_of(side, phi, h)), made.sign.push_back(sign);
        }
      }
  made.first.push_back(static_cast<Index>(px.size()));
  resize(made, px.size());
  return made;
}

}  // namespace

std::shared_ptr<const Particles<float>> particles(const std::string& path) {
  return verify::inputs<Particles<float>>(path, [&] { return scattered(inputs(path)->scene.fluid); });
}

}  // namespace lockstep::verify::production_fluid_inputs
