// How large a problem must be for 64 cores to be in use.
#pragma once

#include "verify/options.h"
#include "verify/rows_of.h"
#include "verify/scale.h"

namespace lockstep::verify {

// A handful of kernels on scenes of growing size, each modelled on 1 and on 64 cores. Quick: on the two smallest.
void problem_sizes(const FigureOptions& options, const Model& model, RowsOf& rows);

}  // namespace lockstep::verify
