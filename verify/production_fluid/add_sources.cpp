// Sources, as the verifier and the benchmark see them: bitwise with the serial twin, the level set, every face, the
// particles' signs and the padding.
#include "common/production_fluid/add_sources.h"

#include "verify/production_fluid/advection.h"
#include "verify/production_fluid/inputs.h"
#include "verify/production_fluid/particles.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_add_sources {

struct Poured {
  production_fluid::Fluid<float> fluid;
  production_fluid::Particles<float> particles;
};
template <Same<Poured> S, class F>
void for_each_array(S& poured, const F& f) {
  for_each_array(poured.fluid, f);
  f("sign", poured.particles.sign, poured.particles.count);
}

namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

constexpr double now = 2;  // s

// One in the middle, one that has ceased, one that reaches out of three sides of the box and into the first. They meet
// obstacles, particles and lanes that are not full.
std::vector<Source> sources_in(const Fluid<float>& fluid) {
  const double h = fluid.spacing, x = h * fluid.nx, y = h * fluid.ny, z = h * fluid.nz, r = .25 * std::min({x, y, z});
  return {{.centre = {.5 * x, .45 * y, .5 * z}, .radius = r, .velocity = {.5, -1, .25}},
          {.centre = {.3 * x, .6 * y, .4 * z}, .radius = r, .velocity = {3, 3, 3}, .until = now},
          {.centre = {.8 * x, .85 * y, .9 * z}, .radius = 1.8 * r, .velocity = {-.75, .125, 2}, .until = 1.5 * now}};
}

double volume_of(const NearBall& box) {
  const auto length = [](const Range& range) { return double(range.end - range.begin); };
  return length(box.x) * length(box.y) * length(box.z);
}

Case make(const std::string& path) {
  const auto in = inputs(path);
  const Fluid<float>& fluid = in->scene.fluid;
  auto start = std::make_shared<Poured>(Poured{fluid, *particles(path)});
  start->fluid.velocity = velocity(*in);
  const std::vector<Source> sources = sources_in(fluid);
  const auto with = [sources](AddSources<float>* add_sources) {
    return [sources, add_sources](Poured& poured) { add_sources(sources, now, poured.fluid, poured.particles); };
  };
  double cells = 0;
  int running = 0;
  for (const Source& source : sources)
    if (source.until > now) cells += volume_of(near_ball(source, fluid)), ++running;
  const double of_particles = double(running) * start->particles.count;
  return make_case<Poured>({
      .start = start,
      .serial = with(serial::add_sources),
      .best_serial = nullptr,
      .openmp = with(openmp::add_sources),
      .compare = nullptr,
      // Of a cell, phi read and written, solid read; of the few faces in a ball, their velocity written. Positions and
      // signs of particles. A position along x 2, a level 3 + 5 + 1 + 1, for a cell and its three faces.
      .work = {cells, "cells", 12 * cells + 16 * of_particles, 4 * 12 * cells + 10 * of_particles},
      .restore = nullptr,
  });
}

// The sides of one_cell are narrower than a vector.
const Register add_sources{
    {.name = "production_fluid/add_sources",
     .place = 19,
     .forms = {{.make = make,
                .scenes = {.verify = {"one_cell", "obstacle_48", "two_pockets", "drop_64", "jet_24"},
                           .more = {"drop_128"},
                           .bench = {"drop_128"},
                           .tsan = {"obstacle_48"}}}}}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_add_sources
