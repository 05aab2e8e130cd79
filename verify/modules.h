// Frames of the production applications by module.
#pragma once

#include "verify/options.h"
#include "verify/rows_of.h"
#include "verify/scale.h"

namespace lockstep::verify {

// Milliseconds of a frame of the production fluid by module, serial and on 1, 2, 4, ... threads, after a frame that is
// not timed.
void production_modules(const FigureOptions& options, const Model& model, RowsOf& rows);

// The same of the production face, in each form: the third frame, from the pose that openmp's second has reached.
void face_modules(const FigureOptions& options, const Model& model, RowsOf& rows);

// The same of the production cloth (production_cloth/frame.h).
void cloth_modules(const FigureOptions& options, const Model& model, RowsOf& rows);

}  // namespace lockstep::verify
