// facesim's files, as common/production_face/facesim.h describes them, for the tests of what reads them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "common/production_face/face.h"

namespace lockstep::production_face {

// Files by their name in the folder.
using FacesimFiles = std::map<std::string, std::string>;

template <class T>
std::string bytes_of(const T& value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}
inline std::string whole(std::int32_t n) { return bytes_of(n); }
inline std::string number(double x) { return bytes_of(static_cast<float>(x)); }
inline std::string vector(const Vector3<double>& x) { return number(x.x) + number(x.y) + number(x.z); }

inline std::string nodes_from_one(const std::vector<std::int32_t>& nodes) {
  std::string bytes = whole(static_cast<std::int32_t>(nodes.size()));
  for (const std::int32_t n : nodes) bytes += whole(n + 1);
  return bytes;
}

inline std::string tet_of(const Mesh& mesh) {
  const auto nodes = static_cast<std::int32_t>(mesh.nodes.size());
  std::string bytes = whole(nodes) + whole(4) + whole(static_cast<std::int32_t>(mesh.tetrahedra.size()));
  for (const auto& t : mesh.tetrahedra)
    for (const std::int32_t corner : t) bytes += whole(corner + 1);
  bytes += '\1' + whole(nodes) + whole(nodes) + whole(0) + std::string("\1\0\0", 3) + whole(nodes);
  for (const Vector3<double>& x : mesh.nodes) bytes += vector(x);
  return bytes;
}

// Two muscles of a name may not be; blanks become '_'.
inline std::string file_name(std::string name) {
  for (char& c : name)
    if (c == ' ') c = '_';
  return name;
}

inline FacesimFiles facesim_files(const FaceMesh& face, const Vector3<double>& joint) {
  FacesimFiles files;
  files["face_simulation.tet"] = tet_of(face.mesh);
  std::string names;
  for (std::size_t m = 0; m < face.muscles.size(); ++m) {
    const std::string name = file_name(face.muscles[m]);
    std::string tetrahedra, directions, shares;
    std::int32_t count = 0;
    for (const Fibre& fibre : face.fibres) {
      if (fibre.muscle != static_cast<std::int32_t>(m)) continue;
      tetrahedra += whole(fibre.tetrahedron + 1), directions += vector(fibre.direction), shares += number(fibre.share);
      ++count;
    }
    files[name + ".constitutive_data"] = whole(count) + tetrahedra + whole(count) + directions + whole(count) + shares;
    names += name + '\n';
  }
  files["muscle_list.txt"] = std::to_string(face.muscles.size()) + '\n' + names;
  files["peak_isometric_stress_list.txt"] = "0\n";
  files["attachment_list.txt"] = "2\ncranium\njaw\n";
  files["cranium.attached_nodes"] = nodes_from_one(face.skull), files["jaw.attached_nodes"] = nodes_from_one(face.jaw);
  files["jaw_joint_parameters"] =
      vector(joint) + vector({0, 1, 0}) + vector({1, 0, 0}) + vector({0, 0, 1}) + number(.1) + number(.01);
  return files;
}

// Of a frame: rotations by columns.
struct FacesimControls {
  std::vector<double> activation;
  std::vector<Vector3<double>> cranium, jaw;  // three columns and a shift
};

inline std::string controls_of(const FacesimControls& controls) {
  const auto count = static_cast<std::int32_t>(controls.activation.size() + 24);
  std::string bytes = whole(count);
  for (const double a : controls.activation) bytes += number(a);
  for (const auto* motion : {&controls.cranium, &controls.jaw})
    for (const Vector3<double>& x : *motion) bytes += vector(x);
  return bytes + whole(count) + std::string(count, '\1');
}

inline const std::vector<Vector3<double>> facesim_at_rest = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};

// A cell of twelve tetrahedra, with two muscles, and controls of a frame.
inline FacesimFiles small_facesim_files() {
  FaceMesh face;
  face.mesh = make_lattice({1, 1, 1}, .01);
  face.fibres = {{0, 0, {1, 0, 0}, 1}, {3, 0, {0, 1, 0}, .5}, {3, 1, {0, .6, .8}, .25}};
  face.muscles = {"a", "b"}, face.skull = {0, 1}, face.jaw = {6, 7};
  FacesimFiles files = facesim_files(face, {.01, 0, .005});
  files["storytelling_controls.0"] = controls_of({{0, 1}, facesim_at_rest, facesim_at_rest});
  return files;
}

inline void write_facesim(const std::string& folder, const FacesimFiles& files) {
  std::filesystem::create_directories(folder);
  for (const auto& file : files) std::ofstream(folder + '/' + file.first, std::ios::binary) << file.second;
}

}  // namespace lockstep::production_face
