// Without Eigen's lanes a face has the same bits on every machine: Eigen calls fused multiply-adds where a machine has
// them.
#define EIGEN_DONT_VECTORIZE
#include "common/production_face/facesim.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <eigen3/Eigen/Geometry>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>
#include <utility>

#include "common/input_error.h"
#include "common/input_file.h"
#include "common/memory.h"
#include "common/production_face/element.h"
#include "common/words.h"

namespace lockstep::production_face {
namespace {

static_assert(std::endian::native == std::endian::little, "facesim's files are read as they lie in memory");

// Bytes of memory that reading may take per byte of a file: a node of 12 bytes takes 24 and 4 in the search for doubled
// ones, a tetrahedron of 16 takes 16 and 20 in the search for its like, a fibre of 20 takes 56. Of an array that grows
// there are two, the old one of half the size. In a list, a word of 3 bytes takes 16 as a view, 24 and 32 as a row, and
// 72 in the search for names that come twice.
constexpr double bytes_per_byte = 6, bytes_per_byte_of_list = 60;

using Vector = Vector3<double>;

std::string read_all(const std::string& path, double bytes_per_byte) {
  std::ifstream in = open_input(path);
  require_memory(bytes_per_byte * static_cast<double>(std::filesystem::file_size(path)), path + ": reading it");
  return {std::istreambuf_iterator<char>(in), {}};
}

// A file of numbers, read from its begin to its end.
class Numbers {
 public:
  explicit Numbers(const std::string& path) : path(path), bytes(read_all(path, bytes_per_byte)) {}

  [[noreturn]] void refuse(const std::string& why) const { throw InputError(path + ": " + why); }
  template <class T>
  T next(const std::string& what) {
    if (bytes.size() - at < sizeof(T)) refuse("ends before " + what);
    T value;
    std::memcpy(&value, &bytes[at], sizeof value);
    at += sizeof value;
    return value;
  }
  double number(const std::string& what) {
    const auto x = next<float>(what);
    if (!(std::abs(x) <= 1e9f)) refuse(what + ": expected a number from -1e9 to 1e9");
    return x;
  }
  Vector vector(const std::string& what) {
    const double x = number(what), y = number(what), z = number(what);
    return {x, y, z};
  }
  // A whole number that must be this.
  void expect(std::int32_t expected, const std::string& what) {
    const auto found = next<std::int32_t>(what);
    if (found != expected) refuse(what + ": " + std::to_string(found) + ", expected " + std::to_string(expected));
  }
  // How many there are, each of so many bytes, which must follow.
  std::int32_t count(std::size_t size, const std::string& what) {
    const auto n = next<std::int32_t>("how many " + what);
    if (n < 0 || static_cast<std::size_t>(n) > (bytes.size() - at) / size)
      refuse(std::to_string(n) + ' ' + what + ", for which " + std::to_string(bytes.size() - at) + " bytes are left");
    return n;
  }
  // A number from 1 to n, counted from 0.
  std::int32_t from_one(std::int32_t n, const std::string& what) {
    const auto k = next<std::int32_t>(what);
    if (k < 1 || k > n) refuse(what + ": " + std::to_string(k) + ", expected one from 1 to " + std::to_string(n));
    return k - 1;
  }
  // A number from 0 to 1.
  double share(const std::string& what) {
    const double x = number(what);
    if (!(x >= -1e-3 && x <= 1 + 1e-3)) refuse(what + ": expected a number from 0 to 1");
    return std::clamp(x, 0., 1.);
  }
  void end() const {
    if (at < bytes.size()) refuse(std::to_string(bytes.size() - at) + " bytes more than it says");
  }

 private:
  std::string path, bytes;
  std::size_t at = 0;
};

std::string nth(const char* what, std::int64_t i) { return what + std::string(" ") + std::to_string(i + 1); }

// How many, then so many times `columns` words; the first of each is a name, which is part of a file's.
std::vector<std::vector<std::string>> read_list(const std::string& path, std::size_t columns) {
  std::string text = read_all(path, bytes_per_byte_of_list);
  std::ranges::replace(text, '\n', ' ');
  const std::vector<std::string_view> words = words_of(text);
  const std::optional<std::int64_t> count = words.empty() ? std::nullopt : as<std::int64_t>(words[0]);
  if (!count || *count < 0) throw InputError(path + ": expected how many names there are");
  std::vector<std::vector<std::string>> rows;
  std::set<std::string> names;
  for (std::int64_t i = 0; i < *count; ++i) {
    const std::size_t first = 1 + columns * rows.size();
    if (words.size() < first + columns)
      throw InputError(path + ": ends before " + nth("name", i) + " of " + std::to_string(*count));
    std::vector<std::string>& row = rows.emplace_back();
    for (std::size_t k = 0; k < columns; ++k) row.emplace_back(words[first + k]);
    if (row[0] != legible(row[0]) || row[0].find('/') != row[0].npos)
      throw InputError(path + ": " + nth("name", i) + ": expected a part of a file's name");
    if (!names.insert(row[0]).second) throw InputError(path + ": " + row[0] + " comes twice");
  }
  return rows;
}

MeshFile read_tetrahedra(const std::string& path) {
  Numbers in(path);
  Mesh mesh;
  const auto nodes = in.next<std::int32_t>("the number of nodes");
  in.expect(4, "corners of a tetrahedron");
  const std::int32_t tetrahedra = in.count(16, "tetrahedra");
  for (std::int32_t t = 0; t < tetrahedra; ++t) {
    std::array<std::int32_t, 4>& corners = mesh.tetrahedra.emplace_back();
    for (std::int32_t& corner : corners) corner = in.from_one(nodes, "a corner of " + nth("tetrahedron", t));
  }
  if (in.next<char>("the byte after tetrahedra") != 1) in.refuse("the byte after tetrahedra: expected 1");
  in.expect(nodes, "the number of particles"), in.expect(nodes, "the room for particles");
  in.expect(0, "the number of particles left out");
  for (int k = 0; k < 3; ++k) in.next<char>("what particles have");
  if (in.count(12, "places") != nodes) in.refuse("expected as many places as nodes, " + std::to_string(nodes));
  for (std::int32_t n = 0; n < nodes; ++n) mesh.nodes.push_back(in.vector("the place of " + nth("node", n)));
  in.end();
  return mended(std::move(mesh), path);
}

// Adds a muscle's fibres.
void read_muscle(const std::string& path, std::int32_t tetrahedra, std::int32_t muscle, double stress,
                 std::vector<Fibre>& fibres) {
  Numbers in(path);
  const std::int32_t count = in.count(4, "tetrahedra");
  const std::size_t first = fibres.size();
  std::vector<bool> has_one(tetrahedra, false);
  for (std::int32_t i = 0; i < count; ++i) {
    const std::int32_t t = in.from_one(tetrahedra, nth("tetrahedron", i));
    if (has_one[t]) in.refuse("tetrahedron " + std::to_string(t + 1) + " comes twice");
    has_one[t] = true;
    fibres.push_back({.tetrahedron = t, .muscle = muscle, .direction = {}, .stress = stress});
  }
  if (in.count(12, "directions") != count) in.refuse("expected as many directions as tetrahedra");
  for (std::int32_t i = 0; i < count; ++i) {
    const Vector w = in.vector(nth("direction", i));
    const double length = std::sqrt(dot(w, w));
    if (!(length > .9 && length < 1.1)) in.refuse(nth("direction", i) + ": expected one of length 1");
    fibres[first + i].direction = (1 / length) * w;
  }
  if (in.count(4, "shares") != count) in.refuse("expected as many shares as tetrahedra");
  for (std::int32_t i = 0; i < count; ++i) fibres[first + i].share = in.share(nth("share", i));
  in.end();
}

std::map<std::string, double> read_stresses(const std::string& path) {
  std::map<std::string, double> stresses;
  for (const std::vector<std::string>& row : read_list(path, 2)) {
    const std::optional<double> stress = as<double>(row[1]);
    if (!stress || !(*stress >= 0 && *stress <= 1e12))
      throw InputError(path + ": " + row[0] + ": expected a number from 0 to 1e12, in Pa");
    stresses[row[0]] = *stress;
  }
  return stresses;
}

std::vector<std::int32_t> read_places(const std::string& path, std::int32_t nodes) {
  Numbers in(path);
  if (in.count(4, "nodes") != nodes) in.refuse("expected as many nodes as the mesh has, " + std::to_string(nodes));
  std::vector<std::int32_t> place;
  for (std::int32_t n = 0; n < nodes; ++n) place.push_back(in.from_one(nodes, nth("node", n)));
  in.end();
  return place;
}

// The nodes of each attachment. `place` says where nodes stand in the mesh, if it is not empty.
void read_attachments(const std::string& folder, const std::vector<std::int32_t>& place, FacesimFace& face) {
  const auto nodes = static_cast<std::int32_t>(face.file.mesh.nodes.size());
  std::vector<std::int32_t> bone_of_node(nodes, -1);
  for (const std::vector<std::string>& row : read_list(folder + "attachment_list.txt", 1)) {
    Numbers in(folder + row[0] + ".attached_nodes");
    const std::int32_t count = in.count(4, "nodes");
    for (std::int32_t i = 0; i < count; ++i) {
      const std::int32_t n = in.from_one(nodes, nth("node", i));
      bone_of_node[place.empty() ? n : place[n]] = static_cast<std::int32_t>(face.bones.size());
    }
    in.end();
    face.bones.push_back({.name = row[0], .pivot = {0, 0, 0}});
  }
  const auto jaw = std::ranges::find(face.bones, "jaw", &Bone::name);
  if (jaw == face.bones.end()) throw InputError(folder + "attachment_list.txt: expected an attachment named jaw");
  face.held.resize(face.bones.size());
  for (std::int32_t n = 0; n < nodes; ++n)
    if (bone_of_node[n] >= 0) face.held[bone_of_node[n]].push_back(n);
  Numbers joint(folder + "jaw_joint_parameters");
  jaw->pivot = joint.vector("the middle of the joint");
  for (const char* what : {"its normal", "its axis", "its front"}) joint.vector(what);
  for (const char* what : {"the length of its axis", "the length of sliding"}) joint.number(what);
  joint.end();
}

// --- Controls

// x becomes turn x + shift.
struct Motion3 {
  Matrix3<double> turn;
  Vector shift;
};

Motion3 read_motion(Numbers& in, const std::string& bone) {
  const Vector x = in.vector(bone), y = in.vector(bone), z = in.vector(bone);
  const Svd<double> found = svd<double>({x, y, z});
  for (const double s : {found.s.x, found.s.y, found.s.z})
    if (!(std::abs(s - 1) < .01)) in.refuse(bone + ": expected a rotation");
  return {composed(found.u, {1, 1, 1}, found.v), in.vector(bone)};
}

// The direction of a rotation's axis, as long as its angle, 0 to pi.
Vector turn_of(const Matrix3<double>& r) {
  Eigen::Matrix3d columns;
  columns << r.x.x, r.y.x, r.z.x, r.x.y, r.y.y, r.z.y, r.x.z, r.y.z, r.z.z;
  const Eigen::AngleAxisd found(columns);
  const Eigen::Vector3d turn = found.angle() * found.axis();
  return {turn.x(), turn.y(), turn.z()};
}

Placement placement_of(const Motion3& motion, const Vector& pivot) {
  return {.turn = turn_of(motion.turn), .shift = motion.turn * pivot + motion.shift - pivot};
}

Key read_controls(const std::string& path, double time, const FacesimFace& face) {
  Numbers in(path);
  const auto controls = static_cast<std::int32_t>(face.muscles.size()) + 24;
  Key key = {.time = time, .activation = {}, .bones = {}};
  in.expect(controls, "the number of controls");
  for (const std::string& muscle : face.muscles)
    key.activation.push_back(static_cast<float>(in.share("the activation of " + muscle)));
  const Motion3 cranium = read_motion(in, "the cranium"), jaw = read_motion(in, "the jaw");
  const Matrix3<double> turn = {cranium.turn * jaw.turn.x, cranium.turn * jaw.turn.y, cranium.turn * jaw.turn.z};
  for (const Bone& bone : face.bones)
    key.bones.push_back(bone.name == "jaw" ? placement_of({turn, cranium.turn * jaw.shift + cranium.shift}, bone.pivot)
                                           : placement_of(cranium, bone.pivot));
  if (in.count(1, "bytes") != controls) in.refuse("expected a byte a control");
  for (std::int32_t k = 0; k < controls; ++k) in.next<char>("a byte");
  in.end();
  return key;
}

}  // namespace

FacesimFace read_facesim(const std::string& path, const std::optional<std::string>& controls) {
  const std::string folder = path + '/';
  const bool is_alone = std::filesystem::exists(folder + "face_simulation.tet");
  FacesimFace face;
  face.file = read_tetrahedra(folder + (is_alone ? "face_simulation.tet" : "face_simulation_1.tet"));
  const auto nodes = static_cast<std::int32_t>(face.file.mesh.nodes.size());
  const auto place = is_alone ? std::vector<std::int32_t>() : read_places(folder + "particle_positions_1.dat", nodes);
  const std::map<std::string, double> stresses = read_stresses(folder + "peak_isometric_stress_list.txt");
  for (const std::vector<std::string>& row : read_list(folder + "muscle_list.txt", 1)) {
    const auto own = stresses.find(row[0]);
    read_muscle(folder + row[0] + ".constitutive_data", static_cast<std::int32_t>(face.file.mesh.tetrahedra.size()),
                static_cast<std::int32_t>(face.muscles.size()), own == stresses.end() ? muscle_stress : own->second,
                face.fibres);
    face.muscles.push_back(row[0]);
  }
  std::ranges::stable_sort(face.fibres, {}, &Fibre::tetrahedron);
  read_attachments(folder, place, face);
  if (!controls) return face;
  const auto file = [&](std::size_t k) { return *controls + "/storytelling_controls." + std::to_string(k); };
  do {
    const std::size_t k = face.keys.size();
    face.keys.push_back(read_controls(file(k), static_cast<double>(k) * frame_time, face));
  } while (std::filesystem::exists(file(face.keys.size())));
  return face;
}

}  // namespace lockstep::production_face
