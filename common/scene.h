// What all scenes have in common: a file, which says of what kind it is.
#pragma once

#include <span>
#include <string>

namespace lockstep {

// The TOML's `kind`, one of `kinds`. Throws InputError, with file, line and column, where it is none of them or the
// file cannot be read. What else the scene says is not looked at.
std::string kind_of_scene(const std::string& path, std::span<const std::string> kinds);

}  // namespace lockstep
