#include "common/scene_reader.h"

#include <cmath>
#include <filesystem>

#include "common/digits.h"

namespace lockstep {
namespace {

// As limits are written: large and small powers of ten as 1e9, not as 1000000000 or 1e+09.
std::string limit(double x) {
  const double exponent = x > 0 ? std::log10(x) : 0;
  return exponent == std::round(exponent) && std::abs(exponent) >= 3 ? "1e" + digits_of(exponent) : digits_of(x);
}

std::string range(double low, double high, std::string_view unit) {
  return "from " + limit(low) + " to " + limit(high) + (unit.empty() ? "" : ", in " + std::string(unit));
}

}  // namespace

toml::table read_scene(const std::string& path, std::string_view kind, Keys required, Keys optional) {
  toml::table scene = parse_toml(path);
  const toml::node* value = scene.get("kind");
  if (value && value->value_exact<std::string>() != kind) refuse_value(*value, "kind", '"' + std::string(kind) + '"');
  check_keys(scene, required, optional);
  return scene;
}

std::string scene_name(const std::string& path) { return std::filesystem::path(path).stem().string(); }

std::string beside(const std::string& scene_path, const std::string& file) {
  return std::filesystem::path(scene_path).replace_filename(file).string();
}

std::optional<double> number_between(const toml::table& table, std::string_view key, double low, double high,
                                     std::string_view unit) {
  return number(table, key, "a number " + range(low, high, unit), [&](double x) { return x >= low && x <= high; });
}

std::optional<Vector3<double>> vector_between(const toml::table& table, std::string_view key, double low, double high,
                                              std::string_view unit) {
  const std::optional<Vector3<double>> v = vector(table, key, unit);
  if (!v) return v;
  for (const double x : {v->x, v->y, v->z})
    if (!(x >= low && x <= high)) refuse_value(*table.get(key), key, "three numbers " + range(low, high, unit));
  return v;
}

std::optional<int> whole_int(const toml::table& table, std::string_view key, int low, int high) {
  const std::optional<std::int64_t> x = whole(table, key, low, high);
  return x ? std::optional(static_cast<int>(*x)) : std::nullopt;
}

}  // namespace lockstep
