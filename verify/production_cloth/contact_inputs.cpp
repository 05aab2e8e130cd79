#include "verify/production_cloth/contact_inputs.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "common/production_cloth/contact_batches.h"
#include "verify/inputs.h"

namespace lockstep::production_cloth {

double bytes_of(const ContactInputs& in) {
  return lockstep::bytes_of(in.pairs) + lockstep::bytes_of(in.excluded) + lockstep::bytes_of(in.nearby) +
         40. * static_cast<double>(in.inverse_mass.size());
}

}  // namespace lockstep::production_cloth

namespace lockstep::verify::production_cloth_inputs {
namespace {

using namespace production_cloth;

// --- A folded cloth

double longest_edge(const Topology& topology, const Vectors<double>& rest) {
  double longest = 0;
  for (const auto& [a, b] : topology.edges) {
    const Vector3<double> e = load(rest, a) - load(rest, b);
    longest = std::max(longest, dot(e, e));
  }
  return std::sqrt(longest);
}

void fold(const Scene& scene, ContactInputs& in) {
  constexpr int layers = 4;
  const double thickness = scene.contact.thickness, edge = longest_edge(scene.topology, scene.rest), pinched = 3 * edge;
  const int n = scene.topology.vertices;
  const auto [least, greatest] = std::minmax_element(scene.rest.x.begin(), scene.rest.x.begin() + n);
  const double length = (*greatest - *least) / layers;
  const Vector3<double> centre = {*least + .5 * length, scene.rest.y[0], scene.rest.z[n / 2]};
  std::mt19937 random;  // whose numbers the standard fixes
  const auto shake = [&] { return static_cast<double>(random() >> 8) / (1 << 24) - .5; };
  in.position.resize(n), in.velocity.resize(n);
  for (int i = 0; i < n; ++i) {
    const Vector3<double> rest = load(scene.rest, i);
    const int layer = std::clamp(static_cast<int>((rest.x - *least) / length), 0, layers - 1);
    const double along = rest.x - *least - layer * length;
    Vector3<double> p = {*least + (layer % 2 ? length - along : along), rest.y + .6 * thickness * layer, rest.z};
    p = p + layer * edge * Vector3<double>{.37, 0, .21};  // so that layers' vertices do not face each other
    const double radius = std::hypot(p.x - centre.x, p.z - centre.z) / pinched;
    if (radius < 1) {
      const double drawn = .1 + .9 * radius * radius;
      p.x = centre.x + drawn * (p.x - centre.x), p.z = centre.z + drawn * (p.z - centre.z);
    }
    const double x = shake(), y = shake(), z = shake();
    p = p + .1 * thickness * Vector3<double>{x, y, z};
    store(in.position, i, {float(p.x), float(p.y), float(p.z)});
    const double vx = shake(), vy = shake(), vz = shake();
    store(in.velocity, i, {float(.3 * vx), float(.3 * vy - .2 * (layer - 1.5)), float(.3 * vz)});
  }
}

// --- Pairs, by a grid

struct Box {
  Vector3<double> low, high;
};

Box box_of(const Vectors<float>& position, std::initializer_list<std::int32_t> corners, double margin) {
  Box box = {{1e30, 1e30, 1e30}, {-1e30, -1e30, -1e30}};
  for (const std::int32_t v : corners) {
    const double x = position.x[v], y = position.y[v], z = position.z[v];
    box.low = {std::min(box.low.x, x), std::min(box.low.y, y), std::min(box.low.z, z)};
    box.high = {std::max(box.high.x, x), std::max(box.high.y, y), std::max(box.high.z, z)};
  }
  const Vector3<double> m = {margin, margin, margin};
  return {box.low - m, box.high + m};
}

using Cell = std::array<std::int64_t, 3>;

template <class F>
void for_each_cell(const Box& box, double size, const F& f) {
  const auto cell = [&](double x) { return static_cast<std::int64_t>(std::floor(x / size)); };
  for (auto x = cell(box.low.x); x <= cell(box.high.x); ++x)
    for (auto y = cell(box.low.y); y <= cell(box.high.y); ++y)
      for (auto z = cell(box.low.z); z <= cell(box.high.z); ++z) f(Cell{x, y, z});
}

// Calls f(i, j) once for all boxes a[i], b[j] that overlap.
template <class F>
void for_each_overlap(const std::vector<Box>& a, const std::vector<Box>& b, double size, const F& f) {
  std::vector<std::pair<Cell, std::int32_t>> inside;
  for (std::size_t j = 0; j < b.size(); ++j)
    for_each_cell(b[j], size, [&](const Cell& cell) { inside.emplace_back(cell, j); });
  std::ranges::sort(inside);
  for (std::size_t i = 0; i < a.size(); ++i)
    for_each_cell(a[i], size, [&](const Cell& cell) {
      for (auto at = std::ranges::lower_bound(inside, std::pair(cell, std::int32_t(0)));
           at != inside.end() && at->first == cell; ++at) {
        const Box& other = b[at->second];
        const Box common = {
            {std::max(a[i].low.x, other.low.x), std::max(a[i].low.y, other.low.y), std::max(a[i].low.z, other.low.z)},
            {std::min(a[i].high.x, other.high.x), std::min(a[i].high.y, other.high.y),
             std::min(a[i].high.z, other.high.z)}};
        if (common.low.x > common.high.x || common.low.y > common.high.y || common.low.z > common.high.z) continue;
        bool first = true;  // the pair is found in each cell of what is common; it counts in the first
        for_each_cell({common.low, common.low}, size, [&](const Cell& lowest) { first = lowest == cell; });
        if (first) f(static_cast<std::int32_t>(i), at->second);
      }
    });
}

template <std::size_t n, std::size_t m>
bool meet(const std::array<std::int32_t, n>& a, const std::array<std::int32_t, m>& b) {
  return std::ranges::find_first_of(a, b) != a.end();
}

ElementPairs pairs_of(const Topology& topology, const Vectors<float>& position, double thickness, double size) {
  std::vector<Box> points, edges, triangles;
  for (int v = 0; v < topology.vertices; ++v) points.push_back(box_of(position, {v}, thickness / 2));
  for (const auto& [a, b] : topology.edges) edges.push_back(box_of(position, {a, b}, thickness / 2));
  for (const auto& [a, b, c] : topology.triangles) triangles.push_back(box_of(position, {a, b, c}, thickness / 2));
  ElementPairs pairs;
  for_each_overlap(points, triangles, size, [&](std::int32_t a, std::int32_t b) {
    if (!meet(std::array{a}, topology.corners(b))) pairs.point_triangle.push_back({a, b});
  });
  for_each_overlap(edges, edges, size, [&](std::int32_t a, std::int32_t b) {
    if (a < b && !meet(topology.edges[a], topology.edges[b])) pairs.edge_edge.push_back({a, b});
  });
  std::ranges::sort(pairs.point_triangle), std::ranges::sort(pairs.edge_edge);
  return pairs;
}

}  // namespace

std::shared_ptr<const ContactInputs> contact_inputs(const std::string& path) {
  return lockstep::verify::inputs<ContactInputs>(path, [&] {
    ContactInputs in;
    in.scene = inputs(path);
    const Scene& scene = *in.scene;
    const double size = longest_edge(scene.topology, scene.rest), thickness = scene.contact.thickness;
    in.time_step = static_cast<float>(scene.frame_time / scene.substeps);
    in.inverse_mass = inverse_masses(scene);
    fold(scene, in);
    in.pairs = pairs_of(scene.topology, in.position, thickness, size);
    for (std::size_t k = 3; k < in.pairs.point_triangle.size(); k += 7)
      in.excluded.point_triangle.push_back(in.pairs.point_triangle[k]);
    for (std::size_t k = 4; k < in.pairs.edge_edge.size(); k += 7)
      in.excluded.edge_edge.push_back(in.pairs.edge_edge[k]);
    serial::near_contacts(scene.topology, in.pairs, in.excluded, in.position, static_cast<float>(thickness), in.nearby);
    return in;
  });
}

double approach_of(const Contacts<float>& contacts, const Vectors<float>& velocity) {
  double sum = 0;
  for (std::size_t k = 0; k < contacts.count; ++k) {
    Vector3<float> relative = {0, 0, 0};
    for (std::size_t i = 0; i < 4; ++i)
      relative = relative + contacts.weight[4 * k + i] * load(velocity, contacts.corner[4 * k + i]);
    const float* const n = &contacts.normal[4 * k];
    const double speed = std::min(dot(relative, {n[0], n[1], n[2]}), 0.f);
    sum += speed * speed;
  }
  return sum;
}

double lane_use_of_batches(const ContactInputs& in) {
  const Batches batches = make_contact_batches(in.nearby, in.inverse_mass);
  std::vector<int> lengths;
  for (int k = 0; k < batches.count(); ++k) lengths.push_back(batches.begin[k + 1] - batches.begin[k]);
  return lanes_in_use(lengths);
}

Work work_of_contacts(const ContactInputs& in, double lane_use) {
  const double n = static_cast<double>(in.nearby.count);
  return {n, "contacts", n * 4 * (12 + 4 * 7), 150 * n, lane_use};
}

}  // namespace lockstep::verify::production_cloth_inputs
