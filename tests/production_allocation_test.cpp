// Whole steps of the production applications where memory runs out (failing_allocation.h).
#include <gtest/gtest.h>

#include "common/production_fluid/scene.h"
#include "common/production_fluid/step.h"
#include "tests/failing_allocation.h"
#include "tests/production_face_bodies.h"
#include "tests/production_faces.h"
#include "verify/production_cloth/moving.h"

namespace lockstep {
namespace {

namespace fluid {

using namespace production_fluid;

struct Moving {
  Model model;
  Liquid<float> liquid;
  StepMemory<float> memory;
};

// A substep of water with a surface and particles.
TEST(ProductionAllocation, FailsOutsideOfTheFluidsStep) {
  const Scene scene = load_scene("scenes/production_fluid/open_top.toml");
  Moving start = {scene.model, {}, {}};
  start.liquid.fluid = scene.fluid;
  start.model.frame = 1e-3;
  serial::start(start.model, start.liquid, start.memory);
  for (Step<float>* const step : {openmp::step_multigrid, openmp::step_mic, openmp::step_marching})
    every_allocation_may_fail<Moving>(start, [step](Moving& m) { step(m.model, m.liquid, m.memory); });
}

}  // namespace fluid

namespace face {

using namespace production_face;

struct Moving {
  Pose<float> pose;
  OpenmpMemory memory;
};

// A frame of a bar whose one end moves.
TEST(ProductionAllocation, FailsOutsideOfTheFacesStep) {
  const Body<float> body =
      held_where(make_body(make_lattice({8, 4, 2}, 1 / 128.), {}, 0), [](const Vector& x) { return x.x == 0; });
  Posed<float> p = posed<float>(body);
  for (float& x : p.target.held.x) x = 1e-3f;
  for (auto* const step : {openmp::step_newton, openmp::step_facesim})
    every_allocation_may_fail<Moving>({p.pose, {}}, [&](Moving& m) {
      m.memory = openmp::make_memory(p.face);
      step(p.face, p.target, 1e-3, m.pose, m.memory);
    });
}

}  // namespace face

namespace cloth {

using namespace production_cloth;

// A step of a crumpled cloth in which impulses do not suffice.
TEST(ProductionAllocation, FailsOutsideOfTheClothsStep) {
  const auto in = verify::production_cloth_inputs::moving_inputs("scenes/production_cloth/crumple.toml");
  for (auto* const step : {openmp::step_jacobi, openmp::step_batches})
    every_allocation_may_fail<Motion<float>>(in->motion, [&](Motion<float>& motion) {
      StepMemory<float> memory = openmp::make_memory(in->cloth);
      step(in->cloth, in->script, motion, memory);
    });
}

}  // namespace cloth

}  // namespace
}  // namespace lockstep
