// Continuous collision detection, as the verifier and the benchmark see it: bitwise with the serial twin.
//
// A scene's cloth is crumpled, and then crumpled in another way: many layers pass through each other. The candidates
// are the pairs whose boxes over the step, with a margin of the thickness, overlap.
#include "common/production_cloth/ccd.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "verify/production_cloth/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify {
namespace {

using namespace production_cloth;
using namespace production_cloth_inputs;

// The cloth is pressed to a sixth of its width and laid in waves of some edges' length; `phase` moves the waves. Each
// vertex is shaken by a tenth of an edge, so that no two edges stay parallel.
Vectors<float> crumpled(const Scene& scene, double phase) {
  const Vectors<double>& rest = scene.rest;
  const auto& [a, b] = scene.topology.edges[0];
  const Vector3<double> along = load(rest, b) - load(rest, a);
  const double edge = std::sqrt(dot(along, along));
  std::mt19937 random(phase > 0);  // whose numbers the standard fixes
  const auto shake = [&] { return .1 * edge * (std::ldexp(random(), -32) - .5); };
  Vectors<float> result;
  result.resize(scene.topology.vertices);
  for (int i = 0; i < scene.topology.vertices; ++i) {
    const Vector3<double> p = (1 / edge) * load(rest, i);
    const double x = shake(), y = shake(), z = shake();
    const Vector3<double> waves = {p.x / 6 + 1.5 * std::sin(.31 * p.z + phase) + std::sin(.17 * p.y),
                                   p.y / 6 + 2 * std::sin(.4 * p.x + .23 * p.z + 2 * phase),
                                   p.z / 6 + 1.5 * std::sin(.29 * p.x - phase) + std::sin(.19 * p.y)};
    store(result, i,
          {static_cast<float>(edge * waves.x + x), static_cast<float>(edge * waves.y + y),
           static_cast<float>(edge * waves.z + z)});
  }
  return result;
}

struct Box {
  Vector3<float> least, greatest;
};
bool overlap(const Box& a, const Box& b) {
  return a.least.x <= b.greatest.x && b.least.x <= a.greatest.x && a.least.y <= b.greatest.y &&
         b.least.y <= a.greatest.y && a.least.z <= b.greatest.z && b.least.z <= a.greatest.z;
}

struct Problem {
  Vectors<float> start, end;
  ElementPairs pairs;
};

// Around the vertices over the step, and `margin` more.
template <std::size_t n>
Box box_of(const Problem& problem, const std::array<std::int32_t, n>& vertices, float margin) {
  const Vector3<float> first = load(problem.start, vertices[0]);
  Box box = {first, first};
  for (const std::int32_t v : vertices)
    for (const Vector3<float>& p : {load(problem.start, v), load(problem.end, v)}) {
      box.least = {min(box.least.x, p.x), min(box.least.y, p.y), min(box.least.z, p.z)};
      box.greatest = {max(box.greatest.x, p.x), max(box.greatest.y, p.y), max(box.greatest.z, p.z)};
    }
  const Vector3<float> around = {margin, margin, margin};
  return {box.least - around, box.greatest + around};
}

// Calls f(i, j) for the overlapping boxes i of a and j of b: a sweep along x over both.
template <class F>
void sweep(const std::vector<Box>& a, const std::vector<Box>& b, const F& f) {
  const auto in_order = [](const std::vector<Box>& boxes) {
    std::vector<std::int32_t> order(boxes.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::sort(order, {}, [&](std::int32_t i) { return std::pair(boxes[i].least.x, i); });
    return order;
  };
  const std::vector<std::int32_t> first = in_order(a), second = in_order(b);
  // Boxes of `others` that begin behind the beginning of each of `boxes`, and not behind its end.
  const auto one_way = [](const auto& boxes, const auto& order, const auto& others, const auto& order_of_others,
                          bool equal, const auto& g) {
    std::size_t begin = 0;
    for (const std::int32_t i : order) {
      const auto before = [&](const Box& box) {
        return equal ? box.least.x < boxes[i].least.x : box.least.x <= boxes[i].least.x;
      };
      while (begin < order_of_others.size() && before(others[order_of_others[begin]])) ++begin;
      for (std::size_t k = begin; k < order_of_others.size(); ++k) {
        const std::int32_t j = order_of_others[k];
        if (others[j].least.x > boxes[i].greatest.x) break;
        if (overlap(boxes[i], others[j])) g(i, j);
      }
    }
  };
  one_way(a, first, b, second, true, f);
  one_way(b, second, a, first, false, [&](std::int32_t j, std::int32_t i) { f(i, j); });
}

Problem make_problem(const Scene& scene) {
  const Topology& topology = scene.topology;
  Problem problem = {crumpled(scene, 0), crumpled(scene, .2), {}};
  const auto margin = static_cast<float>(scene.contact.thickness);
  std::vector<Box> points, triangles, edges;
  for (std::int32_t v = 0; v < topology.vertices; ++v) points.push_back(box_of(problem, std::array{v}, margin));
  for (std::size_t t = 0; t < topology.triangles.size(); ++t)
    triangles.push_back(box_of(problem, topology.corners(t), margin));
  for (const auto& edge : topology.edges) edges.push_back(box_of(problem, edge, margin));

  const auto all_differ = [](std::array<std::int32_t, 4> v) {
    std::ranges::sort(v);
    return std::ranges::adjacent_find(v) == v.end();
  };
  ElementPairs& pairs = problem.pairs;
  sweep(points, triangles, [&](std::int32_t v, std::int32_t t) {
    if (all_differ(corners_of_point_triangle(topology, {v, t}))) pairs.point_triangle.push_back({v, t});
  });
  sweep(edges, edges, [&](std::int32_t e, std::int32_t f) {
    if (e < f && all_differ(corners_of_edge_edge(topology, {e, f}))) pairs.edge_edge.push_back({e, f});
  });
  std::ranges::sort(pairs.point_triangle), std::ranges::sort(pairs.edge_edge);
  return problem;
}

struct State {
  Contacts<float> impacts;
  std::shared_ptr<production_cloth::openmp::CcdMemory> memory;
};
template <Same<State> S, class F>
void for_each_array(S& state, const F& f) {
  for_each_array(state.impacts, f);
}

// An access of a vertex reads 24 bytes, and a pair has four of them. The first two tests take about 170 operations.
Case make(const std::string& path) {
  const auto in = inputs(path);
  const auto problem = std::make_shared<const Problem>(make_problem(*in));
  const double pairs = problem->pairs.point_triangle.size() + problem->pairs.edge_edge.size();
  return make_case<State>({
      .start = std::make_shared<const State>(State{{}, std::make_shared<production_cloth::openmp::CcdMemory>()}),
      .serial =
          [=](State& s) {
            production_cloth::serial::ccd(in->topology, problem->pairs, problem->start, problem->end, s.impacts);
          },
      .best_serial = nullptr,
      .openmp =
          [=](State& s) {
            production_cloth::openmp::ccd(in->topology, problem->pairs, problem->start, problem->end, *s.memory,
                                          s.impacts);
          },
      .compare = nullptr,
      .work = {pairs, "pairs", (8. + 96) * pairs, 170. * pairs},
  });
}

const Register ccd{{.name = "production_cloth/ccd", .place = 5, .forms = {{.make = make, .scenes = all_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify
