#include "common/production_face/face.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "common/production_face/face_muscles.h"
#include "common/production_face/head.h"
#include "common/production_face/stuffing.h"

namespace lockstep::production_face {
namespace {

using Vector = Vector3<double>;

// The lips part where the slit between them is wider than .59 spacings: points of the lattice above and below it then
// move to its sides. The lattice has a layer of points amid it.
Mesh stuff_flesh(double spacing) {
  const double slit = std::max(.0015, 2. / 3 * spacing);
  const double low = mouth_height - spacing * std::ceil(.08 / spacing);
  return stuff([&](const Vector& p) { return distance_to_flesh(p, slit); }, {.085, low, .125, 0, .13, spacing});
}

enum class Bone : char { none, skull, jaw };

// Lips and cheeks lie loosely before the teeth.
bool is_loose(const Vector& p) {
  const double y = p.y + .04, x = p.x / .07, high = y / (y > 0 ? .05 : .03);
  return p.z > .02 && x * x + high * high < 1;
}

// Lips and cheeks are free. So are a strip of 8 mm between the nodes of jaw and skull, and nodes of the skull that
// share a tetrahedron with one of the jaw.
std::vector<Bone> bones_of(const Mesh& mesh, double spacing) {
  std::vector<Bone> bone(mesh.nodes.size(), Bone::none);
  for (std::size_t n = 0; n < bone.size(); ++n) {
    const Vector& x = mesh.nodes[n];
    const bool is_behind = x.z < 1e-6 * spacing;  // cuts have smaller errors
    if (!is_behind && (std::abs(distance_to_skull(x)) > .02 * spacing || is_loose(x))) continue;
    const double beyond_jaw = std::max(x.y - mouth_height, .025 - x.z);
    if (beyond_jaw < -.004)
      bone[n] = Bone::jaw;
    else if (is_behind || beyond_jaw > .004)
      bone[n] = Bone::skull;
  }
  for (const auto& t : mesh.tetrahedra)
    if (std::ranges::any_of(t, [&](std::int32_t corner) { return bone[corner] == Bone::jaw; }))
      for (const std::int32_t corner : t)
        if (bone[corner] == Bone::skull) bone[corner] = Bone::none;
  return bone;
}

// Without what hangs by a corner or an edge alone: the largest piece whose tetrahedra are joined by faces.
void keep_largest_piece(Mesh& mesh) {
  std::vector<std::pair<std::array<std::int32_t, 3>, std::int32_t>> faces;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    std::array<std::int32_t, 4> c = mesh.tetrahedra[t];
    std::ranges::sort(c);
    const auto i = static_cast<std::int32_t>(t);
    for (int left_out = 0; left_out < 4; ++left_out)
      faces.push_back({{c[left_out < 1 ? 1 : 0], c[left_out < 2 ? 2 : 1], c[left_out < 3 ? 3 : 2]}, i});
  }
  std::ranges::sort(faces);
  std::vector<std::int32_t> next(mesh.tetrahedra.size());  // towards the one that stands for the piece
  std::iota(next.begin(), next.end(), 0);
  const auto piece_of = [&](std::int32_t t) {
    while (next[t] != t) t = next[t] = next[next[t]];
    return t;
  };
  for (std::size_t f = 1; f < faces.size(); ++f)
    if (faces[f].first == faces[f - 1].first) next[piece_of(faces[f].second)] = piece_of(faces[f - 1].second);
  std::vector<std::int32_t> size(next.size(), 0);
  for (std::size_t t = 0; t < next.size(); ++t) ++size[piece_of(static_cast<std::int32_t>(t))];
  const auto largest = static_cast<std::int32_t>(std::ranges::max_element(size) - size.begin());
  std::vector<std::array<std::int32_t, 4>> kept;
  for (std::size_t t = 0; t < next.size(); ++t)
    if (piece_of(static_cast<std::int32_t>(t)) == largest) kept.push_back(mesh.tetrahedra[t]);
  mesh.tetrahedra = std::move(kept);
}

// The mesh of some nodes in their order, and of the tetrahedra, by their least node.
Mesh ordered(const Mesh& mesh, const std::vector<std::int32_t>& order) {
  Mesh result;
  std::vector<std::int32_t> number(mesh.nodes.size(), -1);
  for (const std::int32_t n : order) {
    number[n] = static_cast<std::int32_t>(result.nodes.size());
    result.nodes.push_back(mesh.nodes[n]);
  }
  result.tetrahedra = mesh.tetrahedra;
  for (auto& t : result.tetrahedra)
    for (std::int32_t& corner : t) corner = number[corner];
  const auto by_nodes = [](std::array<std::int32_t, 4> t) {
    std::ranges::sort(t);
    return t;
  };
  std::ranges::sort(result.tetrahedra, {}, by_nodes);
  return result;
}

// The nodes of tetrahedra, in layers of the lattice from below, each from left to right.
std::vector<std::int32_t> in_layers(const Mesh& mesh, double spacing) {
  std::vector<bool> has_one(mesh.nodes.size(), false);
  for (const auto& t : mesh.tetrahedra)
    for (const std::int32_t corner : t) has_one[corner] = true;
  std::vector<std::int32_t> order;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    if (has_one[n]) order.push_back(static_cast<std::int32_t>(n));
  std::ranges::sort(order, {}, [&](std::int32_t n) {
    const Vector& x = mesh.nodes[n];
    return std::tuple(std::floor((x.y - mouth_height) / spacing), x.x, x.y, x.z);
  });
  return order;
}

}  // namespace

FaceMesh make_face_mesh(double spacing) {
  FaceMesh face;
  Mesh mesh = stuff_flesh(spacing);
  std::vector<Bone> bone = bones_of(mesh, spacing);
  // A tetrahedron that is held at all its nodes has no freedom: nothing could turn it right if it were inside out.
  std::erase_if(mesh.tetrahedra, [&](const std::array<std::int32_t, 4>& t) {
    return std::ranges::all_of(t, [&](std::int32_t corner) { return bone[corner] != Bone::none; });
  });
  keep_largest_piece(mesh);
  const std::vector<std::int32_t> order = in_layers(mesh, spacing);
  for (std::size_t n = 0; n < order.size(); ++n) {
    if (bone[order[n]] == Bone::skull) face.skull.push_back(static_cast<std::int32_t>(n));
    if (bone[order[n]] == Bone::jaw) face.jaw.push_back(static_cast<std::int32_t>(n));
  }
  face.mesh = ordered(mesh, order);
  face.fibres = face_fibres(face.mesh);
  face.muscles = face_muscles();
  return face;
}

double face_tetrahedra(double spacing) { return 9.5e-3 / (spacing * spacing * spacing); }

}  // namespace lockstep::production_face
