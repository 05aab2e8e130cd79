// Whole runs of the game cloth: what is asserted of them beyond the bits.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/cloth/relax.h"
#include "common/cloth/scene.h"
#include "common/cloth/step.h"
#include "verify/kernel.h"

namespace lockstep::verify {

// The last state of the serial run of a scene, as many steps as it says. Made once for a scene and form.
std::shared_ptr<const cloth::Cloth<float>> serial_run(const cloth::Scene& scene, const std::string& form,
                                                      cloth::Step<float>* step);

// Asserts of a run of `step` from the scene's start that after every step every number is finite and no particle that
// moves is inside a body, and that the last state has the bits of the serial run's.
void check_run(Judgement& judgement, const cloth::Scene& scene, const cloth::Cloth<float>& expected,
               cloth::Step<float>* step);

// How deep the deepest particle that moves is inside a body, without thickness; 0 where none is. In double.
struct Deepest {
  double depth;
  int particle;
};
Deepest deepest_inside(const cloth::Bodies<double>& bodies, const cloth::Cloth<float>& cloth);

// Says which number is not finite, or which particle is inside a body; empty if there is none.
std::string fault_of(const cloth::Bodies<double>& bodies, const cloth::Cloth<float>& cloth);

// What n iterations a substep leave of the residual: on average over the second half of 60 steps of the scene. A scene
// without gravity is one problem of relaxation, and has one answer: after n iterations from its start.
double residual_left(const cloth::Cloth<float>& start, cloth::Relax<float>* relax, int n);

}  // namespace lockstep::verify
