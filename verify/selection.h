// The kernels and scenes that the options select.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "verify/kernel.h"
#include "verify/options.h"

namespace lockstep::verify {

struct Selected {
  Kernel kernel;
  std::string scene_path;
  std::size_t place;  // among all that are selected, of every shard
};

enum class Purpose { verify, bench };

// In the kernels' order; of a shard, its own. Throws InputError if the options name an unknown kernel, form or scene.
std::vector<Selected> select(const Options& options, Purpose purpose);

// A kernel's form on a scene of that name. Throws InputError if there is none.
Selected select_one(const std::string& kernel, const std::string& form, const std::string& scene);

}  // namespace lockstep::verify
