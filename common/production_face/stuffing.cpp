#include "common/production_face/stuffing.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <unordered_map>
#include <utility>

namespace lockstep::production_face {
namespace {

using Vector = Vector3<double>;

// In half spacings from the corner at (0, low_y, low_z): all three even (corners) or odd (middles). Points of the left
// half are those of the right one mirrored.
struct Point {
  int i, j, k;

  friend Point operator+(const Point& a, const Point& b) { return {a.i + b.i, a.j + b.j, a.k + b.k}; }
  friend Point operator-(const Point& a, const Point& b) { return {a.i - b.i, a.j - b.j, a.k - b.k}; }
  friend bool operator==(const Point&, const Point&) = default;
};

Point mirrored(const Point& p) { return {-p.i, p.j, p.k}; }
Vector mirrored(const Vector& x) { return {-x.x, x.y, x.z}; }

struct Cut {
  Vector place;
  std::int32_t node = -1;
};

// A node of the right half; or, mirrored, of the left one.
struct Node {
  std::int32_t id;
  bool mirrored;
};

// The edges at a point. The first six are long.
constexpr Point edges[] = {{2, 0, 0},  {-2, 0, 0}, {0, 2, 0},  {0, -2, 0},  {0, 0, 2},   {0, 0, -2},  {1, 1, 1},
                           {-1, 1, 1}, {1, -1, 1}, {1, 1, -1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, -1}};

bool is_long(const Point& edge) { return edge.i == 0 || edge.j == 0 || edge.k == 0; }

class Stuffing {
 public:
  Stuffing(const Distance& distance, const StuffedBox& box)
      : distance(distance),
        box(box),
        nx(points_to(box.half_width)),
        ny(points_to(box.high_y - box.low_y)),
        nz(points_to(box.high_z - box.low_z)) {
    place.resize(std::size_t(nx) * ny * nz);
    value.assign(place.size(), 1);
    node_of_point.assign(place.size(), -1);
  }

  Mesh mesh() {
    for_each_point([&](const Point& p) {
      place[index(p)] = at_rest(p);
      value[index(p)] = distance(at_rest(p));
    });
    for_each_point([&](const Point& p) { move_to_surface(p); });
    for_each_point([&](const Point& p) {
      if (p.i % 2 == 0) fill_about(p);
    });
    return both_halves();
  }

 private:
  // --- The lattice

  int points_to(double length) const { return 4 + static_cast<int>(std::ceil(2 * length / box.spacing)); }

  // Points at the ends are outside of the shape: they need no neighbours.
  template <class F>
  void for_each_point(const F& f) const {
    for (int k = 0; k < nz; ++k)
      for (int j = k % 2; j < ny; j += 2)
        for (int i = k % 2; i < nx; i += 2)
          if ((j - k) % 2 == 0) f({i, j - 2, k - 2});
  }
  bool is_in(const Point& p) const {
    return std::abs(p.i) < nx && p.j >= -2 && p.j < ny - 2 && p.k >= -2 && p.k < nz - 2;
  }
  std::size_t index(const Point& p) const {
    return std::abs(p.i) + std::size_t(nx) * ((p.j + 2) + std::size_t(ny) * (p.k + 2));
  }
  Vector at_rest(const Point& p) const {
    const double half = .5 * box.spacing;
    return {half * p.i, box.low_y + half * p.j, box.low_z + half * p.k};
  }
  double value_at(const Point& p) const { return is_in(p) ? value[index(p)] : 1; }

  // --- Cuts, and points that move to them

  // Where the segment from `inside` to `outside` leaves the shape.
  Vector cut(Vector inside, Vector outside) const {
    for (int halving = 0; halving < 40; ++halving) {
      const Vector middle = .5 * (inside + outside);
      (distance(middle) < 0 ? inside : outside) = middle;
    }
    return .5 * (inside + outside);
  }
  // Of the edge from p to q, whose values have different signs, both not moved.
  Cut& cut_between(const Point& p, const Point& q) {
    const std::size_t a = index(p), b = index(q);
    const auto [entry, is_new] = cuts.try_emplace(std::min(a, b) * place.size() + std::max(a, b));
    if (is_new) entry->second.place = value[a] < 0 ? cut(at_rest(p), at_rest(q)) : cut(at_rest(q), at_rest(p));
    return entry->second;
  }

  void move_to_surface(const Point& p) {
    const double here = value[index(p)];
    if (here == 0) return;
    double nearest = 1e300;
    Vector target = place[index(p)];
    for (const Point& edge : edges) {
      const Point q = p + edge;
      // In the middle, edges to the left mirror those to the right.
      if (!is_in(q) || q.i < 0 || !(here * value[index(q)] < 0)) continue;
      const Vector there = cut_between(p, q).place, way = there - at_rest(p);
      const double most = (is_long(edge) ? .24999 : .41189 * std::sqrt(.75)) * box.spacing;
      const double squared = dot(way, way);
      if (!(squared < most * most && squared < nearest)) continue;
      nearest = squared;
      target = p.i == 0 && edge.i != 0 ? within_middle(p, edge) : there;
    }
    if (nearest == 1e300) return;
    place[index(p)] = target;
    value[index(p)] = 0;
  }
  // For a point of the middle near a cut beside it: the cut of the edge's projection onto the middle; without one, the
  // point itself.
  Vector within_middle(const Point& p, const Point& edge) const {
    const Vector from = at_rest(p), to = at_rest(p + Point{0, edge.j, edge.k});
    const bool inside = value[index(p)] < 0;
    if ((distance(to) < 0) == inside) return from;
    return inside ? cut(from, to) : cut(to, from);
  }

  // --- Tetrahedra

  // About the long edges from a corner of a cell: each tetrahedron has one between corners and one between middles.
  void fill_about(const Point& p) {
    constexpr Point axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int axis = 0; axis < 3; ++axis) {
      const Point a = axes[axis], b = axes[(axis + 1) % 3], c = axes[(axis + 2) % 3];
      const Point middle = p + a, round[] = {b + c, b - c, Point{0, 0, 0} - b - c, c - b};
      if (!is_in(p + a + a)) continue;
      for (int k = 0; k < 4; ++k) fill({p, p + a + a, middle + round[k], middle + round[(k + 1) % 4]});
    }
  }

  // What is inside of a tetrahedron of the lattice.
  void fill(const std::array<Point, 4>& corner) {
    if (corner[2].i < 0 && corner[3].i < 0) return;  // made with its mirror image
    std::vector<Point> in, on, out;
    for (const Point& p : corner) (value_at(p) < 0 ? in : value_at(p) > 0 ? out : on).push_back(p);
    if (in.empty()) return;
    if (out.empty() || in.size() == 1) {
      std::vector<Node> t;
      for (const Point& p : in) t.push_back(node_at(p));
      for (const Point& p : on) t.push_back(node_at(p));
      for (const Point& p : out) t.push_back(node_at_cut(in[0], p));
      add(t[0], t[1], t[2], t[3]);
    } else if (out.size() == 1) {
      // Without a point on the surface, a tetrahedron is left above the pyramid: its tip is the cut of the long edge.
      std::partition(in.begin(), in.end(), [&](const Point& p) { return !is_long(p - out[0]); });
      const Node tip = on.empty() ? node_at_cut(in[2], out[0]) : node_at(on[0]);
      if (on.empty()) add(node_at(in[0]), node_at(in[1]), node_at(in[2]), tip);
      fill_pyramid(tip, cut_face(in[0], in[1], out[0]));
    } else {
      fill_wedge(in[0], in[1], out[0], out[1]);
    }
  }

  // Four nodes in turn, cut along the diagonal from the first to the third or from the second to the fourth; or, where
  // the face is its own mirror image, into four triangles about its centre.
  enum class Diagonal { first, second, none };
  struct Quadrilateral {
    std::array<Node, 4> node;
    Diagonal diagonal;
  };

  // What is inside of a face with two points inside and one outside. Both tetrahedra at the face must cut it alike.
  Quadrilateral cut_face(const Point& p, const Point& q, const Point& out) {
    const std::array<Node, 4> nodes = {node_at(p), node_at(q), node_at_cut(q, out), node_at_cut(p, out)};
    if (are_mirrored(p, q)) return {nodes, Diagonal::none};
    // To the cut of the long edge; or, where that is inside, from that of its ends with an even number of greater
    // coordinates than the point outside.
    bool at_p = is_long(q - out);
    if (is_long(p - q)) {
      const bool left = p.i < 0 || q.i < 0 || out.i < 0;
      at_p = ((left ? p.i < out.i : p.i > out.i) + (p.j > out.j) + (p.k > out.k)) % 2 == 0;
    }
    return {nodes, at_p ? Diagonal::first : Diagonal::second};
  }

  void fill_pyramid(const Node& tip, const Quadrilateral& base) {
    const auto& [a, b, c, d] = base.node;
    if (base.diagonal == Diagonal::none) {
      const Node centre = node_at_centre(base.node);
      for (int k = 0; k < 4; ++k) add(tip, centre, base.node[k], base.node[(k + 1) % 4]);
    } else if (base.diagonal == Diagonal::first) {
      add(tip, a, b, c);
      add(tip, a, c, d);
    } else {
      add(tip, a, b, d);
      add(tip, b, c, d);
    }
  }

  // Two points inside and two outside: a wedge with an edge from p to q, between the triangles (p, px, py) and
  // (q, qx, qy).
  void fill_wedge(const Point& inside, const Point& other, const Point& x, const Point& y) {
    const Quadrilateral at_x = cut_face(inside, other, x), at_y = cut_face(inside, other, y);
    const Node p = at_x.node[0], q = at_x.node[1], qx = at_x.node[2], px = at_x.node[3], qy = at_y.node[2],
               py = at_y.node[3];
    if (at_x.diagonal == Diagonal::none) {
      const Node centre = node_at_centre({px, py, qy, qx});
      add(centre, p, px, py);
      add(centre, q, qx, qy);
      fill_pyramid(centre, at_x);
      fill_pyramid(centre, at_y);
    } else if (at_x.diagonal == at_y.diagonal) {
      const bool at_p = at_x.diagonal == Diagonal::first;
      add(p, q, at_p ? qx : px, at_p ? qy : py);
      fill_pyramid(at_p ? p : q, {{px, py, qy, qx}, are_mirrored(x, y) ? Diagonal::none : Diagonal::first});
    } else if (at_x.diagonal == Diagonal::first) {
      add(p, py, px, qx);
      add(p, py, q, qx);
      add(py, q, qy, qx);
    } else {
      add(p, px, py, qy);
      add(p, px, q, qy);
      add(px, q, qx, qy);
    }
  }

  // --- Nodes

  static bool are_mirrored(const Point& p, const Point& q) { return p.i != 0 && mirrored(p) == q; }

  Node node_at(const Point& p) {
    std::int32_t& id = node_of_point[index(p)];
    if (id < 0) id = new_node(place[index(p)]);
    return {id, p.i < 0};
  }
  Node node_at_cut(const Point& p, const Point& q) {
    if (p.i < 0 || q.i < 0) return {node_at_cut(mirrored(p), mirrored(q)).id, true};
    Cut& cut = cut_between(p, q);
    if (cut.node < 0) cut.node = new_node(cut.place);
    return {cut.node, false};
  }
  // Of a face that is its own mirror image.
  Node node_at_centre(const std::array<Node, 4>& face) {
    std::array<std::int32_t, 4> ids;
    for (int k = 0; k < 4; ++k) ids[k] = 2 * face[k].id + face[k].mirrored;
    std::ranges::sort(ids);
    const auto [entry, is_new] = centres.try_emplace(ids, -1);
    if (is_new) {
      Vector sum = {0, 0, 0};
      for (const Node& node : face) sum = sum + half[node.id];
      entry->second = new_node({0, .25 * sum.y, .25 * sum.z});
    }
    return {entry->second, false};
  }
  std::int32_t new_node(const Vector& x) {
    half.push_back(x);
    return static_cast<std::int32_t>(half.size()) - 1;
  }

  // --- The mesh

  void add(const Node& a, const Node& b, const Node& c, const Node& d) {
    std::array<Node, 4> t = {a, b, c, d};
    const bool on_left = std::ranges::any_of(t, [](const Node& node) { return node.mirrored; });
    const bool on_right = std::ranges::any_of(t, [&](const Node& n) { return !n.mirrored && half[n.id].x > 0; });
    if (!on_right) return;  // made with its mirror image
    Vector x[4];
    for (int k = 0; k < 4; ++k) x[k] = t[k].mirrored ? mirrored(half[t[k].id]) : half[t[k].id];
    if (dot(x[1] - x[0], cross(x[2] - x[0], x[3] - x[0])) < 0) std::swap(t[2], t[3]);
    tetrahedra.push_back(t);
    if (on_left) return;
    for (Node& node : t) node.mirrored = half[node.id].x > 0;
    std::swap(t[2], t[3]);
    tetrahedra.push_back(t);
  }

  Mesh both_halves() const {
    Mesh mesh{half, {}};
    std::vector<std::int32_t> twin(half.size());
    for (std::size_t n = 0; n < half.size(); ++n) {
      twin[n] = static_cast<std::int32_t>(half[n].x > 0 ? mesh.nodes.size() : n);
      if (half[n].x > 0) mesh.nodes.push_back(mirrored(half[n]));
    }
    for (const std::array<Node, 4>& t : tetrahedra) {
      std::array<std::int32_t, 4>& corners = mesh.tetrahedra.emplace_back();
      for (int k = 0; k < 4; ++k) corners[k] = t[k].mirrored ? twin[t[k].id] : t[k].id;
    }
    return mesh;
  }

  const Distance& distance;
  const StuffedBox& box;
  const int nx, ny, nz;
  std::vector<Vector> place;  // of the lattice's points
  std::vector<double> value;  // there
  std::vector<std::int32_t> node_of_point;
  std::unordered_map<std::size_t, Cut> cuts;
  std::map<std::array<std::int32_t, 4>, std::int32_t> centres;
  std::vector<Vector> half;  // the nodes with x >= 0
  std::vector<std::array<Node, 4>> tetrahedra;
};

}  // namespace

Mesh stuff(const Distance& distance, const StuffedBox& box) { return Stuffing(distance, box).mesh(); }

}  // namespace lockstep::production_face
