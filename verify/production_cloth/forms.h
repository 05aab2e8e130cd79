// The forms of a step of the production cloth, by name.
#pragma once

#include <string>

#include "common/production_cloth/step.h"

namespace lockstep::verify {

struct ProductionClothForm {
  std::string name;
  production_cloth::Step<float>* serial;
  production_cloth::Step<float>* openmp;  // absent: the form is serial alone
};

// The form that `run` takes unless told otherwise comes first.
inline const ProductionClothForm production_cloth_forms[] = {
    {"batches", production_cloth::serial::step_batches, production_cloth::openmp::step_batches},
    {"jacobi", production_cloth::serial::step_jacobi, production_cloth::openmp::step_jacobi},
    {"original", production_cloth::serial::step_original, nullptr},
};

}  // namespace lockstep::verify
