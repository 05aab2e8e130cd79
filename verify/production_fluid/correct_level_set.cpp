// The level set that particles correct, as the verifier and the benchmark see it: bitwise with the serial twin, padding
// included, which no kernel writes.
#include "common/production_fluid/correct_level_set.h"

#include "verify/production_fluid/advection.h"
#include "verify/production_fluid/inputs.h"
#include "verify/production_fluid/particles.h"
#include "verify/twin.h"

namespace lockstep::verify::production_fluid_correct_level_set {

// What the kernel changes.
struct CorrectedLevelSet {
  production_fluid::Field<float> phi;
};
template <Same<CorrectedLevelSet> C, class F>
void for_each_array(C& corrected, const F& f) {
  f("phi", corrected.phi.value, corrected.phi.value.size());
}

namespace {

using namespace production_fluid;
using namespace production_fluid_inputs;

Case make(const std::string& path) {
  const auto in = inputs(path);
  const auto escaped = particles(path);
  const auto with = [escaped](CorrectLevelSet<float>* correct_level_set) {
    return [escaped, correct_level_set](CorrectedLevelSet& corrected) { correct_level_set(*escaped, corrected.phi); };
  };
  const double n = escaped->count;
  return make_case<CorrectedLevelSet>({
      .start = std::make_shared<const CorrectedLevelSet>(CorrectedLevelSet{in->scene.fluid.phi}),
      .serial = with(serial::correct_level_set),
      .best_serial = nullptr,
      .openmp = with(openmp::correct_level_set),
      .compare = nullptr,
      // A particle read, and phi of a block; three into cells, three fractions, seven interpolations of 3.
      .work = {n, "particles", 20 * n + 4 * n / 16, (3 + 3 + 21 + 1) * n},
  });
}

const Register correct_level_set{{.name = "production_fluid/correct_level_set",
                                  .place = 12,
                                  .forms = {{.make = make, .scenes = advection_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_fluid_correct_level_set
