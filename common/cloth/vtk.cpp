#include "common/cloth/vtk.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "common/vtk.h"

namespace lockstep::cloth {
namespace {

// The particles without padding, by index.
std::vector<int> particles_of(const Cloth<float>& cloth) {
  std::vector<int> particles;
  for (int i = 0; i < cloth.count; ++i)
    if (cloth.sheet.rows == 0 || i % cloth.sheet.pitch < cloth.sheet.columns) particles.push_back(i);
  return particles;
}

}  // namespace

void write_vtk(const std::string& path, std::span<const Cloth<float>> cloths) {
  const auto for_each_particle = [&](const auto& f) {
    for (const Cloth<float>& cloth : cloths)
      for (const int i : particles_of(cloth)) f(cloth, i);
  };
  // Calls f(cloth, number), where number[i] is that of particle i in the file.
  const auto for_each_cloth = [&](const auto& f) {
    int count = 0;
    for (const Cloth<float>& cloth : cloths) {
      std::vector<int> number(cloth.count);
      for (const int i : particles_of(cloth)) number[i] = count++;
      f(cloth, number);
    }
  };
  const auto is_rope = [](const Cloth<float>& cloth) { return cloth.triangles.empty(); };

  const auto add_positions = [&](vtk::Words& words) {
    for_each_particle([&](const Cloth<float>& cloth, int i) { words.add(load(cloth.position, i)); });
  };
  const auto add_velocities = [&](vtk::Words& words) {
    for_each_particle([&](const Cloth<float>& cloth, int i) {
      const Vectors<float>&p = cloth.position, &q = cloth.previous;
      const float dt = cloth.model.time_step;
      words.add(Vector3<float>{(p.x[i] - q.x[i]) / dt, (p.y[i] - q.y[i]) / dt, (p.z[i] - q.z[i]) / dt});
    });
  };
  const auto add_triangles = [&](vtk::Words& words) {
    for_each_cloth([&](const Cloth<float>& cloth, const std::vector<int>& number) {
      for (const auto& [a, b, c] : cloth.triangles)
        for (const int word : {3, number[a], number[b], number[c]}) words.add(word);
    });
  };
  const auto add_ropes = [&](vtk::Words& words) {
    for_each_cloth([&](const Cloth<float>& cloth, const std::vector<int>& number) {
      if (!is_rope(cloth)) return;
      const std::vector<int> particles = particles_of(cloth);
      words.add(static_cast<int>(particles.size()));
      for (const int i : particles) words.add(number[i]);
    });
  };
  int count = 0, ropes = 0, of_ropes = 0;
  std::int64_t triangles = 0;
  for (const Cloth<float>& cloth : cloths) {
    const int particles = static_cast<int>(particles_of(cloth).size());
    count += particles, triangles += cloth.triangles.size();
    ropes += is_rope(cloth), of_ropes += is_rope(cloth) ? particles : 0;
  }
  vtk::PolyData data{.title = "Lockstep cloth",
                     .points = count,
                     .positions = add_positions,
                     .point_data = {{"velocity", vtk::Type::vectors, add_velocities}}};
  if (triangles > 0) data.polygons = {triangles, 3 * triangles, add_triangles};
  if (ropes > 0) data.lines = {ropes, of_ropes, add_ropes};
  vtk::write(path, data);
}

void write_obstacles(const std::string& path, std::span<const Cloth<float>> cloths) {
  constexpr float infinity = std::numeric_limits<float>::infinity();
  Vector3<float> low{infinity, infinity, infinity}, high = -low;
  for (const Cloth<float>& cloth : cloths)
    for (const int i : particles_of(cloth)) {
      const Vector3<float> p = load(cloth.position, i);
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
    }
  write_surfaces(path, surfaces_of(cloths[0].bodies, low, high));
}

Surfaces surfaces_of(const Bodies<float>& bodies, const Vector3<float>& low, const Vector3<float>& high) {
  constexpr int sides = 32;
  Surfaces surfaces;
  for (const Capsule<float>& capsule : bodies.capsules) {
    const Vector3<float> segment = capsule.to - capsule.from;
    const float length = std::sqrt(dot(segment, segment));
    const Vector3<float> along = length > 0 ? (1 / length) * segment : Vector3<float>{0, 1, 0};
    add_capsule(surfaces, axes_along(along, .5f * (capsule.from + capsule.to)), .5f * length, capsule.radius, sides);
  }
  for (const Box<float>& box : bodies.boxes)
    add_box(surfaces, {box.centre, box.axis[0], box.axis[1], box.axis[2]}, box.half);
  for (const Plane<float>& plane : bodies.planes)
    add_plane(surfaces, plane.normal, plane.offset * plane.normal, low, high);
  return surfaces;
}

void write_surfaces(const std::string& path, const Surfaces& surfaces) {
  vtk::write(path, {.title = "Lockstep obstacles of a cloth",
                    .points = static_cast<std::int64_t>(surfaces.points.size()),
                    .positions = vtk::each(surfaces.points),
                    .polygons = {surfaces.count, static_cast<std::int64_t>(surfaces.polygons.size()) - surfaces.count,
                                 vtk::each(surfaces.polygons)}});
}

}  // namespace lockstep::cloth
