// Which kernels on which scenes the options select.
#pragma once

#include <string>
#include <vector>

#include "verify/kernel.h"
#include "verify/options.h"

namespace lockstep::verify {

struct Selected {
  Kernel kernel;
  std::string scene_path;
};

enum class Purpose { verify, bench };

// In the kernels' order. Throws InputError where the options name a kernel, a form or a scene that there is not.
std::vector<Selected> select(const Options& options, Purpose purpose);

}  // namespace lockstep::verify
