// The loaders of users' files, by name, and the property that must hold of each: a file is read and its content is
// valid, or it is refused with an InputError of one line. Used by the fuzzer, and by the test that repeats the fuzzer's
// inputs.
#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "common/fluid/file.h"
#include "common/input_error.h"
#include "common/linear/matrix_market.h"
#include "common/memory.h"
#include "common/mesh_file.h"
#include "common/production_face/faults.h"
#include "common/production_face/mesh_file.h"
#include "tests/facesim_files.h"
#include "verify/domain.h"

namespace lockstep::fuzz {

// Bytes that a loader may allocate: large inputs are refused, and all others are read in a fraction of a second.
inline constexpr double memory = 8e6;

// Throws a finding unless `holds`.
inline void must(bool holds, const std::string& what) {
  if (!holds) throw std::logic_error(what);
}

inline void write_bytes(const std::string& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

inline std::string read_bytes(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Whether the action was not refused. The message of a refusal must be one readable line.
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

// --- Scenes

inline void try_scene_of(const verify::Domain& domain, const std::string& path) {
  accepted([&] { verify::domain_of_scene(path); });
  std::string fault;
  if (accepted([&] { fault = domain.fault_of_scene(path); })) must(fault.empty(), fault);
}

// --- Files

// A file that is read must be written with the same bytes.
inline void try_fluid_file(const std::string& path) {
  fluid::FluidFile file;
  if (!accepted([&] { file = fluid::read_fluid(path); })) return;
  const std::string copy = path + ".copy";
  fluid::write_fluid(copy, file.particles_per_metre, file.particles);
  must(read_bytes(copy) == read_bytes(path), "the file is not written as it was read");
  std::filesystem::remove(copy);
}

// Scenes that use the mesh must also read or refuse it.
inline void try_mesh(const std::string& path) {
  Mesh mesh;
  if (!accepted([&] { mesh = read_mesh(path); })) return;
  const int points = static_cast<int>(mesh.points.size());
  for (const auto& [x, y, z] : mesh.points)
    must(std::abs(x) <= 1e9 && std::abs(y) <= 1e9 && std::abs(z) <= 1e9, "a point is out of range");
  for (const auto& [a, b, c] : mesh.triangles)
    for (const int corner : {a, b, c}) must(corner >= 0 && corner < points, "a corner is no point");
  const std::string file = std::filesystem::path(path).filename(), scene = path + ".toml";
  const auto with = [&](const std::string& text) {
    write_bytes(scene, text);
    try_scene_of(verify::domain_of_scene(scene), scene);
  };
  with("kind = \"cloth\"\n[mesh]\nfile = \"" + file + "\"\nmass = 1\nbending = true\n");
  with("kind = \"levelset\"\npoints = [8, 9, 10]\nspacing = 0.25\norigin = [-1, -1, -1]\n[mesh]\nfile = \"" + file +
       "\"\n");
  with("kind = \"rigid\"\nframes = 1\n[[hull]]\nname = \"a\"\nfile = \"" + file +
       "\"\n[[body]]\nhull = \"a\"\ndensity = 1\n");
  with("kind = \"rigid\"\nframes = 1\n[[body]]\nmesh = \"" + file + "\"\n");
  std::filesystem::remove(scene);
}

// Rows hold what Rows says; a scene that names the file takes it or refuses it, too.
inline void try_matrix_market(const std::string& path) {
  linear::MarketMatrix matrix;
  if (!accepted([&] { matrix = linear::read_matrix_market(path); })) return;
  const linear::Rows<float>& a = matrix.rows;
  must(a.rows > 0 && a.columns > 0, "a matrix of no rows or columns");
  must(!matrix.symmetric || a.rows == a.columns, "a symmetric matrix is not square");
  must(a.begin.size() == static_cast<std::size_t>(a.rows) + 1 && a.begin.front() == 0, "rows are not counted");
  must(static_cast<std::size_t>(a.begin.back()) == a.value.size(), "rows do not end with the entries");
  must(a.column.size() == a.value.size(), "an entry without a column");
  for (int i = 0; i < a.rows; ++i)
    for (int k = a.begin[i]; k < a.begin[i + 1]; ++k)
      must(k == a.begin[i] || a.column[k - 1] < a.column[k], "the columns of a row do not ascend");
  const std::string scene = path + ".toml";
  write_bytes(scene, "kind = \"linear\"\n[file]\nmatrix = \"" + path.substr(path.rfind('/') + 1) + "\"\n");
  try_scene_of(verify::domain_of_scene(scene), scene);  // whose values are finite, and whose columns are there
  std::filesystem::remove(scene);
}

// Tetrahedra are read only without a fault, and a scene takes what is read.
inline void try_tetrahedra(const std::string& path) {
  production_face::Mesh mesh;
  if (!accepted([&] { mesh = production_face::read_mesh(path).mesh; })) return;
  const std::string fault = production_face::fault_of(mesh), scene = path + ".toml";
  must(fault.empty(), fault);
  write_bytes(scene, "kind = \"production_face\"\n[mesh]\nfile = \"" + path.substr(path.rfind('/') + 1) + "\"\n");
  try_scene_of(verify::domain_of_scene(scene), scene);
  std::filesystem::remove(scene);
}

// The first byte says which of facesim's files the others take the place of.
inline void try_facesim(const std::string& path) {
  production_face::FacesimFiles files = production_face::small_facesim_files();
  const std::string bytes = read_bytes(path), folder = path.substr(0, path.rfind('/'));
  if (bytes.empty()) return;
  const std::string scene = folder + "/facesim.toml";
  std::next(files.begin(), static_cast<unsigned char>(bytes[0]) % files.size())->second = bytes.substr(1);
  production_face::write_facesim(folder + "/facesim", files);
  write_bytes(scene, "kind = \"production_face\"\n[facesim]\nfolder = \"facesim\"\ncontrols = \"facesim\"\n");
  try_scene_of(verify::domain_of_scene(scene), scene);
}

struct Loader {
  std::string name;  // also of its folders in corpus/ and found/
  std::string file;  // name of the input file; its extension matters
  std::function<void(const std::string& path)> try_file;
};

// One for the scenes of each domain, then those of other files.
inline std::vector<Loader> loaders() {
  std::vector<Loader> all;
  for (const verify::Domain& domain : verify::domains())
    all.push_back({domain.name, "scene.toml", [&domain](const std::string& path) { try_scene_of(domain, path); }});
  all.push_back({"fluid_file", "in.fluid", try_fluid_file});
  for (const std::string& format : std::vector<std::string>{"obj", "off", "ply", "stl"})
    all.push_back({format, "in." + format, try_mesh});
  all.push_back({"matrix_market", "in.mtx", try_matrix_market});
  for (const std::string& format : std::vector<std::string>{"msh", "vtk", "veg"})
    all.push_back({format, "in." + format, try_tetrahedra});
  all.push_back({"facesim", "in.facesim", try_facesim});
  return all;
}

// Writes a tetrahedron and a matrix of two rows beside the inputs, which scenes may name.
inline void write_neighbours(const std::string& folder) {
  write_bytes(folder + "/a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  write_bytes(folder + "/a.mtx", "%%MatrixMarket matrix coordinate real symmetric\n2 2 3\n1 1 2\n2 1 -1\n2 2 2\n");
}

// Throws or crashes if there is a finding.
inline void try_bytes(const Loader& loader, const std::string& folder, std::string_view bytes) {
  const std::string path = folder + '/' + loader.file;
  write_bytes(path, bytes);
  loader.try_file(path);
}

}  // namespace lockstep::fuzz
