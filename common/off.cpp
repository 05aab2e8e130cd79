// OFF in text: the word OFF, how many points, faces and edges there are, the points, and the faces, each of which says
// how many corners it has.
#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "common/input_error.h"
#include "common/input_file.h"
#include "common/memory.h"
#include "common/mesh_file.h"
#include "common/polygons.h"
#include "common/words.h"

namespace lockstep {

Mesh read_off(const std::string& path) {
  std::ifstream in = open_input(path);
  require_memory(mesh_bytes_per_byte * static_cast<double>(std::filesystem::file_size(path)), path + ": reading it");
  int number = 0;
  const auto at = [&](int line) { return path + ':' + std::to_string(line); };
  std::string line;
  // Of the next line that is neither blank nor a comment; they last until the one after.
  const auto next = [&](const std::string& expected) {
    while (std::getline(in, line)) {
      ++number;
      if (std::vector<std::string_view> words = words_of(line); !words.empty()) return words;
    }
    throw InputError(path + ": ends before " + expected);
  };

  std::vector<std::string_view> words = next("OFF");
  constexpr std::array<std::string_view, 4> headers = {"OFF", "COFF", "NOFF", "CNOFF"};
  if (std::ranges::find(headers, words[0]) == headers.end())
    throw InputError(at(number) + ": expected OFF, COFF, NOFF or CNOFF");
  words.erase(words.begin());  // the counts may stand in the first line, too
  if (words.empty()) words = next("the numbers of points and faces");
  const auto count = [&](std::size_t k) { return words.size() > k ? as<std::int64_t>(words[k]).value_or(-1) : -1; };
  const std::int64_t points = count(0), faces = count(1);
  if (points < 0 || faces < 0) throw InputError(at(number) + ": expected the numbers of points and faces");

  Polygons polygons(path, [&](int line, bool is_face) { return at(line) + (is_face ? ": face" : ": point"); });
  for (std::int64_t i = 1; i <= points; ++i) {
    words = next("point " + std::to_string(i) + " of " + std::to_string(points));
    polygons.add_point(number, as_point(words));
  }
  std::vector<std::int64_t> face;
  for (std::int64_t i = 1; i <= faces; ++i) {
    words = next("face " + std::to_string(i) + " of " + std::to_string(faces));
    const std::int64_t corners = count(0);
    if (corners < 0 || corners >= static_cast<std::int64_t>(words.size()))
      throw InputError(at(number) + ": face: expected the number of its points, and the points");
    face.clear();
    for (const std::string_view word : std::span(words).subspan(1, corners)) {
      const std::int64_t point = as<std::int64_t>(word).value_or(-1);
      if (point < 0 || point >= points)
        throw InputError(at(number) + ": face: " + legible(word) + " is no point, expected a number from 0 to " +
                         std::to_string(points - 1));
      face.push_back(point + 1);
    }
    polygons.add_face(number, face);
  }
  return std::move(polygons).mesh();
}

}  // namespace lockstep
