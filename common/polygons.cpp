#include "common/polygons.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "common/input_error.h"

namespace lockstep {
namespace {

constexpr double largest = 1e9;  // m: of a coordinate; its square is far from the end of float

bool in_range(double coordinate) { return std::abs(coordinate) <= largest; }  // NaN is not

constexpr std::size_t most_corners = 255;  // of a polygon: time to cut it goes with their cube

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

void Polygons::add_point(int place, const std::optional<Vector3<double>>& point) {
  if (!point || !in_range(point->x) || !in_range(point->y) || !in_range(point->z))
    throw InputError(at(place, false) + ": expected three numbers from -1e9 to 1e9, in m");
  points.push_back(*point);
}

void Polygons::add_face(int place, std::span<const std::int64_t> face) {
  if (face.size() < 3) refuse_face(place, "expected at least three points");
  if (face.size() > most_corners) refuse_face(place, "more than " + std::to_string(most_corners) + " points");
  faces.push_back({place, corners.size()});
  for (std::size_t k = 0; k < face.size(); ++k) {
    if (std::find(face.begin(), face.begin() + k, face[k]) != face.begin() + k)
      refuse_face(place, "point " + std::to_string(face[k]) + " comes twice");
    if (face[k] > greatest) greatest = face[k], place_of_greatest = place;
    corners.push_back(static_cast<std::int32_t>(face[k] - 1));  // one that is out of range is refused in mesh()
  }
}

Mesh Polygons::mesh() && {
  if (greatest > static_cast<std::int64_t>(points.size()))  // asked at the end, for faces may come before their points
    refuse_face(place_of_greatest, "point " + std::to_string(greatest) + " of " + std::to_string(points.size()));
  Mesh mesh;
  for (std::size_t face = 0; face < faces.size(); ++face) {
    const std::size_t end = face + 1 < faces.size() ? faces[face + 1].first_corner : corners.size();
    const std::span<const std::int32_t> c(corners.data() + faces[face].first_corner, corners.data() + end);
    if (c.size() == 3)
      mesh.triangles.push_back({c[0], c[1], c[2]});
    else if (!cut(c, points, mesh.triangles))
      refuse_face(faces[face].place, "cannot be cut into triangles, expected a flat polygon without loops");
  }
  if (mesh.triangles.empty()) throw InputError(path + ": no triangle in it");
  mesh.points = std::move(points);
  check_triangles(mesh, path);
  return mesh;
}

}  // namespace lockstep
