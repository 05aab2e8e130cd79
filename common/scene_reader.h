// What the readers of all domains' TOML scenes share.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "common/toml.h"

namespace lockstep {

// The scene as a table. Throws InputError unless its `kind` is this and its keys are these, `kind` among the required.
toml::table read_scene(const std::string& path, std::string_view kind, Keys required, Keys optional);

// The file's name without folder and extension.
std::string scene_name(const std::string& path);

// The path of a file that a scene names: it stands beside the scene.
std::string beside(const std::string& scene_path, const std::string& file);

// Values, as in toml.h: nothing where the key is absent, and refused where they are not within the limits, which the
// message names. `unit` may be empty.
std::optional<double> number_between(const toml::table& table, std::string_view key, double low, double high,
                                     std::string_view unit);
std::optional<Vector3<double>> vector_between(const toml::table& table, std::string_view key, double low, double high,
                                              std::string_view unit);
std::optional<int> whole_int(const toml::table& table, std::string_view key, int low,
                             int high = std::numeric_limits<int>::max());

}  // namespace lockstep
