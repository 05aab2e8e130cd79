#include "common/scene.h"

#include <algorithm>

#include "common/toml.h"

namespace lockstep {

std::string kind_of_scene(const std::string& path, std::span<const std::string> kinds) {
  const toml::table scene = parse_toml(path);
  const toml::node* kind = scene.get("kind");
  if (!kind) refuse(scene.source(), "kind is missing");
  const std::string name = kind->value_exact<std::string>().value_or("");
  std::string expected;
  for (std::size_t k = 0; k < kinds.size(); ++k)
    expected += (k == 0 ? "" : k + 1 < kinds.size() ? ", " : " or ") + ('"' + kinds[k] + '"');
  if (std::ranges::find(kinds, name) == kinds.end()) refuse_value(*kind, "kind", expected);
  return name;
}

}  // namespace lockstep
