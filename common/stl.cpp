// STL: triangles by the coordinates of their corners. In text, or in binary: 80 bytes of anything, uint32 n, then n
// records of 50 bytes, little-endian: a normal and three corners of three float32 each, and two bytes more.
#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
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
namespace {

constexpr std::uintmax_t header_bytes = 84, record_bytes = 50;

// Gives each place in space one number.
class Welder {
 public:
  explicit Welder(Polygons& polygons) : polygons_(polygons) {}

  // The point there, which is added if it is new.
  std::int64_t point(int place, const std::optional<Vector3<double>>& p) {
    if (!p || p->x != p->x || p->y != p->y || p->z != p->z) polygons_.add_point(place, std::nullopt);
    const auto [found, is_new] =
        numbers_.try_emplace({p->x, p->y, p->z}, static_cast<std::int64_t>(numbers_.size()) + 1);
    if (is_new) polygons_.add_point(place, p);
    return found->second;
  }

 private:
  Polygons& polygons_;
  std::map<std::array<double, 3>, std::int64_t> numbers_;
};

Mesh read_binary(std::ifstream& in, const std::string& path) {
  Polygons polygons(path, [&](int triangle, bool) { return path + ": triangle " + std::to_string(triangle); });
  Welder welder(polygons);
  in.seekg(header_bytes);
  int triangle = 0;
  for (char record[record_bytes]; in.read(record, record_bytes);) {
    ++triangle;
    std::array<std::int64_t, 3> corners;
    for (int corner = 0; corner < 3; ++corner) {
      float xyz[3];
      std::memcpy(xyz, record + 12 * (corner + 1), sizeof xyz);
      corners[corner] = welder.point(triangle, Vector3<double>{xyz[0], xyz[1], xyz[2]});
    }
    polygons.add_face(triangle, corners);
  }
  return std::move(polygons).mesh();
}

Mesh read_text(std::ifstream& in, const std::string& path) {
  const auto at = [&](int line) { return path + ':' + std::to_string(line); };
  Polygons polygons(path, [&](int line, bool is_face) { return at(line) + (is_face ? ": loop" : ": vertex"); });
  Welder welder(polygons);
  int number = 0;
  bool is_open = false;  // between solid and endsolid
  std::vector<std::int64_t> corners;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const std::vector<std::string_view> words = words_of(line);
    if (words.empty() || words[0] == "facet" || words[0] == "endfacet") continue;
    if (words[0] == "solid" || words[0] == "endsolid") {
      is_open = words[0] == "solid";
    } else if (words[0] == "outer") {
      corners.clear();
    } else if (words[0] == "vertex") {
      corners.push_back(welder.point(number, as_point(std::span(words).subspan(1))));
    } else if (words[0] == "endloop") {
      polygons.add_face(number, corners);
    } else {
      throw InputError(at(number) + ": expected solid, facet, outer, vertex, endloop, endfacet or endsolid, not " +
                       legible(words[0]));
    }
  }
  if (is_open) throw InputError(path + ": ends before endsolid");
  return std::move(polygons).mesh();
}

}  // namespace

Mesh read_stl(const std::string& path) {
  std::ifstream in = open_input(path);
  const std::uintmax_t bytes = std::filesystem::file_size(path);
  require_memory(mesh_bytes_per_byte * static_cast<double>(bytes), path + ": reading it");
  // Files in binary, too, may begin with the word "solid": their size tells them apart.
  char header[header_bytes] = {};
  in.read(header, header_bytes);
  in.clear();
  std::uint32_t triangles;
  std::memcpy(&triangles, header + 80, sizeof triangles);
  const std::uintmax_t expected = header_bytes + record_bytes * triangles;
  if (bytes == expected) return read_binary(in, path);
  const std::string_view first(header, header_bytes);
  if (!first.starts_with("solid") || first.find('\0') != first.npos)
    throw InputError(path + ": " + std::to_string(bytes) + " bytes, expected " + std::to_string(expected) +
                     " bytes for the " + std::to_string(triangles) +
                     " triangles that its header announces, or text that begins with solid");
  in.seekg(0);
  return read_text(in, path);
}

}  // namespace lockstep
