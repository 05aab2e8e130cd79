#include "common/production_face/scene.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "common/memory.h"
#include "common/production_face/face.h"
#include "common/production_face/facesim.h"
#include "common/production_face/make.h"
#include "common/production_face/mesh_file.h"
#include "common/scene_reader.h"

namespace lockstep::production_face {
namespace {

// Of a body, its strained state and the mesh that it is made from.
constexpr double bytes_per_tetrahedron = 500;
// Of a slot of sixteen fibres, at least one of them there: muscle, fibre and pull (body.h).
constexpr double bytes_per_slot = 16 * 4 * (1 + 5 + 5);

void require_memory_for(double tetrahedra, const toml::table& table) {
  require_memory(bytes_per_tetrahedron * tetrahedra,
                 position(table.source()) + ": " + std::to_string(static_cast<long long>(tetrahedra)) + " tetrahedra");
}

Mesh read_lattice(const toml::table& lattice) {
  check_keys(lattice, {"cells", "spacing"}, {});
  const Vector3<double> cells = *vector_between(lattice, "cells", 1, 1000, "");
  const double spacing = *number_between(lattice, "spacing", 1e-6, 1e6, "m");
  for (const double n : {cells.x, cells.y, cells.z})
    if (n != std::floor(n)) refuse_value(*lattice.get("cells"), "cells", "three whole numbers");
  require_memory_for(12 * cells.x * cells.y * cells.z, lattice);
  return make_lattice({int(cells.x), int(cells.y), int(cells.z)}, spacing);
}

// A muscle is a capsule: tetrahedra whose centroids are in it have a fibre along its axis.
struct Muscle {
  std::string name;
  Vector3<double> from, to;
  double radius, share, activation;
};

Muscle read_muscle(const toml::table& table) {
  check_keys(table, {"from", "to", "radius"}, {"name", "share", "activation"});
  const Muscle muscle = {.name = text(table, "name").value_or(""),
                         .from = *vector_between(table, "from", -1e6, 1e6, "m"),
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

// --- What a scene is about

struct Anatomy {
  Mesh mesh;
  std::vector<Fibre> fibres = {};
  std::vector<std::string> muscles = {};  // their names
  std::vector<float> activation = {};     // of muscles, at the start
  std::vector<Bone> bones = {};
  std::vector<std::vector<std::int32_t>> held = {};  // by each bone; a node in several is the first bone's
  int turned = 0, doubled = 0;                       // tetrahedra and nodes of a file (mesh_file.h)
  std::vector<Key> keys = {};                        // of files; else the scene has them
};

// The nodes in a box, borders included.
std::vector<std::int32_t> nodes_in(const Mesh& mesh, const Vector3<double>& a, const Vector3<double>& b) {
  std::vector<std::int32_t> found;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const Vector3<double>& x = mesh.nodes[n];
    if (a.x <= x.x && x.x <= b.x && a.y <= x.y && x.y <= b.y && a.z <= x.z && x.z <= b.z)
      found.push_back(static_cast<std::int32_t>(n));
  }
  return found;
}

// The mesh with the muscles and bones of the scene.
Anatomy in_capsules_and_boxes(const toml::table& table, const Mesh& mesh) {
  Anatomy anatomy = {.mesh = mesh};
  std::vector<Muscle> muscles;
  for (const toml::table* muscle : subtables(table, "muscle")) {
    muscles.push_back(read_muscle(*muscle));
    anatomy.muscles.push_back(muscles.back().name);
    anatomy.activation.push_back(static_cast<float>(muscles.back().activation));
  }
  anatomy.fibres = fibres_of(mesh, muscles);
  for (const toml::table* bone : subtables(table, "bone")) {
    check_keys(*bone, {"name", "from", "to"}, {"pivot"});
    const Vector3<double> origin = {0, 0, 0};
    anatomy.bones.push_back(
        {.name = *text(*bone, "name"), .pivot = vector_between(*bone, "pivot", -1e6, 1e6, "m").value_or(origin)});
    anatomy.held.push_back(
        nodes_in(mesh, *vector_between(*bone, "from", -1e6, 1e6, "m"), *vector_between(*bone, "to", -1e6, 1e6, "m")));
  }
  return anatomy;
}

// Refuses tables of the scene beside another, which says the same.
void refuse_beside(const toml::table& table, std::initializer_list<const char*> keys, const std::string& other) {
  for (const char* key : keys)
    if (const toml::node* given = table.get(key))
      refuse_value(*given, key, "none beside " + other + ", which has its own");
}

Anatomy read_face(const toml::table& table, const toml::table& face) {
  refuse_beside(table, {"muscle", "bone"}, "[face]");
  check_keys(face, {"spacing"}, {});
  const double spacing = *number_between(face, "spacing", least_face_spacing, most_face_spacing, "m");
  require_memory_for(face_tetrahedra(spacing), face);
  FaceMesh made = make_face_mesh(spacing);
  const std::size_t muscles = made.muscles.size();
  return {.mesh = std::move(made.mesh),
          .fibres = std::move(made.fibres),
          .muscles = std::move(made.muscles),
          .activation = std::vector<float>(muscles, 0.f),
          .bones = {{"skull", {0, 0, 0}}, {"jaw", jaw_joint}},
          .held = {std::move(made.skull), std::move(made.jaw)}};
}

Anatomy read_facesim_face(const std::string& path, const toml::table& table, const toml::table& facesim) {
  refuse_beside(table, {"muscle", "bone"}, "[facesim]");
  check_keys(facesim, {"folder"}, {"controls"});
  std::optional<std::string> controls = text(facesim, "controls");
  if (controls) refuse_beside(table, {"key"}, "`controls`"), controls = beside(path, *controls);
  FacesimFace read = read_facesim(beside(path, *text(facesim, "folder")), controls);
  require_memory_for(static_cast<double>(read.file.mesh.tetrahedra.size()), facesim);
  require_memory(bytes_per_slot * static_cast<double>(read.fibres.size()), position(facesim.source()) + ": fibres");
  const std::vector<float> at_rest(read.muscles.size(), 0.f);
  return {.mesh = std::move(read.file.mesh),
          .fibres = std::move(read.fibres),
          .muscles = std::move(read.muscles),
          .activation = read.keys.empty() ? at_rest : read.keys[0].activation,
          .bones = std::move(read.bones),
          .held = std::move(read.held),
          .turned = read.file.turned,
          .doubled = read.file.doubled,
          .keys = std::move(read.keys)};
}

Anatomy read_anatomy(const std::string& path, const toml::table& table) {
  const toml::table *lattice = subtable(table, "lattice"), *mesh = subtable(table, "mesh"),
                    *face = subtable(table, "face"), *facesim = subtable(table, "facesim");
  if ((lattice != nullptr) + (mesh != nullptr) + (face != nullptr) + (facesim != nullptr) != 1)
    refuse(table.source(), "expected exactly one of lattice, mesh, face and facesim");
  if (face) return read_face(table, *face);
  if (facesim) return read_facesim_face(path, table, *facesim);
  if (lattice) return in_capsules_and_boxes(table, read_lattice(*lattice));
  check_keys(*mesh, {"file"}, {});
  const MeshFile file = read_mesh(beside(path, *text(*mesh, "file")));
  require_memory_for(static_cast<double>(file.mesh.tetrahedra.size()), *mesh);
  Anatomy anatomy = in_capsules_and_boxes(table, file.mesh);
  anatomy.turned = file.turned, anatomy.doubled = file.doubled;
  return anatomy;
}

Scene scene_of(const Anatomy& anatomy) {
  Scene scene;
  scene.body = make_body(anatomy.mesh, anatomy.fibres, static_cast<int>(anatomy.muscles.size()));
  scene.pose.activation.assign(anatomy.activation.begin(), anatomy.activation.end());
  scene.motion.bones = anatomy.bones;
  std::vector<std::int32_t> bone_of_node(scene.body.nodes, -1);
  for (std::size_t bone = anatomy.held.size(); bone-- > 0;)
    for (const std::int32_t n : anatomy.held[bone]) bone_of_node[n] = static_cast<std::int32_t>(bone);
  for (int n = 0; n < scene.body.nodes; ++n)
    if (bone_of_node[n] >= 0) scene.body.held.push_back(n), scene.motion.bone_of_held.push_back(bone_of_node[n]);
  return scene;
}

// --- Keys

// The muscles or bones that table[what] means: one of that name, or its two sides.
std::vector<std::size_t> named(const toml::table& table, const std::vector<std::string>& names, const char* what) {
  const std::string name = *text(table, what);
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < names.size(); ++k)
    if (names[k] == name || names[k] == name + " left" || names[k] == name + " right") found.push_back(k);
  if (found.empty() || name.empty()) refuse_value(*table.get(what), what, std::string("the name of a ") + what);
  return found;
}

// Muscles and bones that a key does not name are at rest.
Key read_key(const toml::table& table, const std::vector<std::string>& muscles, const std::vector<std::string>& bones) {
  check_keys(table, {"time"}, {"pull", "move"});
  Key key = {.time = *number_between(table, "time", 1e-6, 1e6, "s"),
             .activation = std::vector<float>(muscles.size(), 0.f),
             .bones = std::vector<Placement>(bones.size())};
  for (const toml::table* pull : subtables(table, "pull")) {
    check_keys(*pull, {"muscle", "activation"}, {});
    for (const std::size_t m : named(*pull, muscles, "muscle"))
      key.activation[m] = static_cast<float>(*number_between(*pull, "activation", 0, 1, ""));
  }
  for (const toml::table* move : subtables(table, "move")) {
    check_keys(*move, {"bone"}, {"turn", "shift"});
    for (const std::size_t b : named(*move, bones, "bone"))
      key.bones[b] = {vector_between(*move, "turn", -10, 10, "rad").value_or(Vector3<double>{}),
                      vector_between(*move, "shift", -1e6, 1e6, "m").value_or(Vector3<double>{})};
  }
  return key;
}

// Those of files, if there are; else the first key is the scene's start, bones at rest.
void read_keys(const toml::table& table, const Anatomy& anatomy, Scene& scene) {
  Motion& motion = scene.motion;
  motion.repeats = truth(table, "repeat").value_or(false);
  motion.keys = anatomy.keys;
  if (!motion.keys.empty()) return;
  std::vector<std::string> bones;
  for (const Bone& bone : motion.bones) bones.push_back(bone.name);
  motion.keys = {{.time = 0,
                  .activation = {scene.pose.activation.begin(), scene.pose.activation.end()},
                  .bones = std::vector<Placement>(bones.size())}};
  for (const toml::table* key : subtables(table, "key")) {
    motion.keys.push_back(read_key(*key, anatomy.muscles, bones));
    if (motion.keys.back().time <= motion.keys[motion.keys.size() - 2].time)
      refuse_value(*key->get("time"), "time", "a later time than the key's before");
  }
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
  const toml::table table = read_scene(path, "production_face", {"kind"},
                                       {"lattice", "mesh", "face", "facesim", "m10", "m01", "kappa", "shake", "frames",
                                        "tolerance", "repeat", "muscle", "bone", "key"});
  Flesh flesh;
  const auto modulus = [&](const char* key, float otherwise) {
    return static_cast<float>(number_between(table, key, 0, 1e12, "Pa").value_or(otherwise));
  };
  flesh = {modulus("m10", flesh.m10), modulus("m01", flesh.m01), modulus("kappa", flesh.kappa)};
  const double shake = number_between(table, "shake", 0, 1e6, "m").value_or(0);
  const int frames = whole_int(table, "frames", 1).value_or(1);
  const double tolerance = number_between(table, "tolerance", 1e-6, 1, "").value_or(1e-3);
  const Anatomy anatomy = read_anatomy(path, table);
  Scene scene = scene_of(anatomy);
  scene.name = scene_name(path), scene.path = path;
  scene.flesh = flesh, scene.frames = frames, scene.tolerance = tolerance, scene.turned = anatomy.turned;
  scene.doubled = anatomy.doubled;
  scene.pose.displacement = shaken(scene.body.nodes, shake);
  for (const int n : scene.body.held) store(scene.pose.displacement, n, {0, 0, 0});
  read_keys(table, anatomy, scene);
  return scene;
}

}  // namespace lockstep::production_face
