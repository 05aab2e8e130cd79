#include "verify/selection.h"

#include <algorithm>
#include <filesystem>

#include "common/input_error.h"

namespace lockstep::verify {

std::vector<Selected> select(const Options& options, Purpose purpose) {
  std::vector<Kernel> chosen;
  std::string known;
  for (const Kernel& kernel : kernels()) {
    if ((options.kernel.empty() || options.kernel == kernel.name) &&
        (options.form.empty() || options.form == kernel.form))
      chosen.push_back(kernel);
    known += (known.empty() ? "" : ", ") + kernel.name + " " + kernel.form;
  }
  if (chosen.empty())
    throw InputError("no kernel " + options.kernel + " " + options.form + ", expected one of: " + known);

  // If --scene is a name that some kernel registers, it selects that scene on the kernels that register it. Otherwise
  // it is the path of a user's scene, for the kernels that accept it.
  const auto known_as = [&](const Kernel& kernel, const std::string& name) {
    std::vector<std::string> paths = kernel.scenes;
    paths.insert(paths.end(), kernel.more_scenes.begin(), kernel.more_scenes.end());
    std::erase_if(paths, [&](const std::string& path) { return std::filesystem::path(path).stem() != name; });
    return paths;
  };
  const bool named =
      std::ranges::any_of(chosen, [&](const Kernel& kernel) { return !known_as(kernel, options.scene).empty(); });

  std::vector<Selected> selected;
  for (const Kernel& kernel : chosen) {
    std::vector<std::string> paths = purpose == Purpose::bench ? kernel.bench_scenes : kernel.scenes;
    if (options.full) paths.insert(paths.end(), kernel.more_scenes.begin(), kernel.more_scenes.end());
    if (named) {
      paths = known_as(kernel, options.scene);
    } else if (!options.scene.empty()) {
      paths.clear();
      if (kernel.takes(options.scene)) paths.push_back(options.scene);
    }
    for (const std::string& path : paths) selected.push_back({kernel, path});
  }
  if (selected.empty())
    throw InputError("--scene " + options.scene + ": not a scene that " + chosen.front().name + " takes");
  return selected;
}

}  // namespace lockstep::verify
