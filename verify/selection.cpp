#include "verify/selection.h"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include "common/input_error.h"
#include "verify/domain.h"
#include "verify/names.h"

namespace lockstep::verify {

namespace {

// The kernels and forms that the options name. Throws InputError if there are none.
std::vector<Kernel> chosen_kernels(const Options& options) {
  std::vector<Kernel> of_name, chosen;
  std::vector<std::string> names, forms;
  const std::vector<Kernel> all = kernels();
  for (const Kernel& kernel : all) {
    const auto names_this = [&](const std::string& named) { return names_kernel(named, kernel.name); };
    names.push_back(kernel.name), names.push_back(kernel.name.substr(kernel.name.find('/') + 1));
    if (options.kernels.empty() || std::ranges::any_of(options.kernels, names_this)) of_name.push_back(kernel);
  }
  for (const std::string& named : options.kernels)
    if (std::ranges::none_of(all, [&](const Kernel& kernel) { return names_kernel(named, kernel.name); }))
      throw InputError("no kernel " + named + ", see `lockstep list`" + did_you_mean(named, names));
  for (const Kernel& kernel : of_name) {
    if (options.form.empty() || options.form == kernel.form) chosen.push_back(kernel);
    if (!kernel.form.empty() && std::ranges::find(forms, kernel.form) == forms.end()) forms.push_back(kernel.form);
  }
  if (chosen.empty())
    throw InputError(
        "no form " + options.form + " of " + (options.kernels.empty() ? "any kernel" : joined(options.kernels, ",")) +
        (forms.empty() ? ", which has one form without a name" : ", expected one of: " + joined(forms, ", ")));
  return chosen;
}

}  // namespace

std::vector<Selected> select(const Options& options, Purpose purpose) {
  const std::vector<Kernel> chosen = chosen_kernels(options);

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

  std::vector<Selected> selected, share;
  for (const Kernel& kernel : chosen) {
    std::vector<std::string> paths = purpose == Purpose::bench ? kernel.bench_scenes : kernel.scenes;
    if (options.full)
      std::ranges::copy_if(kernel.more_scenes, std::back_inserter(paths),
                           [&](const std::string& path) { return std::ranges::find(paths, path) == paths.end(); });
    if (named) {
      paths = known_as(kernel, options.scene);
    } else if (!options.scene.empty()) {
      paths.clear();
      const std::string path = scene_file(options.scene);
      if (kernel.takes(path)) paths.push_back(path);
    }
    if (options.quick && options.scene.empty()) paths.resize(std::min<std::size_t>(1, paths.size()));
    for (const std::string& path : paths) selected.push_back({kernel, path, selected.size()});
  }
  if (selected.empty() && options.scene.empty())
    throw InputError(chosen.front().name + " " + chosen.front().form + " has no scenes for this command");
  if (selected.empty())
    throw InputError("--scene " + options.scene + ": is a scene of " + domain_of_scene(scene_file(options.scene)).name +
                     ", which " + chosen.front().name + " does not take");
  std::ranges::copy_if(selected, std::back_inserter(share),
                       [&](const Selected& each) { return in_share(options.shard, each.place); });
  return share;
}

Selected select_one(const std::string& kernel, const std::string& form, const std::string& scene) {
  Options options;
  options.kernels = {kernel}, options.form = form, options.scene = scene;
  return select(options, Purpose::bench).at(0);
}

}  // namespace lockstep::verify
