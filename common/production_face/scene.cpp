#include "common/production_face/scene.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "common/memory.h"
#include "common/production_face/make.h"
#include "common/scene_reader.h"

namespace lockstep::production_face {
namespace {

// What a body, what is strained of it and the mesh that it is made of take.
constexpr double bytes_per_tetrahedron = 500;

Mesh read_lattice(const toml::table& scene) {
  const toml::table* lattice = subtable(scene, "lattice");
  check_keys(*lattice, {"cells", "spacing"}, {});
  const Vector3<double> cells = *vector_between(*lattice, "cells", 1, 1000, "");
  const double spacing = *number_between(*lattice, "spacing", 1e-6, 1e6, "m");
  for (const double n : {cells.x, cells.y, cells.z})
    if (n != std::floor(n)) refuse_value(*lattice->get("cells"), "cells", "three whole numbers");
  const double tetrahedra = 12 * cells.x * cells.y * cells.z;
  require_memory(
      bytes_per_tetrahedron * tetrahedra,
      position(lattice->source()) + ": " + std::to_string(static_cast<long long>(tetrahedra)) + " tetrahedra");
  return make_lattice({int(cells.x), int(cells.y), int(cells.z)}, spacing);
}

// A muscle is a capsule: tetrahedra whose centroids are in it have a fibre along its axis.
struct Muscle {
  Vector3<double> from, to;
  double radius, share, activation;
};

Muscle read_muscle(const toml::table& table) {
  check_keys(table, {"from", "to", "radius"}, {"share", "activation"});
  const Muscle muscle = {.from = *vector_between(table, "from", -1e6, 1e6, "m"),
                         .to = *vector_between(table, "to", -1e6, 1e6, "m"),
                         .radius = *number_between(table, "radius", 1e-6, 1e6, "m"),
                         .share = number_between(table, "share", 0, 1, "").value_or(1),
                         .activation = number_between(table, "activation", 0, 1, "").value_or(0)};
  const Vector3<double> axis = muscle.to - muscle.from;
  if (!(dot(axis, axis) > 0)) refuse_value(*table.get("to"), "to", "another point than `from`");
  return muscle;
}

std::vector<Fibre> fibres_of(const Mesh& mesh, const std::vector<Muscle>& muscles) {
  std::vector<Fibre> fibres;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    Vector3<double> centroid = {0, 0, 0};
    for (const std::int32_t corner : mesh.tetrahedra[t]) centroid = centroid + .25 * mesh.nodes[corner];
    for (std::size_t m = 0; m < muscles.size(); ++m) {
      const Vector3<double> axis = muscles[m].to - muscles[m].from, away = centroid - muscles[m].from;
      const double along = std::clamp(dot(away, axis) / dot(axis, axis), 0., 1.);
      const Vector3<double> beside = away - along * axis;
      if (dot(beside, beside) > muscles[m].radius * muscles[m].radius) continue;
      fibres.push_back({static_cast<std::int32_t>(t), static_cast<std::int32_t>(m),
                        (1 / std::sqrt(dot(axis, axis))) * axis, muscles[m].share});
    }
  }
  return fibres;
}

// Each component of each node's displacement is a random number from -shake to shake, the same on every machine.
Vectors<float> shaken(int nodes, double shake) {
  std::mt19937 random;  // whose numbers the standard fixes
  const auto next = [&] {
    return static_cast<float>(shake * (static_cast<int>(random() >> 8) - (1 << 23)) / (1 << 23));
  };
  Vectors<float> displacement;
  displacement.resize(nodes);
  for (int n = 0; n < nodes; ++n) {
    const float x = next(), y = next(), z = next();
    store(displacement, n, {x, y, z});
  }
  return displacement;
}

}  // namespace

Scene load_scene(const std::string& path) {
  const toml::table table =
      read_scene(path, "production_face", {"kind", "lattice"}, {"m10", "m01", "kappa", "shake", "muscle"});
  Flesh flesh;
  const auto modulus = [&](const char* key, float otherwise) {
    return static_cast<float>(number_between(table, key, 0, 1e12, "Pa").value_or(otherwise));
  };
  flesh = {modulus("m10", flesh.m10), modulus("m01", flesh.m01), modulus("kappa", flesh.kappa)};
  const double shake = number_between(table, "shake", 0, 1e6, "m").value_or(0);
  std::vector<Muscle> muscles;
  for (const toml::table* muscle : subtables(table, "muscle")) muscles.push_back(read_muscle(*muscle));
  const Mesh mesh = read_lattice(table);
  Scene scene = {.name = scene_name(path),
                 .path = path,
                 .body = make_body(mesh, fibres_of(mesh, muscles), static_cast<int>(muscles.size())),
                 .flesh = flesh,
                 .pose = {}};
  scene.pose.displacement = shaken(scene.body.nodes, shake);
  for (const Muscle& muscle : muscles) scene.pose.activation.push_back(static_cast<float>(muscle.activation));
  return scene;
}

}  // namespace lockstep::production_face
