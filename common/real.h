// The working type of the file that is being compiled.
//
// Every file in serial/ is compiled twice from the same source: once with Real = float, the papers' working type, and
// once with Real = double, the truth that the verifier measures both versions against. The parameter types
// (Model<float>, Model<double>, ...) tell the two apart, so callers simply overload. openmp/ is compiled for float
// only.
//
// For .cpp files in serial/ and openmp/ alone: a header must not depend on how the file that includes it is compiled.
#pragma once

#ifndef LOCKSTEP_REAL
#define LOCKSTEP_REAL float
#endif

namespace lockstep {
using Real = LOCKSTEP_REAL;
}
