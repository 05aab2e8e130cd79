#define TOML_IMPLEMENTATION
#include "common/toml.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "common/input_error.h"
#include "common/input_file.h"
#include "common/memory.h"

namespace lockstep {
namespace {

// Bytes of memory that reading may take per byte of the file. Files of nothing but dotted keys, `a.a.a.a`, took 110.
constexpr double bytes_per_byte = 150;

constexpr int most_dots = 15;  // of a key: nested tables are destroyed recursively, and too many exhaust the stack

// The file in ASCII. toml++ 3.3 has undefined behaviour where it looks for spaces among letters beyond ASCII. So such
// letters become question marks in comments and are refused elsewhere.
std::string read_ascii(const std::string& path) {
  std::ifstream in = open_input(path);
  require_memory(bytes_per_byte * static_cast<double>(std::filesystem::file_size(path)), path + ": reading it");
  std::string toml{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) throw InputError(path + ": cannot be read to its end");
  if (toml.starts_with("\xef\xbb\xbf")) toml.erase(0, 3);  // byte order mark

  int line = 1;
  std::size_t line_begin = 0;
  int dots = 0;  // since the last place where a key or a number may begin
  bool in_comment = false;
  std::string_view quote;  // that opened the text around this character; empty outside of text
  const auto is_at = [&](std::size_t i, std::string_view word) {
    return std::string_view(toml).substr(i).starts_with(word);
  };
  const auto refuse_at = [&](std::size_t i, const std::string& message) {
    throw InputError(path + ':' + std::to_string(line) + ':' + std::to_string(i - line_begin + 1) + ": " + message);
  };
  for (std::size_t i = 0; i < toml.size(); ++i) {
    if (toml[i] == '\n') {
      ++line, line_begin = i + 1, in_comment = false, dots = 0;
      if (quote.size() == 1) quote = {};
    } else if (static_cast<unsigned char>(toml[i]) > 127) {
      if (!in_comment) refuse_at(i, "expected ASCII, which all but comments must be in");
      toml[i] = '?';
    } else if (in_comment) {
      continue;
    } else if (quote.empty()) {
      in_comment = toml[i] == '#';
      if (toml[i] == '.' && ++dots > most_dots)
        refuse_at(i, "a key of more than " + std::to_string(most_dots + 1) + " parts");
      if (std::string_view("=,[]{}").find(toml[i]) != std::string_view::npos) dots = 0;
      for (const std::string_view begin : {"\"\"\"", "'''", "\"", "'"})
        if (quote.empty() && is_at(i, begin)) quote = begin;
      if (!quote.empty()) i += quote.size() - 1;
    } else if (quote[0] == '"' && (is_at(i, "\\\"") || is_at(i, "\\\\"))) {
      ++i;
    } else if (is_at(i, quote)) {
      i += quote.size() - 1;
      // Up to two more quotes belong to the text.
      for (int more = 0; more < 2 && quote.size() == 3 && is_at(i + 1, quote.substr(0, 1)); ++more) ++i;
      quote = {};
    }
  }
  return toml;
}

}  // namespace

toml::table parse_toml(const std::string& path) {
  const std::string text = read_ascii(path);
  try {
    return toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    refuse(error.source(), legible(error.description()));
  }
}

std::string position(const toml::source_region& source) {
  return *source.path + ':' + std::to_string(source.begin.line) + ':' + std::to_string(source.begin.column);
}

void refuse(const toml::source_region& source, const std::string& message) {
  throw InputError(position(source) + ": " + message);
}

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
    if (!found) refuse(key.source(), "unknown key " + legible(key.str()) + ", expected one of: " + known);
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
  if (!x || *x < min || *x > max)
    refuse_value(*value, key, "a whole number from " + std::to_string(min) + " to " + std::to_string(max));
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
  const auto is_control = [](unsigned char c) { return c < ' ' || c == 127; };
  if (x->size() > 255 || std::ranges::any_of(*x, is_control))
    refuse_value(*value, key, "at most 255 characters, none of them a control character");
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
