#include "verify/kernel.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <utility>

#include "verify/domain.h"
#include "verify/names.h"

namespace lockstep::verify {
namespace {

// Filled before main by the Register constants of other files.
std::vector<Registered>& registered() {
  static std::vector<Registered> all;
  return all;
}

std::string domain_of(const std::string& kernel) { return kernel.substr(0, kernel.find('/')); }

std::vector<std::string> paths(const std::string& domain, std::vector<std::string> scenes) {
  for (std::string& name : scenes) name = scenes_folder() + '/' + domain + '/' + name + ".toml";
  return scenes;
}

}  // namespace

const char* name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::bitwise: return "bitwise";
    case Verdict::bounded: return "bounded";
    case Verdict::converged: return "converged";
    case Verdict::physical: return "physical";
  }
  return "";
}

Register::Register(Registered kernel) { registered().push_back(std::move(kernel)); }

std::vector<Kernel> kernels() {
  std::vector<Kernel> all;
  for (const Domain& domain : domains()) {
    std::vector<Registered> of_domain;
    for (const Registered& kernel : registered())
      if (domain_of(kernel.name) == domain.name) of_domain.push_back(kernel);
    std::ranges::sort(of_domain, {}, [](const Registered& kernel) { return std::pair(kernel.place, kernel.name); });
    for (const Registered& kernel : of_domain)
      for (const Form& form : kernel.forms) {
        const auto takes = [name = domain.name, takes = form.takes](const std::string& path) {
          return domain_of_scene(path).name == name && (!takes || takes(path));
        };
        std::vector<std::string> more = form.scenes.more;
        std::erase_if(more, [&](const std::string& name) { return std::ranges::count(form.scenes.verify, name) > 0; });
        all.push_back({kernel.name, form.name, form.order_dependent, paths(domain.name, form.scenes.verify),
                       paths(domain.name, more), paths(domain.name, form.scenes.bench), takes, form.make,
                       paths(domain.name, form.scenes.tsan), form.covered_by, kernel.serial_forms});
      }
  }
  return all;
}

}  // namespace lockstep::verify
