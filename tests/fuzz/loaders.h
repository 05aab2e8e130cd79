// What reads files of users, by name, and what must hold of it: a file is read, and what was read is sound, or it is refused with an
// InputError in one line. For the fuzzer, and for the test that feeds it again what the fuzzer kept.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>

#include "common/cloth/make.h"
#include "common/cloth/scene.h"
#include "common/fluid/file.h"
#include "common/fluid/scene.h"
#include "common/input_error.h"
#include "common/levelset/scene.h"
#include "common/memory.h"
#include "common/obj.h"
#include "common/rigid/scene.h"
#include "common/scene.h"

namespace lockstep::fuzz {

// What a loader may take: with it, what is large is refused, and all else is read in a fraction of a second.
inline constexpr double memory = 8e6;

// A finding.
inline void must(bool holds, const std::string& what) {
  if (!holds) throw std::logic_error(what);
}

inline void write_bytes(const std::string& path, std::string_view bytes) { std::ofstream(path, std::ios::binary) << bytes; }

inline std::string read_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Whether the action was not refused.
template <class Action>
bool accepted(Action action) {
  try {
    action();
    return true;
  } catch (const InputError& error) {
    const std::string_view message = error.what();
    const auto is_control = [](unsigned char c) { return c < ' ' || c == 127; };
    must(message.find(": ") != std::string_view::npos, "the message does not say where: " + std::string(message));
    must(std::ranges::none_of(message, is_control), "the message is more than a line of text: " + std::string(message));
    must(message.size() <= 1000, "the message is too long to be read: " + std::string(message));
    return false;
  }
}

template <class... Numbers>
void must_be_finite(const std::string& what, Numbers... numbers) {
  must((std::isfinite(numbers) && ...), what + " is not finite");
}
template <class Real>
void must_be_finite(const std::string& what, const Vectors<Real>& vectors) {
  for (const auto* component : {&vectors.x, &vectors.y, &vectors.z})
    for (const Real x : *component) must_be_finite(what, x);
}

// --- Scenes

inline void try_fluid(const std::string& path) {
  fluid::Scene scene;
  if (!accepted([&] { scene = fluid::load_scene(path); })) return;
  must_be_finite("a position", scene.particles.position);
  must_be_finite("a velocity", scene.particles.velocity);
}

inline void try_cloth(const std::string& path) {
  cloth::Cloth<float> cloth;
  if (!accepted([&] { cloth = cloth::convert<float>(cloth::load_scene(path).cloth); })) return;
  must_be_finite("a position", cloth.position);
  for (int i = 0; i < cloth.count; ++i) must_be_finite("an inverse mass", cloth.inverse_mass[i]);
  for (int k = 0; k < cloth.constraints.count; ++k)
    must(cloth.constraints.rest_2[k] > 0 && std::isfinite(cloth.constraints.rest_2[k]), "a length is not in the range of float");
}

inline void try_levelset(const std::string& path) {
  levelset::Scene scene;
  if (!accepted([&] { scene = levelset::load_scene(path); })) return;
  for (const float phi : scene.phi.value) must_be_finite("phi", phi);
}

inline void try_rigid(const std::string& path) {
  rigid::Scene scene;
  if (!accepted([&] { scene = rigid::load_scene(path); })) return;
  const auto& [bodies, colliders, hulls] = scene.world;
  for (int i = 0; i < bodies.count; ++i) {
    const auto [p, q, unused] = bodies.pose[i];
    must_be_finite("a position", p.x, p.y, p.z);
    must(std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1) < 1e-5f, "an orientation is not of length 1");
    const auto [v, w, padding] = bodies.motion[i];
    must_be_finite("a velocity", v.x, v.y, v.z, w.x, w.y, w.z);
    const auto [x, y, z, mass] = bodies.inverse_mass[i];
    must_be_finite("an inverse mass", x, y, z, mass);
    must(x >= 0 && y >= 0 && z >= 0 && mass >= 0, "an inverse mass is negative");
  }
  for (int i = 0; i < colliders.count; ++i) {
    const auto [p, q, unused] = colliders.local[i];
    must_be_finite("a collider's position", p.x, p.y, p.z);
    must(std::abs(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w - 1) < 1e-5f, "a collider's orientation is not of length 1");
    must(colliders.hull[i] < hulls.count, "a hull that is not there");
  }
  for (const auto& [x, y, z, w] : hulls.vertex) must_be_finite("a vertex", x, y, z);
  for (const auto& [x, y, z, w] : hulls.plane) must_be_finite("a plane", x, y, z, w);
}

template <auto try_scene>
void try_kind(const std::string& path) {
  accepted([&] { kind_of_scene(path); });
  try_scene(path);
}

// --- Files

// What was read is written as it stood.
inline void try_fluid_file(const std::string& path) {
  fluid::FluidFile file;
  if (!accepted([&] { file = fluid::read_fluid(path); })) return;
  const std::string copy = path + ".copy";
  fluid::write_fluid(copy, file.particles_per_metre, file.particles);
  must(read_bytes(copy) == read_bytes(path), "the file is not written as it was read");
  std::filesystem::remove(copy);
}

// Scenes that use an OBJ, whatever is in it, take it or refuse it, too.
inline void try_obj(const std::string& path) {
  Mesh mesh;
  if (!accepted([&] { mesh = read_obj(path); })) return;
  const int points = static_cast<int>(mesh.points.size());
  for (const auto& [x, y, z] : mesh.points) must(std::abs(x) <= 1e9 && std::abs(y) <= 1e9 && std::abs(z) <= 1e9, "a point is out of range");
  for (const auto& [a, b, c] : mesh.triangles)
    for (const int corner : {a, b, c}) must(corner >= 0 && corner < points, "a corner is no point");
  const std::string file = std::filesystem::path(path).filename(), scene = path + ".toml";
  const auto with = [&](auto try_scene, const std::string& text) {
    write_bytes(scene, text);
    try_scene(scene);
  };
  with(try_cloth, "kind = \"cloth\"\n[mesh]\nfile = \"" + file + "\"\nmass = 1\nbending = true\n");
  with(try_levelset, "kind = \"levelset\"\npoints = [8, 9, 10]\nspacing = 0.25\norigin = [-1, -1, -1]\n[mesh]\nfile = \"" + file + "\"\n");
  with(try_rigid, "kind = \"rigid\"\nframes = 1\n[[hull]]\nname = \"a\"\nfile = \"" + file + "\"\n[[body]]\nhull = \"a\"\ndensity = 1\n");
  with(try_rigid, "kind = \"rigid\"\nframes = 1\n[[body]]\nmesh = \"" + file + "\"\n");
  std::filesystem::remove(scene);
}

struct Loader {
  std::string_view name;  // of its folders below corpus/ and found/
  std::string_view file;  // what the input is called: its extension matters
  void (*try_file)(const std::string& path);
};
inline constexpr Loader loaders[] = {
    {"fluid", "scene.toml", try_kind<try_fluid>},       {"cloth", "scene.toml", try_kind<try_cloth>},
    {"levelset", "scene.toml", try_kind<try_levelset>}, {"rigid", "scene.toml", try_kind<try_rigid>},
    {"fluid_file", "in.fluid", try_fluid_file},         {"obj", "in.obj", try_obj},
};

// Beside every input, for scenes to name: a tetrahedron.
inline void write_neighbours(const std::string& folder) {
  write_bytes(folder + "/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
}

// Throws anything, or crashes, where there is a finding.
inline void try_bytes(const Loader& loader, const std::string& folder, std::string_view bytes) {
  const std::string path = folder + '/' + std::string(loader.file);
  write_bytes(path, bytes);
  loader.try_file(path);
}

}  // namespace lockstep::fuzz
