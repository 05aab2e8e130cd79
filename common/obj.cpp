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
#include <map>
#include <optional>
#include <sstream>
#include <utility>
#include <vector>

#include "common/input_error.h"
#include "common/input_file.h"
#include "common/memory.h"

namespace lockstep {
namespace {

// What reading may take, by the size of the file. Files of nothing but the shortest polygons took 37.
constexpr double bytes_per_byte = 50;

constexpr double largest = 1e9;  // m: of a coordinate; its square is far from the end of float

constexpr std::size_t most_corners = 255;  // of a polygon: time to cut it goes with their cube

// The whole word as a number.
template <class Number>
std::optional<Number> as(std::string_view word) {
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  Number x;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), x);
  return error == std::errc() && end == word.data() + word.size() ? std::optional(x) : std::nullopt;
}

// As many as the number needs.
std::string digits_of(double x) {
  char digits[32];
  return {digits, std::to_chars(digits, std::end(digits), x).ptr};
}

// Whatever the file is like, for tinyobjloader.
struct CheckedLines {
  std::stringstream text;               // `v x y z` and `f a b c ...`, points numbered from 1; `s` with its line before a polygon
  std::vector<Vector3<double>> points;  // exact, as tinyobjloader's numbers are not
  std::map<unsigned, std::size_t> polygon_triangles;  // by the line of a polygon: how many it is to be cut into
};

CheckedLines checked_lines(const std::string& path) {
  std::ifstream in = open_input(path);
  require_memory(bytes_per_byte * static_cast<double>(std::filesystem::file_size(path)), path + ": reading it");
  CheckedLines checked;
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
      double xyz[3];
      checked.text << 'v';
      for (double& coordinate : xyz) {
        word.clear();
        words >> word;
        const std::optional<double> x = as<double>(word);
        if (!x || !(std::abs(*x) <= largest)) refuse(number, "v: expected three numbers from -1e9 to 1e9, in m");
        coordinate = *x;
        checked.text << ' ' << digits_of(*x);
      }
      checked.text << '\n';
      checked.points.push_back({xyz[0], xyz[1], xyz[2]});
    } else if (keyword == "f") {
      std::vector<std::int64_t> corners;
      while (words >> word) {
        const std::int64_t index = as<std::int64_t>(std::string_view(word).substr(0, word.find('/'))).value_or(0);
        const std::int64_t corner = index < 0 ? points + 1 + index : index;
        if (corner <= 0)
          refuse(number, "f: " + legible(word) + " is no point, expected a number from 1, or from -1 downwards, back from the last");
        if (std::ranges::find(corners, corner) != corners.end()) refuse(number, "f: point " + std::to_string(corner) + " comes twice");
        if (corner > greatest) greatest = corner, line_of_greatest = number;
        corners.push_back(corner);
        if (corners.size() > most_corners) refuse(number, "f: more than " + std::to_string(most_corners) + " points");
      }
      if (corners.size() < 3) refuse(number, "f: expected at least three points");
      const bool is_polygon = corners.size() > 3;
      if (is_polygon) checked.text << "s " << number << '\n', checked.polygon_triangles[number] = corners.size() - 2;
      checked.text << 'f';
      for (const std::int64_t corner : corners) checked.text << ' ' << corner;
      checked.text << '\n';
      if (is_polygon) checked.text << "s 0\n";
    }
  }
  if (in.bad()) throw InputError(path + ": cannot be read to its end");
  if (greatest > points)  // asked at the end, for faces may come before their points
    refuse(line_of_greatest, "f: point " + std::to_string(greatest) + " of " + std::to_string(points));
  return checked;
}

// tinyobjloader gives up on a polygon, and goes on, where it finds no more corner to cut off.
void check_polygons(std::map<unsigned, std::size_t> missing, const tinyobj::mesh_t& mesh, const std::string& path) {
  for (const unsigned line : mesh.smoothing_group_ids)
    if (line != 0) --missing[line];
  for (const auto& [line, triangles] : missing)
    if (triangles != 0)
      throw InputError(path + ':' + std::to_string(line) + ": f: cannot be cut into triangles, expected a flat polygon without loops");
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
  CheckedLines lines = checked_lines(path);
  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
  std::string warning, error;
  const bool triangulate = true;
  tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, &lines.text, nullptr, triangulate);
  if (shapes.empty()) shapes.emplace_back();  // of nothing; never more than one, for no line that begins another was passed on
  const tinyobj::mesh_t& shape = shapes[0].mesh;
  check_polygons(std::move(lines.polygon_triangles), shape, path);
  if (shape.indices.empty()) throw InputError(path + ": no triangle in it");
  Mesh mesh{.points = std::move(lines.points), .triangles = {}};
  const std::vector<tinyobj::index_t>& corner = shape.indices;
  for (std::size_t k = 0; k < corner.size(); k += 3)
    mesh.triangles.push_back({corner[k].vertex_index, corner[k + 1].vertex_index, corner[k + 2].vertex_index});
  check_triangles(mesh, path);
  return mesh;
}

}  // namespace lockstep
