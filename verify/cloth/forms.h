// The forms of the game cloth's relaxation and of its whole step, by name.
#pragma once

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include "common/cloth/relax.h"
#include "common/cloth/step.h"

namespace lockstep::verify {

struct ClothForm {
  std::string name;
  bool for_meshes;                                  // else for sheets alone
  cloth::Relax<float>*serial_relax, *openmp_relax;  // none where there is no such form
  cloth::Step<float>*serial_step, *openmp_step;
};

// The form that `run` takes unless told otherwise is the first that a cloth can have.
inline const ClothForm cloth_forms[] = {
    {"chains", false, cloth::serial::relax_chains, cloth::openmp::relax_chains, cloth::serial::step_chains,
     cloth::openmp::step_chains},
    {"colours", false, cloth::serial::relax_colours, cloth::openmp::relax_colours, cloth::serial::step_colours,
     cloth::openmp::step_colours},
    {"batches", true, cloth::serial::relax_batches, cloth::openmp::relax_batches, cloth::serial::step_batches,
     cloth::openmp::step_batches},
    {"original", true, cloth::serial::relax_original, nullptr, cloth::serial::step_original, nullptr},
};

inline const ClothForm& first_form(const cloth::Cloth<float>& cloth) {
  return *std::find_if(std::begin(cloth_forms), std::end(cloth_forms),
                       [&](const ClothForm& form) { return form.for_meshes || cloth.sheet.rows > 0; });
}

inline const std::vector<std::string> serial_cloth_forms = {"original", "chains", "colours", "batches"};

}  // namespace lockstep::verify
