#include "common/production_cloth/vtk.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/surfaces.h"
#include "common/vtk.h"

namespace lockstep::production_cloth {

void write_vtk(const std::string& path, const Topology& topology, const Motion<float>& motion) {
  const auto add = [&](const Vectors<float>& of) {
    return [&](vtk::Words& words) {
      for (int i = 0; i < topology.vertices; ++i) words.add(load(of, i));
    };
  };
  const auto triangles = static_cast<std::int64_t>(topology.triangles.size());
  vtk::write(path, {.title = "Lockstep production cloth",
                    .points = topology.vertices,
                    .positions = add(motion.position),
                    .polygons = {triangles, 3 * triangles,
                                 [&](vtk::Words& words) {
                                   for (const auto& [a, b, c] : topology.triangles)
                                     for (const std::int32_t word : {3, a, b, c}) words.add(word);
                                 }},
                    .point_data = {{"velocity", vtk::Type::vectors, add(motion.velocity)}}});
}

void write_obstacles(const std::string& path, const std::vector<Body>& bodies, double time,
                     const Vectors<float>& positions, int vertices) {
  constexpr int sides = 48;
  constexpr float infinity = std::numeric_limits<float>::infinity();
  const MovedBodies<float> at = move_bodies(bodies, time, time, 0);
  Surfaces surfaces;
  for (const auto& [capsule, friction, turn, shift] : at.capsules) {
    const Vector3<float> segment = capsule.to - capsule.from;
    const float length = std::sqrt(dot(segment, segment));
    const Vector3<float> along = length > 0 ? (1 / length) * segment : Vector3<float>{0, 1, 0};
    add_capsule(surfaces, axes_along(along, .5f * (capsule.from + capsule.to)), .5f * length, capsule.radius, sides);
  }
  for (const auto& [box, friction, turn, shift] : at.boxes)
    add_box(surfaces, {box.centre, box.axis[0], box.axis[1], box.axis[2]}, box.half);
  Vector3<float> low{infinity, infinity, infinity}, high = -low;
  for (int i = 0; i < vertices; ++i) {
    const Vector3<float> p = load(positions, i);
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  for (const auto& [plane, friction, turn, shift] : at.planes)
    add_plane(surfaces, plane.normal, plane.offset * plane.normal, low, high);
  vtk::write(path, {.title = "Lockstep obstacles of a production cloth",
                    .points = static_cast<std::int64_t>(surfaces.points.size()),
                    .positions = vtk::each(surfaces.points),
                    .polygons = {surfaces.count, static_cast<std::int64_t>(surfaces.polygons.size()) - surfaces.count,
                                 vtk::each(surfaces.polygons)}});
}

}  // namespace lockstep::production_cloth
