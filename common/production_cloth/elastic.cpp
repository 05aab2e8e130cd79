#include "common/production_cloth/elastic.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "common/convert.h"
#include "common/production_cloth/element_forces.h"
#include "common/production_cloth/masses.h"

namespace lockstep::production_cloth {
namespace {

using Vector = Vector3<double>;
double length_of(const Vector& v) { return std::sqrt(dot(v, v)); }
double area_of(const Vector& a, const Vector& b, const Vector& c) { return .5 * length_of(cross(b - a, c - a)); }
// Of the angle at `at`.
double cotangent(const Vector& at, const Vector& a, const Vector& b) {
  return dot(a - at, b - at) / length_of(cross(a - at, b - at));
}

struct Link {
  std::array<std::int32_t, 2> vertices;
  double bending;
};

// The edges, then the far vertices of hinges; with the weights of quadratic bending.
std::vector<Link> links_of(const Topology& topology, const Vectors<double>& rest, const Material& material) {
  std::vector<Link> links, far;
  for (const auto& edge : topology.edges) links.push_back({edge, 0});
  if (material.bend != Bend::quadratic) return links;
  const auto before = [](const Link& a, const Link& b) { return a.vertices < b.vertices; };
  const auto edges_end = links.begin() + static_cast<std::ptrdiff_t>(links.size());
  const auto add = [&](std::int32_t a, std::int32_t b, double weight) {
    const Link link = {{std::min(a, b), std::max(a, b)}, weight};
    const auto edge = std::lower_bound(links.begin(), edges_end, link, before);
    if (edge != edges_end && edge->vertices == link.vertices)
      edge->bending += weight;
    else
      far.push_back(link);
  };
  for (const auto& corner : topology.hinges) {
    const Vector x0 = load(rest, corner[0]), x1 = load(rest, corner[1]), x2 = load(rest, corner[2]),
                 x3 = load(rest, corner[3]);
    const double c = 3 * material.bending / (area_of(x0, x2, x3) + area_of(x1, x2, x3));
    const double at2_first = cotangent(x2, x3, x0), at3_first = cotangent(x3, x2, x0),
                 at2_second = cotangent(x2, x3, x1), at3_second = cotangent(x3, x2, x1);
    const double k[] = {-(at2_first + at3_first), -(at2_second + at3_second), at3_first + at3_second,
                        at2_first + at2_second};
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j) add(corner[i], corner[j], -c * k[i] * k[j]);
  }
  std::ranges::stable_sort(far, before);
  for (const Link& link : far)
    if (links.size() > topology.edges.size() && links.back().vertices == link.vertices)
      links.back().bending += link.bending;
    else
      links.push_back(link);
  return links;
}

// Lists given vertex by vertex as slices; item(vertex, k) stands for its item k, filler(vertex) for what fills up.
template <class Item, class Filler>
Slices slices_of(const std::vector<std::vector<std::int32_t>>& lists, const Item& item, const Filler& filler) {
  Slices slices;
  slices.first.push_back(0);
  const int vertices = static_cast<int>(lists.size());
  for (int begin = 0; begin < vertices; begin += lanes) {
    std::size_t longest = 0;
    for (int v = begin; v < std::min(begin + lanes, vertices); ++v) longest = std::max(longest, lists[v].size());
    for (std::size_t k = 0; k < longest; ++k)
      for (int v = begin; v < begin + lanes; ++v)
        slices.at.push_back(v < vertices && k < lists[v].size() ? item(v, lists[v][k]) : filler(v));
    slices.first.push_back(static_cast<std::int32_t>(slices.at.size() / lanes));
  }
  return slices;
}

// Calls f(link, item, lane) for each link of each vertex, with its place in the slices.
template <class F>
void for_each_item(const std::vector<std::vector<std::int32_t>>& lists, const Slices& slices, const F& f) {
  for (std::size_t v = 0; v < lists.size(); ++v)
    for (std::size_t k = 0; k < lists[v].size(); ++k) f(lists[v][k], slices.first[v / lanes] + k, v % lanes);
}

template <class Real>
void add_links(const Topology& topology, const Vectors<double>& rest, const Material& material,
               const Array<double>& mass, Elements<Real>& e) {
  e.has_springs = material.stretch == Stretch::springs, e.has_bending = material.bend == Bend::quadratic;
  if (!e.has_springs && !e.has_bending) {
    e.edges_at = e.far_at = slices_of(
        std::vector<std::vector<std::int32_t>>(topology.vertices), [](int, int k) { return k; },
        [](int v) { return v; });
    return;
  }
  const std::vector<Link> links = links_of(topology, rest, material);
  e.edges = static_cast<int>(topology.edges.size()), e.links = static_cast<int>(links.size());
  e.bend_damping = static_cast<Real>(material.bend_damping);
  e.from.resize(padded(e.links)), e.to.resize(padded(e.links)), e.bending.resize(padded(e.links));
  for (Array<Real>* array : {&e.rest_length, &e.spring, &e.root_of_damping}) array->resize(padded(e.edges));
  std::vector<std::vector<std::int32_t>> edges_at(e.vertices), far_at(e.vertices);
  for (int k = 0; k < e.links; ++k) {
    const auto [a, b] = links[k].vertices;
    e.from[k] = a, e.to[k] = b, e.bending[k] = static_cast<Real>(links[k].bending);
    for (const std::int32_t v : links[k].vertices) (k < e.edges ? edges_at : far_at)[v].push_back(k);
    if (k >= e.edges || !e.has_springs) continue;
    const Vector3<Real> d = convert<Real>(load(rest, b)) - convert<Real>(load(rest, a));
    e.rest_length[k] = sqrt(dot(d, d));
    const double length = e.rest_length[k], harmonic = 1 / (1 / mass[a] + 1 / mass[b]);
    e.spring[k] = static_cast<Real>(material.stiffness / length);
    const double damping = material.stretch_damping * 2 * std::sqrt(material.stiffness * length * harmonic);
    e.root_of_damping[k] = static_cast<Real>(std::sqrt(damping / length));
  }
  const auto other = [&](int v, int k) { return e.from[k] == v ? e.to[k] : e.from[k]; };
  const auto itself = [&](int v) { return v; };
  e.edges_at = slices_of(edges_at, other, itself), e.far_at = slices_of(far_at, other, itself);
  e.spring_at.resize(3 * e.edges_at.at.size());
  e.edge_bending_at.resize(e.edges_at.at.size()), e.far_bending_at.resize(e.far_at.at.size());
  for_each_item(edges_at, e.edges_at, [&](int k, std::size_t item, std::size_t lane) {
    e.edge_bending_at[lanes * item + lane] = e.bending[k];
    const Real fields[] = {e.rest_length[k], e.spring[k], e.root_of_damping[k]};
    for (std::size_t f = 0; f < 3; ++f) e.spring_at[lanes * (3 * item + f) + lane] = fields[f];
  });
  for_each_item(far_at, e.far_at, [&](int k, std::size_t item, std::size_t lane) {
    e.far_bending_at[lanes * item + lane] = e.bending[k];
  });
}

template <class Real>
void add_membranes(const Topology& topology, const Vectors<double>& rest, const Material& material, Elements<Real>& e) {
  e.membranes = static_cast<int>(topology.triangles.size());
  e.corotated = material.stretch == Stretch::corotated;
  const double nu = material.poisson;
  e.lambda = static_cast<Real>(material.membrane * nu / (1 - nu * nu));
  e.mu = static_cast<Real>(material.membrane / (2 * (1 + nu)));
  e.membrane_damping = static_cast<Real>(material.stretch_damping);
  e.membrane_corner = {3, e.membrane_corner_blocks()}, e.membrane = {4, e.membrane_corner_blocks()};
  for (int t = 0; t < lanes * e.membrane_corner_blocks(); ++t) {
    const auto corner = topology.corners(std::min(t, e.membranes - 1));
    const Vector a = load(rest, corner[0]), first = load(rest, corner[1]) - a, second = load(rest, corner[2]) - a;
    const double width = length_of(first), along = dot(first, second) / width,
                 height = length_of(cross(first, second)) / width;
    const double fields[] = {1 / width, -along / (width * height), 1 / height, .5 * width * height};
    for (int f = 0; f < 4; ++f) e.membrane.at(t, f) = static_cast<Real>(fields[f]);
    for (int c = 0; c < 3; ++c) e.membrane_corner.at(t, c) = corner[c];
  }
}

// Critical damping is that of theta alone: K = k |e|^2 / (2 (|N1| + |N2|)) at rest, and the mass 1 / sum |u_i|^2 / m_i.
template <class Real>
void add_hinges(const Topology& topology, const Vectors<double>& rest, const Material& material,
                const Array<double>& mass, Elements<Real>& e) {
  e.hinges = static_cast<int>(topology.hinges.size());
  e.hinge_stiffness = static_cast<Real>(material.bending);
  e.hinge_corner = {4, e.hinge_corner_blocks()}, e.hinge = {2, e.hinge_corner_blocks()};
  for (int h = 0; h < lanes * e.hinge_corner_blocks(); ++h) {
    const auto& corner = topology.hinges[std::min(h, e.hinges - 1)];
    const Fold<double> fold =
        fold_of(load(rest, corner[0]), load(rest, corner[1]), load(rest, corner[2]), load(rest, corner[3]));
    double inverse_mass = 0;
    for (int c = 0; c < 4; ++c) inverse_mass += dot(fold.slope[c], fold.slope[c]) / mass[corner[c]];
    const double damping = material.bend_damping * 2 * std::sqrt(.5 * material.bending * fold.shape / inverse_mass);
    e.hinge.at(h, 1) = static_cast<Real>(std::sqrt(damping));
    for (int c = 0; c < 4; ++c) e.hinge_corner.at(h, c) = corner[c];
  }
}

template <class Real>
void add_facets(const Topology& topology, const Vectors<double>& rest, Elements<Real>& e) {
  e.facets = static_cast<int>(topology.triangles.size());
  for (Array<std::int32_t>* array : {&e.facet_corner, &e.beside, &e.facet_beside}) array->resize(e.last_place());
  e.rest_sine_at.resize(e.last_place()), e.root_of_damping_at.resize(e.last_place());
  e.hinge_side = {2, e.hinge_corner_blocks()};
  std::vector<std::vector<std::int32_t>> sides_of(topology.edges.size());
  for (int t = 0; t < lanes * e.facet_blocks(); ++t)
    for (int c = 0; c < 3; ++c) {
      const int triangle = std::min(t, e.facets - 1);
      e.facet_corner[e.place_of(t, c)] = topology.corners(triangle)[c], e.beside[e.place_of(t, c)] = e.place_of(t, c);
      if (t < e.facets) sides_of[topology.edges_of[t][c]].push_back(e.place_of(t, c));
    }
  // In Real, of positions in Real: at rest forces find the same bits.
  const auto x = [&](int vertex) { return convert<Real>(load(rest, vertex)); };
  const auto normal_at = [&](int place) {
    const auto corner = topology.corners(e.triangle_of(place));
    return facet_of(x(corner[0]), x(corner[1]), x(corner[2])).normal;
  };
  // Hinges are in the order of their edges, with two sides each, of which corner 0's comes first.
  int h = 0;
  for (const auto& sides : sides_of)
    if (sides.size() == 2) {
      e.beside[sides[0]] = sides[1], e.beside[sides[1]] = sides[0];
      e.hinge.at(h, 0) = sine_of_fold(normal_at(sides[0]), normal_at(sides[1]),
                                      x(e.hinge_corner.at(h, 3)) - x(e.hinge_corner.at(h, 2)));
      for (int k = 0; k < 2; ++k) {
        e.hinge_side.at(h, k) = sides[k];
        e.rest_sine_at[sides[k]] = e.hinge.at(h, 0), e.root_of_damping_at[sides[k]] = e.hinge.at(h, 1);
      }
      ++h;
    }
  for (std::size_t place = 0; place < e.beside.size(); ++place) e.facet_beside[place] = e.triangle_of(e.beside[place]);
  for (; h < lanes * e.hinge_corner_blocks(); ++h)
    for (int k = 0; k < 2; ++k) e.hinge_side.at(h, k) = e.hinge_side.at(e.hinges - 1, k);
}

// The vector in which lane 0 of each group finds what it wants: it comes first.
auto first_of(const Array<std::int32_t>& at, int together) {
  return [&at, together](std::size_t group) { return at[lanes * together * group] / lanes; };
}
Picks<1, 2> picks_of_lists(const Slices& lists) {
  std::vector<std::int32_t> slice_of;  // [item]
  for (std::size_t s = 0; s + 1 < lists.first.size(); ++s) slice_of.resize(lists.first[s + 1], static_cast<int>(s));
  return make_picks<1, 2>(lists.at, slice_vectors, [&](std::size_t item) { return slice_of[item]; });
}

}  // namespace

template <class Real>
Elements<Real> make_elements(const Topology& topology, const Vectors<double>& rest, const Material& material) {
  Elements<Real> e;
  e.vertices = topology.vertices;
  const Array<double> mass = lumped_masses(topology, rest, material.density);
  add_links(topology, rest, material, mass, e);
  if (material.stretch != Stretch::springs) add_membranes(topology, rest, material, e);
  if (material.bend == Bend::hinges && !topology.hinges.empty()) add_hinges(topology, rest, material, mass, e);
  if (e.hinges > 0) add_facets(topology, rest, e);
  std::vector<std::vector<std::int32_t>> corners_at(e.vertices);
  for (int t = 0; t < std::max(e.membranes, e.facets); ++t)
    for (int c = 0; c < 3; ++c) corners_at[topology.corners(t)[c]].push_back(e.place_of(t, c));
  e.corners_at = slices_of(
      corners_at, [](int, int place) { return place; }, [&](int) { return e.last_place(); });
  e.facet_at.resize(e.corners_at.at.size());
  for (std::size_t k = 0; k < e.facet_at.size(); ++k)
    if (const int place = e.corners_at.at[k]; place < e.last_place()) e.facet_at[k] = e.triangle_of(place);
  e.edge_picks = picks_of_lists(e.edges_at), e.far_picks = picks_of_lists(e.far_at);
  const Array<std::int32_t>& corners = e.facets > 0 ? e.facet_corner : e.membrane_corner.value;
  e.corner_picks = make_picks<3, 2>(corners, slice_vectors, first_of(corners, 3));
  e.beside_picks = make_picks<1, 3>(e.beside, 1, first_of(e.beside, 1));
  return e;
}

template Elements<float> make_elements(const Topology& topology, const Vectors<double>& rest, const Material& material);
template Elements<double> make_elements(const Topology& topology, const Vectors<double>& rest,
                                        const Material& material);

}  // namespace lockstep::production_cloth
