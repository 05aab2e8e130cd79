// Wavefront OBJ.
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

Mesh read_obj(const std::string& path) {
  std::ifstream in = open_input(path);
  require_memory(mesh_bytes_per_byte * static_cast<double>(std::filesystem::file_size(path)), path + ": reading it");
  const auto at = [&](int line) { return path + ':' + std::to_string(line); };
  Polygons polygons(path, [&](int line, bool is_face) { return at(line) + (is_face ? ": f" : ": v"); });
  std::int64_t points = 0;
  int number = 0;
  std::vector<std::int64_t> face;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const std::vector<std::string_view> words = words_of(line);
    if (words.empty()) continue;
    const std::span values = std::span(words).subspan(1);
    if (words[0] == "v") {
      polygons.add_point(number, as_point(values));
      ++points;
    } else if (words[0] == "f") {
      face.clear();
      for (const std::string_view word : values) {
        const std::int64_t index = as<std::int64_t>(word.substr(0, word.find('/'))).value_or(0);
        face.push_back(index < 0 ? points + 1 + index : index);
        if (face.back() <= 0)
          throw InputError(at(number) + ": f: " + legible(word) +
                           " is no point, expected a number from 1, or from -1 downwards, back from the last");
      }
      polygons.add_face(number, face);
    }
  }
  if (in.bad()) throw InputError(path + ": cannot be read to its end");
  return std::move(polygons).mesh();
}

}  // namespace lockstep
