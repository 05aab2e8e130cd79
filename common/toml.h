// Scenes in TOML, with every mistake reported where it stands: `file:line:column: what was expected`.
#pragma once

// Without this, toml++ 3.3 ends the program by an assertion where a key or a value begins with a character that it may
// not begin with. The code after the assertion refuses it in words, with the place. The fuzzer has found no other
// assertion that can fail.
#define TOML_ASSERT(condition) static_assert(true)
#define TOML_HEADER_ONLY 0  // the parser is compiled once, in toml.cpp
#include <toml++/toml.h>

#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/vector3.h"

namespace lockstep {

// The file as a table. Throws InputError where it cannot be read, does not fit the memory, or is not TOML in ASCII
// (comments apart), with keys of at most sixteen parts.
toml::table parse_toml(const std::string& path);

// file:line:column
std::string position(const toml::source_region& source);

// Throw InputError.
[[noreturn]] void refuse(const toml::source_region& source, const std::string& message);
[[noreturn]] void refuse_value(const toml::node& value, std::string_view key, std::string_view expected);

// Refuses any key but these, and a table without the required ones.
using Keys = std::initializer_list<std::string_view>;
void check_keys(const toml::table& table, Keys required, Keys optional);

// A finite number of at most 1e18, written as an integer or a float; nothing otherwise. 1e18 is far beyond any scene,
// and its square still fits a float.
std::optional<double> as_number(const toml::node& value);

// The readers below give nothing where the key is absent, and refuse any value but the expected.

template <std::predicate<double> Valid>
std::optional<double> number(const toml::table& table, std::string_view key, std::string_view expected, Valid valid) {
  const toml::node* value = table.get(key);
  if (!value) return std::nullopt;
  const std::optional<double> x = as_number(*value);
  if (!x || !valid(*x)) refuse_value(*value, key, expected);
  return x;
}

std::optional<std::int64_t> whole(const toml::table& table, std::string_view key, std::int64_t min, std::int64_t max);
std::optional<bool> truth(const toml::table& table, std::string_view key);
std::optional<std::string> text(const toml::table& table, std::string_view key);
std::optional<Vector3<double>> vector(const toml::table& table, std::string_view key, std::string_view unit);

// The table [key], or null.
const toml::table* subtable(const toml::table& table, std::string_view key);

// The tables [[key]]; where there is the key, there is at least one.
std::vector<const toml::table*> subtables(const toml::table& table, std::string_view key);

}  // namespace lockstep
