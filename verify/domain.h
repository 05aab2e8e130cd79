// A domain as the program sees it, beyond its kernels, and how a domain registers.
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "verify/options.h"
#include "verify/simulation.h"

namespace lockstep::verify {

// A domain registers by one constant in verify/DOMAIN/domain.cpp, `const RegisterDomain cloth{{.name = "cloth",
// ...}};`, and by one line in verify/domains.cpp, which sets the order of the domains.
struct Domain {
  std::string name;                                       // of its folders, and the `kind` in its scenes
  Simulation (*simulation)(const RunOptions&) = nullptr;  // for `run`; absent if scenes have no simulation
  bool moves = true;                                      // for `endure`: whether a simulation has more than one step
  std::vector<std::string> determinism;                   // scenes for `make determinism`, by name
  // Where steps take long: for `endure` unless it is told a scene, these scenes alone, and at most so many steps.
  std::vector<std::string> endure = {};  // by name; all if empty
  int most_steps = std::numeric_limits<int>::max();
  std::vector<std::string> formats = {};                   // file extensions of scenes besides .toml
  std::string (*fault_of_scene)(const std::string& path);  // loads a scene and names the first invalid value in
                                                           // it, "" if none; throws InputError if it is refused
};

struct RegisterDomain {
  explicit RegisterDomain(Domain domain);
};

// All domains, in the order of verify/domains.cpp.
const std::vector<Domain>& domains();

// The domain of a scene's kind. Throws InputError if the scene cannot be read or its kind is unknown.
const Domain& domain_of_scene(const std::string& path);

}  // namespace lockstep::verify
