#include "verify/domain.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "common/scene.h"

namespace lockstep::verify {
namespace {

// All domains, in the order in which they are listed.
constexpr std::string_view names[] = {
    "fluid", "cloth", "levelset", "linear", "rigid", "production_fluid", "production_face", "production_cloth",
};

// Filled before main by the RegisterDomain constants of other files.
std::vector<Domain>& registered() {
  static std::vector<Domain> all;
  return all;
}

}  // namespace

RegisterDomain::RegisterDomain(Domain domain) { registered().push_back(std::move(domain)); }

const std::vector<Domain>& domains() {
  static const std::vector<Domain> in_order = [] {
    std::vector<Domain> all;
    for (const std::string_view name : names) {
      const auto found = std::ranges::find(registered(), name, &Domain::name);
      if (found == registered().end()) throw std::logic_error("no domain registers as " + std::string(name));
      all.push_back(*found);
    }
    if (all.size() != registered().size()) throw std::logic_error("a domain is missing in verify/domains.cpp");
    return all;
  }();
  return in_order;
}

const Domain& domain_of_scene(const std::string& path) {
  const std::string extension = std::filesystem::path(path).extension();
  for (const Domain& domain : domains())
    if (std::ranges::find(domain.formats, extension) != domain.formats.end()) return domain;
  std::vector<std::string> kinds;
  for (const Domain& domain : domains()) kinds.push_back(domain.name);
  return *std::ranges::find(domains(), kind_of_scene(path, kinds), &Domain::name);
}

}  // namespace lockstep::verify
