// Polygons as the readers of mesh files find them (common/mesh_file.h).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/input_error.h"
#include "common/mesh.h"

namespace lockstep {

// Points and faces in the order of the file. A place is what the reader counts, such as lines. All throw InputError
// where common/mesh_file.h says that a mesh is refused.
class Polygons {
 public:
  // `at` opens a message about a point or a face: where it is, and how the format calls it.
  using At = std::function<std::string(int place, bool is_face)>;
  Polygons(std::string path, At at) : path(std::move(path)), at(std::move(at)) {}

  // Nothing where the file has no three numbers.
  void add_point(int place, const std::optional<Vector3<double>>& point);

  // `face` are points, counted from 1, which may come later.
  void add_face(int place, std::span<const std::int64_t> face);

  // Cuts polygons into triangles, convex ones into fans from their first corner.
  Mesh mesh() &&;

 private:
  struct Face {
    int place;
    std::size_t first_corner;
  };

  [[noreturn]] void refuse_face(int place, const std::string& message) const {
    throw InputError(at(place, true) + ": " + message);
  }

  std::string path;
  At at;
  std::vector<Vector3<double>> points;
  std::vector<Face> faces;
  std::vector<std::int32_t> corners;  // of one face after another, points counted from 0
  std::int64_t greatest = 0;          // of all corners, counted from 1
  int place_of_greatest = 0;
};

}  // namespace lockstep
