#include "common/fluid/vtk.h"

#include <vector>

#include "common/fluid/id_order.h"
#include "common/vtk.h"

namespace lockstep::fluid {

void write_vtk(const std::string& path, const Particles<float>& particles, std::span<const float> density) {
  const std::vector<int> order = id_order(particles);
  const auto in_order = [&](auto value_of) {
    return [&order, value_of](vtk::Words& words) {
      for (const int i : order) words.add(value_of(i));
    };
  };
  const auto vectors = [&](const Vectors<float>& v) {
    return in_order([&v](int i) { return Vector3<float>{v.x[i], v.y[i], v.z[i]}; });
  };
  const auto add_vertices = [&](vtk::Words& words) {
    for (const int i : order) words.add(1), words.add(particles.id[i]);
  };
  vtk::write(path, {.title = "Lockstep fluid",
                    .points = particles.count,
                    .positions = vectors(particles.position),
                    .vertices = {particles.count, particles.count, add_vertices},
                    .point_data = {{"velocity", vtk::Type::vectors, vectors(particles.velocity)},
                                   {"density", vtk::Type::floats, in_order([&](int i) { return density[i]; })},
                                   {"id", vtk::Type::ints, in_order([&](int i) { return particles.id[i]; })}}});
}

void write_box(const std::string& path, const Model<float>& model) {
  std::vector<Vector3<float>> corners;  // 4 z + 2 y + x, from min to max
  for (const float z : {model.domain_min.z, model.domain_max.z})
    for (const float y : {model.domain_min.y, model.domain_max.y})
      for (const float x : {model.domain_min.x, model.domain_max.x}) corners.push_back({x, y, z});
  std::vector<std::int32_t> edges;
  for (int corner = 0; corner < 8; ++corner)
    for (const int axis : {1, 2, 4})
      if (!(corner & axis)) edges.insert(edges.end(), {2, corner, corner | axis});
  vtk::write(path, {.title = "Lockstep box of a fluid",
                    .points = 8,
                    .positions = vtk::each(corners),
                    .lines = {12, 24, vtk::each(edges)}});
}

}  // namespace lockstep::fluid
