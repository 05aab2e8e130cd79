#include "common/scene.h"

#include <filesystem>

#include "common/toml.h"

namespace lockstep {

std::string kind_of_scene(const std::string& path) {
  if (std::filesystem::path(path).extension() == ".fluid") return "fluid";
  const toml::table scene = parse_toml(path);
  const toml::node* kind = scene.get("kind");
  if (!kind) refuse(scene.source(), "kind is missing");
  const std::string name = kind->value_exact<std::string>().value_or("");
  if (name != "fluid" && name != "cloth" && name != "levelset" && name != "rigid")
    refuse_value(*kind, "kind", "\"fluid\", \"cloth\", \"levelset\" or \"rigid\"");
  return name;
}

}  // namespace lockstep
