// What all scenes have in common: a file, which says of what kind it is.
#pragma once

#include <string>

namespace lockstep {

// "fluid", "cloth", "levelset" or "rigid": "fluid" for a .fluid file, else the TOML's `kind`. Throws InputError where it cannot be read or
// is none of them; what else the scene says is not looked at.
std::string kind_of_scene(const std::string& path);

}  // namespace lockstep
