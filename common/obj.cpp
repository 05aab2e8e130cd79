#include "common/obj.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <numeric>
#include <optional>
#include <span>
#include <sstream>
#include <utility>
#include <vector>

#include "common/input_error.h"
#include "common/input_file.h"
#include "common/memory.h"

namespace lockstep {
namespace {

// Bytes of memory that reading may take per byte of the file. Files of nothing but the shortest polygons took 16.
constexpr double bytes_per_byte = 25;

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

// --- Lines of the file

struct Face {
  int line;
  std::size_t first_corner;
};

struct Lines {
  std::vector<Vector3<double>> points;
  std::vector<Face> faces;
  std::vector<std::int32_t> corners;  // of one face after another, points counted from 0

  std::span<const std::int32_t> corners_of(std::size_t face) const {
    const std::size_t begin = faces[face].first_corner;
    const std::size_t end = face + 1 < faces.size() ? faces[face + 1].first_corner : corners.size();
    return {corners.data() + begin, end - begin};
  }
};

[[noreturn]] void refuse(const std::string& path, int line, const std::string& message) {
  throw InputError(path + ':' + std::to_string(line) + ": " + message);
}

Lines read_lines(const std::string& path) {
  std::ifstream in = open_input(path);
  require_memory(bytes_per_byte * static_cast<double>(std::filesystem::file_size(path)), path + ": reading it");
  Lines lines;
  std::int64_t greatest = 0;  // of all corners, points counted from 1
  int number = 0, line_of_greatest = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    std::istringstream words(line);
    std::string keyword, word;
    words >> keyword;
    if (keyword == "v") {
      double xyz[3];
      for (double& coordinate : xyz) {
        word.clear();
        words >> word;
        const std::optional<double> x = as<double>(word);
        if (!x || !(std::abs(*x) <= largest)) refuse(path, number, "v: expected three numbers from -1e9 to 1e9, in m");
        coordinate = *x;
      }
      lines.points.push_back({xyz[0], xyz[1], xyz[2]});
    } else if (keyword == "f") {
      const auto points = static_cast<std::int64_t>(lines.points.size());
      const std::size_t first = lines.corners.size();
      lines.faces.push_back({number, first});
      while (words >> word) {
        const std::int64_t index = as<std::int64_t>(std::string_view(word).substr(0, word.find('/'))).value_or(0);
        const std::int64_t corner = index < 0 ? points + 1 + index : index;
        if (corner <= 0)
          refuse(path, number,
                 "f: " + legible(word) +
                     " is no point, expected a number from 1, or from -1 downwards, back from the last");
        if (corner > greatest) greatest = corner, line_of_greatest = number;
        const auto i = static_cast<std::int32_t>(corner - 1);  // one that is out of range is refused below
        if (std::find(lines.corners.begin() + first, lines.corners.end(), i) != lines.corners.end())
          refuse(path, number, "f: point " + std::to_string(corner) + " comes twice");
        lines.corners.push_back(i);
        if (lines.corners.size() - first > most_corners)
          refuse(path, number, "f: more than " + std::to_string(most_corners) + " points");
      }
      if (lines.corners.size() - first < 3) refuse(path, number, "f: expected at least three points");
    }
  }
  if (in.bad()) throw InputError(path + ": cannot be read to its end");
  const std::size_t points = lines.points.size();
  if (static_cast<std::size_t>(greatest) > points)  // asked at the end, for faces may come before their points
    refuse(path, line_of_greatest, "f: point " + std::to_string(greatest) + " of " + std::to_string(points));
  return lines;
}

// --- Triangles

struct Point2 {
  double x, y;
  bool operator==(const Point2&) const = default;
};

// Twice the area, > 0 where a, b, c go round counterclockwise.
double area(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// The polygon seen along the axis in which it is largest, from the side from which it goes round counterclockwise.
std::vector<Point2> flattened(std::span<const std::int32_t> corners, const std::vector<Vector3<double>>& points) {
  Vector3<double> normal{0, 0, 0};
  const Vector3<double>& origin = points[corners[0]];
  for (std::size_t k = 1; k + 1 < corners.size(); ++k)
    normal = normal + cross(points[corners[k]] - origin, points[corners[k + 1]] - origin);
  const double x = std::abs(normal.x), y = std::abs(normal.y), z = std::abs(normal.z);
  std::vector<Point2> flat;
  for (const std::int32_t i : corners) {
    const Vector3<double>& p = points[i];
    Point2 q = z >= x && z >= y ? Point2{p.x, p.y} : y >= x ? Point2{p.z, p.x} : Point2{p.y, p.z};
    const double towards = z >= x && z >= y ? normal.z : y >= x ? normal.y : normal.x;
    if (towards < 0) std::swap(q.x, q.y);
    flat.push_back(q);
  }
  return flat;
}

// Cuts off one ear after another: a corner between its neighbours, with no other corner in the triangle of the three.
// Convex polygons become fans from their first corner. False where no ear is left: a loop, or an area of zero.
bool cut(std::span<const std::int32_t> corners, const std::vector<Vector3<double>>& points,
         std::vector<Triangle>& triangles) {
  const std::vector<Point2> flat = flattened(corners, points);
  std::vector<int> left(corners.size());
  std::iota(left.begin(), left.end(), 0);
  const auto is_ear = [&](int a, int b, int c) {
    const Point2 &pa = flat[a], &pb = flat[b], &pc = flat[c];
    return area(pa, pb, pc) > 0 && std::ranges::none_of(left, [&](int i) {
             const Point2& p = flat[i];
             return p != pa && p != pb && p != pc && area(pa, pb, p) >= 0 && area(pb, pc, p) >= 0 &&
                    area(pc, pa, p) >= 0;
           });
  };
  while (left.size() >= 3) {
    const std::size_t n = left.size();
    std::size_t ear = 0;
    while (ear < n && !is_ear(left[ear], left[(ear + 1) % n], left[(ear + 2) % n])) ++ear;
    if (ear == n) return false;
    triangles.push_back({corners[left[ear]], corners[left[(ear + 1) % n]], corners[left[(ear + 2) % n]]});
    left.erase(left.begin() + (ear + 1) % n);
  }
  return true;
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
    throw InputError(path + ": triangle " + std::to_string(twice[1].second) + " is triangle " +
                     std::to_string(twice[0].second) + " again");
  const auto unused = std::ranges::find(used, false);
  if (unused != used.end())
    throw InputError(path + ": point " + std::to_string(unused - used.begin() + 1) +
                     " is in no triangle; is the file whole?");
}

}  // namespace

Mesh read_obj(const std::string& path) {
  Lines lines = read_lines(path);
  Mesh mesh;
  for (std::size_t face = 0; face < lines.faces.size(); ++face) {
    const std::span<const std::int32_t> c = lines.corners_of(face);
    if (c.size() == 3)
      mesh.triangles.push_back({c[0], c[1], c[2]});
    else if (!cut(c, lines.points, mesh.triangles))
      refuse(path, lines.faces[face].line, "f: cannot be cut into triangles, expected a flat polygon without loops");
  }
  if (mesh.triangles.empty()) throw InputError(path + ": no triangle in it");
  mesh.points = std::move(lines.points);
  check_triangles(mesh, path);
  return mesh;
}

}  // namespace lockstep
