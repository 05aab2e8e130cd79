// What the model's answer at many cores owes to its machine.
#pragma once

#include "verify/options.h"
#include "verify/rows_of.h"
#include "verify/scale.h"

namespace lockstep::verify {

// A handful of kernels on 1 and on 64 cores. Each record is replayed with forks and barriers half as dear, as here, and
// twice as dear, with the memory of this machine and of a server.
void sensitivity(const FigureOptions& options, const Model& model, RowsOf& rows);

}  // namespace lockstep::verify
