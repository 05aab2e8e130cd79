// What the program knows of a domain beyond its kernels, and how a domain joins.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "verify/options.h"
#include "verify/simulation.h"

namespace lockstep::verify {

// Joins by one constant in verify/DOMAIN/domain.cpp, `const RegisterDomain cloth{{.name = "cloth", ...}};`, and by one line
// in verify/domains.cpp, which says where it comes.
struct Domain {
  std::string name;                                        // of its folders, and the kind that its scenes state
  Simulation (*simulation)(const RunOptions&) = nullptr;   // what `run` does with its scenes; absent where nothing moves on
  bool moves = true;                                       // whether a simulation has more than one step: for `endure`
  std::vector<std::string> determinism;                    // names of scenes for `make determinism`
  std::vector<std::string> formats = {};                   // endings of files that are scenes, besides .toml
  std::string (*fault_of_scene)(const std::string& path);  // loads a scene; the first thing in it that must not be, ""
                                                           // if there is none. Throws InputError where it is refused.
};

struct RegisterDomain {
  explicit RegisterDomain(Domain domain);
};

// In the order of verify/domains.cpp.
const std::vector<Domain>& domains();

// The domain of a scene's kind. Throws InputError where the scene cannot be read, or its kind is no domain's.
const Domain& domain_of_scene(const std::string& path);

}  // namespace lockstep::verify
