// Speed-up over the number of cores.
#pragma once

#include "verify/options.h"
#include "verify/rows_of.h"
#include "verify/scale.h"

namespace lockstep::verify {

// A handful of kernels, each on one scene, modelled on 1, 2, 4, ..., 128 cores and measured where the machine has as
// many. Quick: on small scenes, and on 1, 2 and 64 cores.
void curves(const FigureOptions& options, const Model& model, RowsOf& rows);

}  // namespace lockstep::verify
