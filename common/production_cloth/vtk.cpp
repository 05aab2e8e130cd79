#include "common/production_cloth/vtk.h"

#include "common/cloth/vtk.h"
#include "common/convert.h"
#include "common/spatial/bounds.h"
#include "common/vtk.h"

namespace lockstep::production_cloth {

void write_vtk(const std::string& path, const Topology& topology, const Motion<float>& motion) {
  const auto add_all = [&](const Vectors<float>& vectors) {
    return [&](vtk::Words& words) {
      for (int i = 0; i < topology.vertices; ++i) words.add(load(vectors, i));
    };
  };
  const auto count = static_cast<std::int64_t>(topology.triangles.size());
  vtk::write(path, {.title = "Lockstep production cloth",
                    .points = topology.vertices,
                    .positions = add_all(motion.position),
                    .polygons = {count, 3 * count,
                                 [&](vtk::Words& words) {
                                   for (const auto& [a, b, c] : topology.triangles)
                                     for (const std::int32_t word : {3, a, b, c}) words.add(word);
                                 }},
                    .point_data = {{"velocity", vtk::Type::vectors, add_all(motion.velocity)}}});
}

void write_obstacles(const std::string& path, const std::vector<Body>& bodies, double time,
                     const Vectors<float>& position, int vertices) {
  const MovedBodies<float> moved = move_bodies(bodies, time, time, 0);
  cloth::Bodies<float> shapes;
  for (const auto& body : moved.planes) shapes.planes.push_back(body.shape);
  for (const auto& body : moved.capsules) shapes.capsules.push_back(body.shape);
  for (const auto& body : moved.boxes) shapes.boxes.push_back(body.shape);
  spatial::Box<float> extent = spatial::empty_box<float>;
  for (int i = 0; i < vertices; ++i) {
    const Vector3<float> p = load(position, i);
    extent = spatial::around(extent, {p, p});
  }
  Surfaces surfaces = cloth::surfaces_of(shapes, extent.low, extent.high);
  for (const auto& body : moved.level_sets) {
    const LevelSet<float>& shape = body.shape;
    const Vector3<double> first = shape.solid->grid.position(0, 0, 0);
    const auto base = static_cast<std::int32_t>(surfaces.points.size());
    for (const Vector3<double>& p : shape.solid->mesh.points)
      surfaces.add_point(shape.origin + shape.turn * convert<float>(p - first));
    for (const Triangle& t : shape.solid->mesh.triangles) {
      const std::int32_t corners[] = {base + t.a, base + t.b, base + t.c};
      surfaces.add_polygon(corners);
    }
  }
  cloth::write_surfaces(path, surfaces);
}

}  // namespace lockstep::production_cloth
