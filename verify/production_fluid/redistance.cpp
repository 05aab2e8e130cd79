// The level set made a distance again, as the verifier and the benchmark see it: bitwise with the serial twin, padding
// included, which no kernel writes. And sweeping beside marching: the same distances to within rounding.
#include "common/production_fluid/redistance.h"

#include <algorithm>
#include <cmath>

#include "verify/compare.h"
#include "verify/production_fluid/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_redistance {

// What the kernel changes, and its scratch.
struct Redistanced {
  production_fluid::Field<float> phi;
  production_fluid::Distances<float> distances;
};
template <Same<Redistanced> R, class F>
void for_each_array(R& redistanced, const F& f) {
  f("phi", redistanced.phi.value, redistanced.phi.value.size());
}

namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

// The scene's level set, too steep in some places and too flat in others.
Field<float> distorted(Field<float> phi) {
  for (int z = 0; z < phi.nz; ++z)
    for (int y = 0; y < phi.ny; ++y)
      for (int x = 0; x < phi.nx; ++x) phi(x, y, z) *= 1.25f + std::sin(.2f * x) * std::cos(.15f * y + .1f * z);
  return phi;
}

// A solution rounds by less than ten u of itself, and a path to the edge of the band has at most three steps a spacing
// (notes/levelset.md, "Bounds").
Judgement same_distances(const Redistanced& openmp, const Redistanced& serial) {
  Judgement judgement{.verdict = Verdict::converged, .worst_at = ""};
  const Field<float>&a = serial.phi, &b = openmp.phi;
  const double band = band_of_level_set * a.spacing;
  judgement.bound = 10 * unit_roundoff * (3 * band_of_level_set) * band;
  for (int z = 0; z < a.nz; ++z)
    for (int y = 0; y < a.ny; ++y)
      for (int x = 0; x < a.nx; ++x) {
        const double error = std::abs(double(a(x, y, z)) - b(x, y, z));
        if (error <= judgement.error) continue;
        judgement.error = error;
        judgement.worst_at =
            both_values("phi[" + std::to_string(x) + ", " + std::to_string(y) + ", " + std::to_string(z) + "]",
                        b(x, y, z), a(x, y, z));
      }
  judgement.passed = judgement.error <= judgement.bound;
  return judgement;
}

Case make(const std::string& path, Redistance<float>* serial, Redistance<float>* openmp,
          Judgement (*compare)(const Redistanced& openmp, const Redistanced& serial)) {
  const auto in = inputs(path);
  const auto start = std::make_shared<const Redistanced>(Redistanced{distorted(in->scene.fluid.phi), {}});
  const float h = in->scene.fluid.spacing, band = band_of_level_set * h;
  double near = 0;  // cells in the band
  for (const float phi : in->scene.fluid.phi.value) near += std::abs(phi) < band;
  const auto with = [band](Redistance<float>* redistance) {
    return [band, redistance](Redistanced& r) { redistance(r.phi, band, r.distances); };
  };
  Redistance<float>* const best = serial::redistance_sweeping;
  const double cells = cells_of(*in);
  return make_case<Redistanced>({
      .start = start,
      .serial = with(serial),
      .best_serial = serial == best ? std::function<void(Redistanced&)>() : with(best),
      .openmp = with(openmp),
      .compare = compare,
      // phi read twice and written, a distance written and read; eight sweeps of the band.
      .work = {cells, "cells", 20 * cells + 8 * 8 * near, 8 * 20 * near},
      .restore = [](Redistanced& now, const Redistanced& start) { now.phi.value = start.phi.value; },
  });
}

// full_box has no surface.
Scenes redistance_scenes() {
  return {.verify = {"drop_64", "obstacle_48", "one_cell", "full_box", "two_pockets"},
          .more = {"drop_128", "drop_256"},
          .bench = {"drop_128"},
          .tsan = {"obstacle_48"}};
}

const Register redistance{
    {.name = "production_fluid/redistance",
     .place = 8,
     .serial_forms = {"sweeping", "marching"},
     .forms = {{.name = "sweeping",
                .make =
                    [](const std::string& path) {
                      return make(path, serial::redistance_sweeping, openmp::redistance_sweeping, nullptr);
                    },
                .scenes = redistance_scenes()},
               {.name = "marching",
                .make =
                    [](const std::string& path) {
                      return make(path, serial::redistance_marching, openmp::redistance_marching, nullptr);
                    },
                .scenes = redistance_scenes()},
               {.name = "sweeping_for_marching",
                .make =
                    [](const std::string& path) {
                      return make(path, serial::redistance_marching, openmp::redistance_sweeping, same_distances);
                    },
                .scenes = {.verify = {"drop_64", "obstacle_48"}, .more = {"drop_128"}, .bench = {}, .tsan = {}},
                .covered_by = "sweeping"}}}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_redistance
