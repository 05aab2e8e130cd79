#include "common/production_face/faults.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

namespace lockstep::production_face {
namespace {

double volume_of(const Mesh& mesh, const std::array<std::int32_t, 4>& t) {
  const auto edge = [&](int a) { return mesh.nodes[t[a]] - mesh.nodes[t[0]]; };
  return dot(edge(1), cross(edge(2), edge(3))) / 6;
}

double longest_edge(const Mesh& mesh, const std::array<std::int32_t, 4>& t) {
  double square = 0;
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < a; ++b) {
      const Vector3<double> edge = mesh.nodes[t[a]] - mesh.nodes[t[b]];
      square = std::max(square, dot(edge, edge));
    }
  return std::sqrt(square);
}

// Of the shape of a tetrahedron whose corners are nodes.
std::string fault_of_shape(const Mesh& mesh, const std::array<std::int32_t, 4>& t) {
  const double volume = volume_of(mesh, t), edge = longest_edge(mesh, t);
  if (!(volume > 0)) return "has no positive volume";
  if (edge < least_edge) return "has no edge of 1e-6 m or longer";
  if (volume < least_share * edge * edge * edge)
    return "is a sliver: its volume is less than 1e-4 of its longest edge cubed";
  return "";
}

// Of two tetrahedra with the same nodes.
std::string fault_of_repeats(const Mesh& mesh) {
  std::vector<std::pair<std::array<std::int32_t, 4>, std::int32_t>> sorted;
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
    sorted.push_back({mesh.tetrahedra[i], static_cast<std::int32_t>(i)});
    std::ranges::sort(sorted.back().first);
  }
  std::ranges::sort(sorted);
  const auto same = std::ranges::adjacent_find(sorted, {}, [](const auto& of) { return of.first; });
  if (same == sorted.end()) return "";
  return "tetrahedron " + std::to_string((same + 1)->second) + " has the nodes of tetrahedron " +
         std::to_string(same->second);
}

}  // namespace

std::string fault_of(const Mesh& mesh) {
  if (mesh.tetrahedra.empty()) return "no tetrahedra";
  const auto nodes = static_cast<std::int32_t>(mesh.nodes.size());
  std::vector<bool> has_one(nodes, false);
  for (std::int32_t n = 0; n < nodes; ++n) {
    const Vector3<double>& x = mesh.nodes[n];
    if (!std::isfinite(x.x + x.y + x.z)) return "node " + std::to_string(n) + " has a position that is not finite";
  }
  for (std::size_t i = 0; i < mesh.tetrahedra.size(); ++i) {
    const std::array<std::int32_t, 4>& t = mesh.tetrahedra[i];
    const std::string name = "tetrahedron " + std::to_string(i) + ' ';
    for (const std::int32_t corner : t) {
      if (corner < 0 || corner >= nodes) return name + "has a corner that is no node: " + std::to_string(corner);
      if (std::ranges::count(t, corner) > 1) return name + "has node " + std::to_string(corner) + " twice";
      has_one[corner] = true;
    }
    if (const std::string fault = fault_of_shape(mesh, t); !fault.empty()) return name + fault;
  }
  if (const std::string fault = fault_of_repeats(mesh); !fault.empty()) return fault;
  const auto alone = std::ranges::find(has_one, false);
  return alone == has_one.end() ? "" : "node " + std::to_string(alone - has_one.begin()) + " is in no tetrahedron";
}

int turn_inside_out(Mesh& mesh) {
  int turned = 0;
  for (std::array<std::int32_t, 4>& t : mesh.tetrahedra)
    if (volume_of(mesh, t) < 0) std::swap(t[2], t[3]), ++turned;
  return turned;
}

int count_doubled(const Mesh& mesh) {
  const auto place = [&](std::int32_t n) {
    const Vector3<double>& x = mesh.nodes[n];
    return std::tuple(x.x, x.y, x.z);
  };
  std::vector<std::int32_t> order(mesh.nodes.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, place);
  int doubled = 0;
  for (std::size_t k = 1; k < order.size(); ++k) doubled += place(order[k]) == place(order[k - 1]);
  return doubled;
}

}  // namespace lockstep::production_face
