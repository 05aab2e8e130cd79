// Files that are read.
#pragma once

#include <fstream>
#include <string>

namespace lockstep {

// The file, open for reading in binary. Throws InputError with the system's reason where it is missing, is not a regular file
// (a directory, a pipe) or may not be read.
std::ifstream open_input(const std::string& path);

}  // namespace lockstep
