// Text files of words between blanks.
#pragma once

#include <algorithm>
#include <charconv>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "common/vector3.h"

namespace lockstep {

// The whole word as a number.
template <class Number>
std::optional<Number> as(std::string_view word) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  Number x;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), x);
  return error == std::errc() && end == word.data() + word.size() ? std::optional(x) : std::nullopt;
}

// The words of a line, up to a comment that begins with `#`.
inline std::vector<std::string_view> words_of(std::string_view line) {
  constexpr std::string_view blanks = " \t\r\v\f";
  line = line.substr(0, line.find('#'));
  std::vector<std::string_view> words;
  for (std::size_t at = 0; (at = line.find_first_not_of(blanks, at)) != line.npos;) {
    const std::size_t end = std::min(line.find_first_of(blanks, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

// The first three words as a point; nothing unless they are numbers.
inline std::optional<Vector3<double>> as_point(std::span<const std::string_view> words) {
  if (words.size() < 3) return std::nullopt;
  const std::optional<double> x = as<double>(words[0]), y = as<double>(words[1]), z = as<double>(words[2]);
  return x && y && z ? std::optional(Vector3<double>{*x, *y, *z}) : std::nullopt;
}

}  // namespace lockstep
