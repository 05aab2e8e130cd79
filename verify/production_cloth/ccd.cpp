// Continuous collision detection, as the verifier and the benchmark see it: bitwise with the serial twin.
//
// A scene's cloth is crumpled, and then crumpled in another way: many layers pass through each other. The candidates
// are the pairs whose boxes over the step, with a margin of the thickness, overlap.
#include "common/production_cloth/ccd.h"

#include <cmath>
#include <random>

#include "verify/production_cloth/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_cloth_ccd {
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

struct Problem {
  Vectors<float> start, end;
  ElementPairs pairs;
};

Problem make_problem(const Scene& scene) {
  Problem problem = {crumpled(scene, 0), crumpled(scene, .2), {}};
  problem.pairs = pairs_within(scene.topology, problem.start, problem.end, static_cast<float>(scene.contact.thickness));
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

// Pairs, corners and both positions of vertices are read once: caches hold what many pairs share. The first two tests
// of a pair take about 170 operations.
Case make(const std::string& path) {
  const auto in = inputs(path);
  const auto problem = std::make_shared<const Problem>(make_problem(*in));
  const Topology& t = in->topology;
  const double pairs = problem->pairs.point_triangle.size() + problem->pairs.edge_edge.size(),
               bytes = sizeof(ElementPair) * pairs + 12. * t.triangles.size() + 8. * t.edges.size() + 24. * t.vertices;
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
      .work = {pairs, "pairs", bytes, 170. * pairs},
  });
}

const Register ccd{{.name = "production_cloth/ccd", .place = 5, .forms = {{.make = make, .scenes = all_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_cloth_ccd
