// The forms of a whole step of the game fluid, by name.
#pragma once

#include <string>

#include "common/fluid/step.h"

namespace lockstep::verify {

struct StepForm {
  std::string variant, name;
  fluid::Step<float>* step;
  fluid::Step<float>* serial;  // the serial form of the same algorithm
};

// Of each variant, the form that `run` takes unless told otherwise comes first.
inline const StepForm step_forms[] = {
    {"serial", "symmetric", fluid::serial::step_symmetric, fluid::serial::step_symmetric},
    {"serial", "owner_gather", fluid::serial::step_owner_gather, fluid::serial::step_owner_gather},
    {"serial", "pair_lists", fluid::serial::step_pair_lists, fluid::serial::step_pair_lists},
    {"openmp", "pair_lists", fluid::openmp::step_pair_lists, fluid::serial::step_pair_lists},
    {"openmp", "owner_gather", fluid::openmp::step_owner_gather, fluid::serial::step_owner_gather},
    {"openmp", "sub_grid", fluid::openmp::step_sub_grid, fluid::serial::step_symmetric},
    {"openmp", "cell_locks", fluid::openmp::step_cell_locks, fluid::serial::step_symmetric},
};

}  // namespace lockstep::verify
