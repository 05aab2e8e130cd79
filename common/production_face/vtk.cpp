#include "common/production_face/vtk.h"

#include <algorithm>
#include <cmath>

#include "common/production_face/element.h"
#include "common/vtk.h"

namespace lockstep::production_face {
namespace {

struct Corners {
  Vector3<float> x[4];  // m, deformed
  Vector3<float> u[4];
};

Corners corners_of(const Body<float>& body, const Pose<float>& pose, int t) {
  Corners c;
  for (int a = 0; a < 4; ++a) {
    const int n = body.corner.at(t, a);
    c.u[a] = load(pose.displacement, n), c.x[a] = load(body.rest, n) + c.u[a];
  }
  return c;
}

Vector3<float> stretches(const Body<float>& body, const Corners& c, int t) {
  const auto gradient = [&](int a) {
    return Vector3<float>{body.gradient.at(t, 3 * a), body.gradient.at(t, 3 * a + 1), body.gradient.at(t, 3 * a + 2)};
  };
  return svd(deformation(c.u, {gradient(0), gradient(1), gradient(2)})).s;
}

float quality_of(const Corners& c) {
  const Vector3<float> a = c.x[1] - c.x[0], b = c.x[2] - c.x[0], d = c.x[3] - c.x[0];
  float longest = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) {
      const Vector3<float> edge = c.x[j] - c.x[i];
      longest = std::max(longest, dot(edge, edge));
    }
  return longest > 0 ? std::sqrt(2.f) * dot(a, cross(b, d)) / (longest * std::sqrt(longest)) : 0;
}

float activation_of(const Body<float>& body, const Pose<float>& pose, int t) {
  float most = 0;
  for (int slot = body.first_fibre[t / lanes]; slot < body.first_fibre[t / lanes + 1]; ++slot) {
    const int place = slot * lanes + t % lanes, muscle = body.muscle.at(place, 0);
    if (muscle >= 0) most = std::max(most, pose.activation[muscle] * body.fibre.at(place, 3));
  }
  return most;
}

}  // namespace

void write_vtk(const std::string& path, const Body<float>& body, const Pose<float>& pose) {
  const auto add_nodes = [&](const auto& of_node) {
    return [&body, of_node](vtk::Words& words) {
      for (int n = 0; n < body.nodes; ++n) words.add(of_node(n));
    };
  };
  const auto add_tetrahedra = [&](const auto& of_tetrahedron) {
    return [&body, of_tetrahedron](vtk::Words& words) {
      for (int t = 0; t < body.tetrahedra; ++t) words.add(of_tetrahedron(t));
    };
  };
  const auto displacement = [&](int n) { return load(pose.displacement, n); };
  const auto stretch = [&](int t) { return stretches(body, corners_of(body, pose, t), t).x; };
  const auto volume = [&](int t) {
    const Vector3<float> s = stretches(body, corners_of(body, pose, t), t);
    return s.x * s.y * s.z;
  };
  vtk::write(
      path,
      {.title = "Lockstep face",
       .points = body.nodes,
       .positions = add_nodes([&](int n) { return load(body.rest, n) + load(pose.displacement, n); }),
       .type = vtk::CellType::tetrahedron,
       .cells = {body.tetrahedra, 4 * std::int64_t(body.tetrahedra),
                 [&](vtk::Words& words) {
                   for (int t = 0; t < body.tetrahedra; ++t) {
                     words.add(4);
                     for (int a = 0; a < 4; ++a) words.add(body.corner.at(t, a));
                   }
                 }},
       .point_data = {{"displacement", vtk::Type::vectors, add_nodes(displacement)}},
       .cell_data = {
           {"stretch", vtk::Type::floats, add_tetrahedra(stretch)},
           {"volume", vtk::Type::floats, add_tetrahedra(volume)},
           {"quality", vtk::Type::floats, add_tetrahedra([&](int t) { return quality_of(corners_of(body, pose, t)); })},
           {"activation", vtk::Type::floats, add_tetrahedra([&](int t) { return activation_of(body, pose, t); })},
       }});
}

}  // namespace lockstep::production_face
