#include "common/production_cloth/intersections.h"

#include <algorithm>
#include <vector>

#include "common/production_cloth/orientation.h"
#include "common/production_cloth/search.h"

namespace lockstep::production_cloth {
namespace {

using namespace spatial;

using Corners = std::array<Vector3<float>, 3>;

Box<float> box_of(const Vector3<float>& p, const Vector3<float>& q) { return around(Box<float>{p, p}, {q, q}); }
Box<float> box_of(const Corners& c) { return around(box_of(c[0], c[1]), box_of(c[1], c[2])); }

// Whether an edge and a triangle with an area, in one plane, are apart. Two convex shapes in a plane are apart if the
// line along a side of one has the other wholly beyond it. `of` drops a coordinate, along which the plane does not run.
template <class Of>
bool are_apart(const Of& of, int turn, const Vector3<float>& p, const Vector3<float>& q, const Corners& c) {
  for (int i = 0; i < 3; ++i) {
    const Point2 from = of(c[i]), to = of(c[(i + 1) % 3]);
    if (turn * orient2d(from, to, of(p)) < 0 && turn * orient2d(from, to, of(q)) < 0) return true;
  }
  const int first = orient2d(of(p), of(q), of(c[0]));
  return first != 0 && orient2d(of(p), of(q), of(c[1])) == first && orient2d(of(p), of(q), of(c[2])) == first;
}

bool meet_in_plane(const Vector3<float>& p, const Vector3<float>& q, const Corners& c) {
  const auto without_x = [](const Vector3<float>& v) { return Point2{v.y, v.z}; };
  const auto without_y = [](const Vector3<float>& v) { return Point2{v.z, v.x}; };
  const auto without_z = [](const Vector3<float>& v) { return Point2{v.x, v.y}; };
  const auto turn_of = [&](const auto& of) { return orient2d(of(c[0]), of(c[1]), of(c[2])); };
  if (const int turn = turn_of(without_x)) return !are_apart(without_x, turn, p, q, c);
  if (const int turn = turn_of(without_y)) return !are_apart(without_y, turn, p, q, c);
  if (const int turn = turn_of(without_z)) return !are_apart(without_z, turn, p, q, c);
  return true;  // no area
}

// The boxes of triangles, and of nodes of sixteen of them.
struct TriangleTree {
  const Topology& topology;
  const Vectors<float>& position;
  Levels levels;
  Bounds<float> boxes;

  TriangleTree(const Topology& topology, const Vectors<float>& position)
      : topology(topology), position(position), levels(make_levels(static_cast<int>(topology.triangles.size()))) {
    boxes.resize(levels.first.back());
    for (int i = 0; i < boxes.count; ++i) boxes.set(i, empty_box<float>);
    for (int t = 0; t < levels.elements; ++t) boxes.set(t, box_of(corners(t)));
    for (int level = 1; level <= levels.last(); ++level) {
      const int below = levels.first[level - 1], first = levels.first[level];
      for (int i = 0; i < first - below; ++i)
        boxes.set(first + i / tree_width, around(boxes.box(first + i / tree_width), boxes.box(below + i)));
    }
  }

  Corners corners(std::size_t triangle) const {
    const auto [a, b, c] = topology.corners(triangle);
    return {load(position, a), load(position, b), load(position, c)};
  }

  // Adds the triangles below a node whose boxes overlap the box, in their order.
  void find(const Box<float>& box, int level, int node, std::vector<std::int32_t>& found) const {
    for (int child = node * tree_width; child < (node + 1) * tree_width; ++child) {
      if (!overlap(box, boxes.box(levels.first[level] + child))) continue;
      if (level > 0)
        find(box, level - 1, child, found);
      else
        found.push_back(child);
    }
  }
};

// So many edges descend the tree as one: their numbers follow a Morton curve, so that they are near each other.
constexpr std::size_t edges_together = 8;

// Calls visit(edge, triangle) for all that meet, in the order of edges and then of triangles, until it returns true.
template <class Visit>
void visit_intersections(const Topology& topology, const Vectors<float>& position, const Visit& visit) {
  if (topology.triangles.empty()) return;
  const TriangleTree tree(topology, position);
  std::vector<std::int32_t> near;  // triangles
  for (std::size_t first = 0; first < topology.edges.size(); first += edges_together) {
    const std::size_t last = std::min(first + edges_together, topology.edges.size());
    Box<float> all = empty_box<float>;
    for (std::size_t e = first; e < last; ++e)
      all = around(all, box_of(load(position, topology.edges[e][0]), load(position, topology.edges[e][1])));
    near.clear();
    tree.find(all, tree.levels.last(), 0, near);
    for (std::size_t e = first; e < last; ++e) {
      const auto [a, b] = topology.edges[e];
      const Vector3<float> p = load(position, a), q = load(position, b);
      const Box<float> box = box_of(p, q);
      for (const std::int32_t t : near) {
        if (!overlap(box, tree.boxes.box(t))) continue;
        const auto [i, j, k] = topology.corners(t);
        const bool common = a == i || a == j || a == k || b == i || b == j || b == k;
        if (!common && edge_meets_triangle(p, q, tree.corners(t)) && visit(e, t)) return;
      }
    }
  }
}

}  // namespace

bool edge_meets_triangle(const Vector3<float>& p, const Vector3<float>& q, const Corners& c) {
  if (!overlap(box_of(p, q), box_of(c))) return false;
  const int side_p = orient3d(c[0], c[1], c[2], p), side_q = orient3d(c[0], c[1], c[2], q);
  if (side_p * side_q > 0) return false;
  if (side_p == 0 && side_q == 0) return meet_in_plane(p, q, c);
  // The line through p and q crosses the plane in one point, between the two. It is in the triangle unless the line
  // passes two sides on different hands.
  const int first = orient3d(p, q, c[0], c[1]), second = orient3d(p, q, c[1], c[2]), third = orient3d(p, q, c[2], c[0]);
  return std::max({first, second, third}) <= 0 || std::min({first, second, third}) >= 0;
}

std::size_t count_intersections(const Topology& topology, const Vectors<float>& position) {
  std::size_t count = 0;
  visit_intersections(topology, position, [&](std::size_t, int) { return ++count, false; });
  return count;
}

std::optional<std::array<std::int32_t, 2>> first_intersection(const Topology& topology,
                                                              const Vectors<float>& position) {
  std::optional<std::array<std::int32_t, 2>> found;
  visit_intersections(topology, position, [&](std::size_t edge, int triangle) {
    const auto of = std::ranges::find_if(topology.edges_of, [&](const auto& edges) {
      return std::ranges::find(edges, static_cast<std::int32_t>(edge)) != edges.end();
    });
    found = {static_cast<std::int32_t>(of - topology.edges_of.begin()), triangle};
    return true;
  });
  return found;
}

}  // namespace lockstep::production_cloth
