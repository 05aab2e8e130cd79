#include "common/rigid/vtk.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/surfaces.h"
#include "common/vtk.h"

namespace lockstep::rigid {
namespace {

using Vector = Vector3<float>;

Kind kind_of(const World<float>& world, int collider) { return static_cast<Kind>(world.colliders.kind[collider]); }

bool belongs_to(Part part, const World<float>& world, int collider) {
  if (kind_of(world, collider) == Kind::plane) return part == Part::planes;
  return part == (world.bodies.inverse_mass[world.colliders.body[collider]].w > 0 ? Part::moving : Part::fixed);
}

Axes axes_of(const World<float>& world, int collider) {
  const Pose<float>&body = world.bodies.pose[world.colliders.body[collider]], &local = world.colliders.local[collider];
  const Matrix3<float> turn = matrix_of(body.orientation * local.orientation);
  return {body.position + matrix_of(body.orientation) * local.position, turn.x, turn.y, turn.z};
}

void add_faces(Surfaces& to, const World<float>& world, int collider) {
  const Hulls<float>& hulls = world.hulls;
  const Axes axes = axes_of(world, collider);
  const int hull = world.colliders.hull[collider];
  const Quad<float>& scale = world.colliders.size[collider];
  const int first_point = static_cast<int>(to.points.size());
  for (int i = hulls.first_vertex[hull]; i < hulls.first_vertex[hull + 1]; ++i) {
    const Quad<float>& v = hulls.vertex[i];
    to.add_point(axes({scale.x * v.x, scale.y * v.y, scale.z * v.z}));
  }
  const bool one_side = kind_of(world, collider) == Kind::triangle;
  const int end = one_side ? hulls.first_face[hull] + 1 : hulls.first_face[hull + 1];
  for (int face = hulls.first_face[hull]; face < end; ++face) {
    std::vector<int> corners(hulls.corner.begin() + hulls.first_corner[face],
                             hulls.corner.begin() + hulls.first_corner[face + 1]);
    for (int& corner : corners) corner += first_point;
    to.add_polygon(corners);
  }
}

// The plane reaches beyond the middles of all other colliders.
void add_ground(Surfaces& to, const World<float>& world, int collider) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  Vector low{infinity, infinity, infinity}, high = -low;
  for (int i = 0; i < world.colliders.count; ++i) {
    if (kind_of(world, i) == Kind::plane) continue;
    const Vector p = axes_of(world, i).origin;
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Axes axes = axes_of(world, collider);
  add_plane(to, axes.y, axes.origin, low, high);
}

void add_collider(Surfaces& to, const World<float>& world, int collider) {
  constexpr int sides = 8;
  const Quad<float>& size = world.colliders.size[collider];
  switch (kind_of(world, collider)) {
    case Kind::sphere:
    case Kind::capsule: return add_capsule(to, axes_of(world, collider), size.y, size.w, sides);
    case Kind::plane: return add_ground(to, world, collider);
    default: return add_faces(to, world, collider);
  }
}

}  // namespace

bool has(const World<float>& world, Part part) {
  for (int i = 0; i < world.colliders.count; ++i)
    if (belongs_to(part, world, i)) return true;
  return false;
}

void write_surfaces(const std::string& path, const World<float>& world, Part part) {
  Surfaces surfaces;
  std::vector<std::int32_t> bodies;  // [polygon]
  std::vector<float> speeds;         // [polygon]
  for (int i = 0; i < world.colliders.count; ++i) {
    if (!belongs_to(part, world, i)) continue;
    add_collider(surfaces, world, i);
    const int body = world.colliders.body[i];
    const Vector& v = world.bodies.motion[body].velocity;
    bodies.resize(surfaces.count, body);
    speeds.resize(surfaces.count, std::sqrt(dot(v, v)));
  }
  const auto corners = static_cast<std::int64_t>(surfaces.polygons.size()) - surfaces.count;
  vtk::write(path, {.title = "Lockstep rigid bodies",
                    .points = static_cast<std::int64_t>(surfaces.points.size()),
                    .positions = vtk::each(surfaces.points),
                    .polygons = {surfaces.count, corners, vtk::each(surfaces.polygons)},
                    .cell_data = {{"body", vtk::Type::ints, vtk::each(bodies)},
                                  {"speed", vtk::Type::floats, vtk::each(speeds)}}});
}

void write_bodies(const std::string& path, const World<float>& world) {
  const Bodies<float>& bodies = world.bodies;
  std::vector<std::int32_t> kinds(bodies.count, -1);
  for (int i = 0; i < world.colliders.count; ++i) {
    std::int32_t& kind = kinds[world.colliders.body[i]];
    const std::int32_t own = world.colliders.kind[i];
    kind = kind == -1 || (kind == own && kind_of(world, i) == Kind::triangle) ? own : rigid::kinds;
  }
  const auto each_body = [&](auto add) {
    return [&bodies, add](vtk::Words& words) {
      for (int i = 0; i < bodies.count; ++i) add(words, i);
    };
  };
  const auto add_orientation = [&](vtk::Words& words, int i) {
    const auto& [x, y, z, w] = bodies.pose[i].orientation;
    for (const float number : {w, x, y, z}) words.add(number);
  };
  const auto add_mass = [&](vtk::Words& words, int i) {
    const float inverse = bodies.inverse_mass[i].w;
    words.add(inverse > 0 ? 1 / inverse : 0.f);
  };
  using enum vtk::Type;
  vtk::write(path, {.title = "Lockstep rigid bodies",
                    .points = bodies.count,
                    .positions = each_body([&](vtk::Words& words, int i) { words.add(bodies.pose[i].position); }),
                    .vertices = {bodies.count, bodies.count,
                                 each_body([](vtk::Words& words, int i) { words.add(1), words.add(i); })},
                    .point_data = {{"orientation_wxyz", quaternions, each_body(add_orientation)},
                                   {"velocity", vectors,
                                    each_body([&](vtk::Words& words, int i) { words.add(bodies.motion[i].velocity); })},
                                   {"angular_velocity", vectors, each_body([&](vtk::Words& words, int i) {
                                      words.add(bodies.motion[i].angular_velocity);
                                    })},
                                   {"mass", floats, each_body(add_mass)},
                                   {"kind", ints, vtk::each(kinds)},
                                   {"body", ints, each_body([](vtk::Words& words, int i) { words.add(i); })}}});
}

}  // namespace lockstep::rigid
