#include "common/toml.h"

#include <cmath>

#include "common/input_error.h"
#include "common/input_file.h"

namespace lockstep {

toml::table parse_toml(const std::string& path) {
  std::ifstream in = open_input(path);
  try {
    return toml::parse(in, path);
  } catch (const toml::parse_error& error) {
    refuse(error.source(), std::string(error.description()));
  }
}

std::string position(const toml::source_region& source) {
  return *source.path + ':' + std::to_string(source.begin.line) + ':' + std::to_string(source.begin.column);
}

void refuse(const toml::source_region& source, const std::string& message) { throw InputError(position(source) + ": " + message); }

void refuse_value(const toml::node& value, std::string_view key, std::string_view expected) {
  refuse(value.source(), std::string(key) + ": expected " + std::string(expected));
}

void check_keys(const toml::table& table, Keys required, Keys optional) {
  for (const auto& [key, value] : table) {
    std::string known;
    bool found = false;
    for (const auto& keys : {required, optional})
      for (const std::string_view k : keys) {
        found |= key.str() == k;
        known += (known.empty() ? "" : ", ") + std::string(k);
      }
    if (!found) refuse(key.source(), "unknown key " + std::string(key.str()) + ", expected one of: " + known);
  }
  for (const std::string_view k : required)
    if (!table.contains(k)) refuse(table.source(), std::string(k) + " is missing");
}

std::optional<double> as_number(const toml::node& value) {
  constexpr double largest = 1e18;
  const auto x = value.is_integer() ? static_cast<double>(value.as_integer()->get()) : value.value_exact<double>();
  return x && std::abs(*x) <= largest ? x : std::nullopt;
}

std::optional<std::int64_t> whole(const toml::table& table, std::string_view key, std::int64_t min, std::int64_t max) {
  const toml::node* value = table.get(key);
  if (!value) return std::nullopt;
  const std::optional<std::int64_t> x = value->value_exact<std::int64_t>();
  if (!x || *x < min || *x > max) refuse_value(*value, key, "a whole number from " + std::to_string(min) + " to " + std::to_string(max));
  return x;
}

std::optional<bool> truth(const toml::table& table, std::string_view key) {
  const toml::node* value = table.get(key);
  if (!value) return std::nullopt;
  const std::optional<bool> x = value->value_exact<bool>();
  if (!x) refuse_value(*value, key, "true or false");
  return x;
}

std::optional<std::string> text(const toml::table& table, std::string_view key) {
  const toml::node* value = table.get(key);
  if (!value) return std::nullopt;
  const std::optional<std::string> x = value->value_exact<std::string>();
  if (!x) refuse_value(*value, key, "text in quotes");
  return x;
}

std::optional<Vector3<double>> vector(const toml::table& table, std::string_view key, std::string_view unit) {
  const toml::node* value = table.get(key);
  if (!value) return std::nullopt;
  const std::string expected = "three finite numbers [x, y, z] in " + std::string(unit);
  const toml::array* array = value->as_array();
  if (!array || array->size() != 3) refuse_value(*value, key, expected);
  const auto component = [&](int axis) {
    const std::optional<double> x = as_number((*array)[axis]);
    if (!x) refuse_value((*array)[axis], key, expected);
    return *x;
  };
  return Vector3<double>{component(0), component(1), component(2)};
}

const toml::table* subtable(const toml::table& table, std::string_view key) {
  const toml::node* value = table.get(key);
  if (!value) return nullptr;
  if (!value->is_table()) refuse_value(*value, key, "a table [" + std::string(key) + "]");
  return value->as_table();
}

std::vector<const toml::table*> subtables(const toml::table& table, std::string_view key) {
  const toml::node* value = table.get(key);
  if (!value) return {};
  const std::string heading = "[[" + std::string(key) + "]]";
  const toml::array* array = value->as_array();
  if (!array || array->empty()) refuse_value(*value, key, "one or more tables " + heading);
  std::vector<const toml::table*> tables;
  for (const toml::node& element : *array) {
    if (!element.is_table()) refuse_value(element, key, "a table " + heading);
    tables.push_back(element.as_table());
  }
  return tables;
}

}  // namespace lockstep
