// tinyobjloader takes any word for the number 0 and passes over faces that it cannot use. So it is given only lines that were
// checked, and is left to do what is hard: cutting polygons into triangles.
#define TINYOBJLOADER_IMPLEMENTATION  // in this file; its shared library then is not needed
#define TINYOBJLOADER_USE_DOUBLE
#include "common/obj.h"

#include <tiny_obj_loader.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <sstream>
#include <utility>

#include "common/input_error.h"
#include "common/input_file.h"
#include "common/memory.h"

namespace lockstep {
namespace {

// What reading may take, by the size of the file. Files of nothing but the shortest faces took 30.
constexpr double bytes_per_byte = 50;

constexpr double largest = 1e9;  // m: of a coordinate; its square is far from the end of float

// The whole word as a number.
template <class Number>
std::optional<Number> as(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  Number x;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), x);
  return error == std::errc() && end == word.data() + word.size() ? std::optional(x) : std::nullopt;
}

// The lines `v x y z` and `f a b c ...` of the file, in this form, points numbered from 1.
std::stringstream checked_lines(const std::string& path) {
  std::ifstream in = open_input(path);
  require_memory(bytes_per_byte * static_cast<double>(std::filesystem::file_size(path)), path + ": reading it");
  std::stringstream checked;
  std::int64_t points = 0, greatest = 0;
  int number = 0, line_of_greatest = 0;
  const auto refuse = [&](int line, const std::string& message) { throw InputError(path + ':' + std::to_string(line) + ": " + message); };
  for (std::string line; std::getline(in, line);) {
    ++number;
    std::istringstream words(line);
    std::string keyword, word;
    words >> keyword;
    if (keyword == "v") {
      ++points;
      checked << 'v';
      for (int axis = 0; axis < 3; ++axis) {
        word.clear();
        words >> word;
        const std::optional<double> x = as<double>(word);
        if (!x || !(std::abs(*x) <= largest)) refuse(number, "v: expected three numbers from -1e9 to 1e9, in m");
        checked << ' ' << word;
      }
      checked << '\n';
    } else if (keyword == "f") {
      std::vector<std::int64_t> corners;
      while (words >> word) {
        const std::int64_t index = as<std::int64_t>(std::string_view(word).substr(0, word.find('/'))).value_or(0);
        const std::int64_t corner = index < 0 ? points + 1 + index : index;
        if (corner <= 0) refuse(number, "f: " + word + " is no point, expected a number from 1, or from -1 downwards, back from the last");
        if (std::ranges::find(corners, corner) != corners.end()) refuse(number, "f: point " + std::to_string(corner) + " comes twice");
        if (corner > greatest) greatest = corner, line_of_greatest = number;
        corners.push_back(corner);
      }
      if (corners.size() < 3) refuse(number, "f: expected at least three points");
      checked << 'f';
      for (const std::int64_t corner : corners) checked << ' ' << corner;
      checked << '\n';
    }
  }
  if (in.bad()) throw InputError(path + ": cannot be read to its end");
  if (greatest > points)  // asked at the end, for faces may come before their points
    refuse(line_of_greatest, "f: point " + std::to_string(greatest) + " of " + std::to_string(points));
  return checked;
}

// No triangle twice, and no point in none.
void check_triangles(const Mesh& mesh, const std::string& path) {
  std::vector<std::pair<std::array<int, 3>, int>> sorted;  // corners in ascending order, and the number of the triangle
  std::vector<char> used(mesh.points.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    std::array<int, 3> corners{a, b, c};
    std::ranges::sort(corners);
    sorted.push_back({corners, static_cast<int>(sorted.size()) + 1});
    for (const int i : corners) used[i] = true;
  }
  std::ranges::sort(sorted);
  const auto twice = std::ranges::adjacent_find(sorted, {}, [](const auto& triangle) { return triangle.first; });
  if (twice != sorted.end())
    throw InputError(path + ": triangle " + std::to_string(twice[1].second) + " is triangle " + std::to_string(twice[0].second) + " again");
  const auto unused = std::ranges::find(used, false);
  if (unused != used.end())
    throw InputError(path + ": point " + std::to_string(unused - used.begin() + 1) + " is in no triangle; is the file whole?");
}

}  // namespace

Mesh read_obj(const std::string& path) {
  std::stringstream lines = checked_lines(path);
  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
  std::string warning, error;
  const bool triangulate = true;
  if (!tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, &lines, nullptr, triangulate) || shapes.empty())
    throw InputError(path + ": no triangle in it");

  Mesh mesh;
  const std::vector<double>& xyz = attributes.vertices;
  for (std::size_t i = 0; i < xyz.size(); i += 3) mesh.points.push_back({xyz[i], xyz[i + 1], xyz[i + 2]});
  for (const tinyobj::shape_t& shape : shapes) {
    const std::vector<tinyobj::index_t>& corner = shape.mesh.indices;
    for (std::size_t k = 0; k < corner.size(); k += 3)
      mesh.triangles.push_back({corner[k].vertex_index, corner[k + 1].vertex_index, corner[k + 2].vertex_index});
  }
  check_triangles(mesh, path);
  return mesh;
}

}  // namespace lockstep
