#include "verify/selection.h"

#include <algorithm>
#include <filesystem>

#include "common/input_error.h"

namespace lockstep::verify {

std::vector<Selected> select(const Options& options, Purpose purpose) {
  std::vector<Kernel> chosen;
  std::string known;
  for (const Kernel& kernel : kernels()) {
    if ((options.kernel.empty() || options.kernel == kernel.name) && (options.form.empty() || options.form == kernel.form))
      chosen.push_back(kernel);
    known += (known.empty() ? "" : ", ") + kernel.name + " " + kernel.form;
  }
  if (chosen.empty()) throw InputError("no kernel " + options.kernel + " " + options.form + ", expected one of: " + known);

  std::vector<Selected> selected;
  for (const Kernel& kernel : chosen) {
    std::vector<std::string> paths = purpose == Purpose::bench ? kernel.bench_scenes : kernel.scenes;
    if (options.full) paths.insert(paths.end(), kernel.more_scenes.begin(), kernel.more_scenes.end());
    if (!options.scene.empty()) {
      paths = kernel.scenes;
      paths.insert(paths.end(), kernel.more_scenes.begin(), kernel.more_scenes.end());
      // A name stands for the scene of that name; anything else is a path to a scene of the user's own.
      std::erase_if(paths, [&](const std::string& path) { return std::filesystem::path(path).stem() != options.scene; });
      if (paths.empty()) paths = {options.scene};
      paths.resize(1);
    }
    for (const std::string& path : paths) selected.push_back({kernel, path});
  }
  return selected;
}

}  // namespace lockstep::verify
