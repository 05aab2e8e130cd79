// Files that are read.
#pragma once

#include <fstream>
#include <string>
#include <string_view>

namespace lockstep {

// The file, open for reading in binary. Throws InputError with the system's reason where it is missing, is not a
// regular file (a directory, a pipe) or may not be read.
std::ifstream open_input(const std::string& path);

// What a file says, for a message that is one line: 160 characters of it at most, and a question mark for what is not
// printable ASCII.
std::string legible(std::string_view text);

}  // namespace lockstep
