// The forms of a frame of the production face, by name.
#pragma once

#include <string>

#include "common/production_face/step.h"

namespace lockstep::verify {

struct FaceForm {
  std::string name;
  production_face::Step<float, linear::BlockRows<float>>* serial;
  production_face::Step<float, linear::SlicedBlockRows>* openmp;
};

// The form that `run` takes unless told otherwise comes first.
inline const FaceForm face_forms[] = {
    {"newton", production_face::serial::step_newton, production_face::openmp::step_newton},
    {"facesim", production_face::serial::step_facesim, production_face::openmp::step_facesim},
};

}  // namespace lockstep::verify
