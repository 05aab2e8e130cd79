// .fluid files, the format of PARSEC's fluidanimate, so that its inputs and frames can be read and compared.
//
// Little-endian: float32 particles per metre, int32 n, then n records of nine float32: position (m), half-step velocity
// (m/s), velocity (m/s), each x y z. Nothing else: 8 + 36 n bytes.
#pragma once

#include <string>

#include "common/fluid/particles.h"

namespace lockstep::fluid {

struct FluidFile {
  float particles_per_metre;
  Particles<float> particles;  // in the order of the file; id is the place in it
};

// Throws InputError, in one line that says what is wrong and where, unless the file can be read, has exactly the size
// its header gives, every number in it is finite, and a simulation of it fits the machine's memory (asked before
// anything is allocated).
FluidFile read_fluid(const std::string& path);

// Writes the particles by id, so that files of two runs compare byte by byte. Throws InputError where the file cannot
// be written, and then leaves nothing behind (common/atomic_file.h).
void write_fluid(const std::string& path, float particles_per_metre, const Particles<float>& particles);

}  // namespace lockstep::fluid
