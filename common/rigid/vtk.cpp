#include "common/rigid/vtk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "common/vtk.h"

namespace lockstep::rigid {
namespace {

using Vector = Vector3<float>;

// What the file will hold, as it grows.
struct Polygons {
  std::vector<Vector> points;
  std::vector<std::int32_t> cells;  // of each the number of its corners, then the corners
  std::vector<std::int32_t> bodies;
  std::vector<float> speeds;

  // The number of the point.
  int add_point(const Vector& p) {
    points.push_back(p);
    return static_cast<int>(points.size()) - 1;
  }
  template <class Corners>
  void add_cell(const Corners& corners, int body, float speed) {
    cells.push_back(static_cast<std::int32_t>(std::size(corners)));
    cells.insert(cells.end(), std::begin(corners), std::end(corners));
    bodies.push_back(body);
    speeds.push_back(speed);
  }
};

// A collider on its way into the file.
struct Placement {
  Vector position;
  Matrix3<float> turn;
  int body;
  float speed;

  Vector operator()(const Vector& p) const { return position + turn * p; }
};

Placement place(const World<float>& world, int collider) {
  const int body = world.colliders.body[collider];
  const Pose<float>&pose = world.bodies.pose[body], &local = world.colliders.local[collider];
  const Vector& v = world.bodies.motion[body].velocity;
  return {pose.position + matrix_of(pose.orientation) * local.position, matrix_of(pose.orientation * local.orientation),
          body, std::sqrt(dot(v, v))};
}

void add_faces(Polygons& out, const World<float>& world, int collider) {
  const Hulls<float>& hulls = world.hulls;
  const Placement placed = place(world, collider);
  const int hull = world.colliders.hull[collider];
  const Quad<float>& scale = world.colliders.size[collider];
  const int first_point = static_cast<int>(out.points.size());
  for (int i = hulls.first_vertex[hull]; i < hulls.first_vertex[hull + 1]; ++i) {
    const Quad<float>& v = hulls.vertex[i];
    out.add_point(placed({scale.x * v.x, scale.y * v.y, scale.z * v.z}));
  }
  const bool one_side = static_cast<Kind>(world.colliders.kind[collider]) == Kind::triangle;
  const int end = one_side ? hulls.first_face[hull] + 1 : hulls.first_face[hull + 1];
  for (int face = hulls.first_face[hull]; face < end; ++face) {
    std::vector<int> corners(hulls.corner.begin() + hulls.first_corner[face],
                             hulls.corner.begin() + hulls.first_corner[face + 1]);
    for (int& corner : corners) corner += first_point;
    out.add_cell(corners, placed.body, placed.speed);
  }
}

// A capsule as rings around y. The two middle rings of a sphere, whose `half` is 0, coincide.
void add_round(Polygons& out, const World<float>& world, int collider) {
  constexpr int sides = 8;
  const Placement placed = place(world, collider);
  const float r = world.colliders.size[collider].w, half = world.colliders.size[collider].y,
              slant = r * std::numbers::sqrt2_v<float> / 2;
  struct Ring {
    float y, radius;
  };
  const Ring rings[] = {{-half - slant, slant}, {-half, r}, {half, r}, {half + slant, slant}};
  const int bottom = out.add_point(placed({0, -half - r, 0}));
  for (const auto& [y, radius] : rings)
    for (int k = 0; k < sides; ++k) {
      const float angle = 2 * std::numbers::pi_v<float> / sides * k;
      out.add_point(placed({radius * std::sin(angle), y, radius * std::cos(angle)}));
    }
  const int top = out.add_point(placed({0, half + r, 0}));
  const auto at = [&](int ring, int k) { return bottom + 1 + ring * sides + k % sides; };
  for (int k = 0; k < sides; ++k) {
    out.add_cell(std::array{bottom, at(0, k + 1), at(0, k)}, placed.body, placed.speed);
    for (const int ring : {0, 1, 2})
      if (half > 0 || ring != 1)
        out.add_cell(std::array{at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)}, placed.body,
                     placed.speed);
    out.add_cell(std::array{at(3, k), at(3, k + 1), top}, placed.body, placed.speed);
  }
}

// A square as large as the box around all bodies but planes, about the foot of the box's middle on the plane.
void add_plane(Polygons& out, const World<float>& world, int collider) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  Vector low{infinity, infinity, infinity}, high = -low;
  for (int i = 0; i < world.colliders.count; ++i) {
    if (static_cast<Kind>(world.colliders.kind[i]) == Kind::plane) continue;
    const Vector p = place(world, i).position;
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Placement placed = place(world, collider);
  const bool alone = !(low.x <= high.x);
  const Vector middle = alone ? placed.position : .5f * (low + high), diagonal = alone ? Vector{0, 0, 0} : high - low;
  const Vector foot = transposed_times(placed.turn, middle - placed.position);
  const float half = 1 + .6f * std::sqrt(dot(diagonal, diagonal));
  const int first = static_cast<int>(out.points.size());
  for (const auto& [x, z] : {std::array{-half, -half}, {-half, half}, {half, half}, {half, -half}})
    out.add_point(placed({foot.x + x, 0, foot.z + z}));
  out.add_cell(std::array{first, first + 1, first + 2, first + 3}, placed.body, placed.speed);
}

}  // namespace

void write_vtk(const std::string& path, const World<float>& world) {
  Polygons polygons;
  for (int i = 0; i < world.colliders.count; ++i) {
    const Kind kind = static_cast<Kind>(world.colliders.kind[i]);
    if (kind == Kind::sphere || kind == Kind::capsule)
      add_round(polygons, world, i);
    else if (kind == Kind::plane)
      add_plane(polygons, world, i);
    else
      add_faces(polygons, world, i);
  }
  const auto cells = static_cast<std::int64_t>(polygons.bodies.size());
  const auto corners = static_cast<std::int64_t>(polygons.cells.size()) - cells;
  vtk::write(path, {.title = "Lockstep rigid bodies",
                    .points = static_cast<std::int64_t>(polygons.points.size()),
                    .positions = vtk::each(polygons.points),
                    .polygons = {cells, corners, vtk::each(polygons.cells)},
                    .cell_data = {{"body", vtk::Type::ints, vtk::each(polygons.bodies)},
                                  {"speed", vtk::Type::floats, vtk::each(polygons.speeds)}}});
}

}  // namespace lockstep::rigid
