// Elastic forces, as the verifier and the benchmark see them: bitwise with the serial twin of the same order; under
// locks, within the rounding of sums in any order. notes/production_cloth.md derives the bound.
#include "common/production_cloth/forces.h"

#include <cmath>
#include <limits>

#include "verify/production_cloth/deformed.h"
#include "verify/twin.h"

namespace lockstep::production_cloth {

struct ForceState {
  Vectors<float> force;
};

template <Same<ForceState> S, class F>
void for_each_array(S& state, const F& f) {
  f("force", state.force, state.force.x.size());
}

}  // namespace lockstep::production_cloth

namespace lockstep::verify::production_cloth_forces {
namespace {

using namespace production_cloth;
using namespace production_cloth_inputs;

// The exact sums of the parts, which are the same floats in all versions, and how far a float sum may be from them: u
// for each of the vertex's terms, of the sum of their sizes.
struct ForceSums {
  std::vector<double> exact, size;  // [3 v + c]
  std::vector<int> terms;

  void add(int vertex, const Vector3<float>& part) {
    const float components[] = {part.x, part.y, part.z};
    for (int c = 0; c < 3; ++c) exact[3 * vertex + c] += components[c], size[3 * vertex + c] += std::abs(components[c]);
    ++terms[vertex];
  }
};

ForceSums sums_of(const Elements<float>& e, const Vectors<float>& x) {
  ForceSums sums = {std::vector<double>(3 * e.vertices), std::vector<double>(3 * e.vertices),
                    std::vector<int>(e.vertices)};
  for (int k = 0; k < e.links; ++k) {
    const Vector3<float> d = load(x, e.to[k]) - load(x, e.from[k]);
    Vector3<float> part = {0, 0, 0};
    if (e.has_bending) part = e.bending[k] * d;
    if (e.has_springs && k < e.edges)
      part = part + pull_of_spring(e.rest_length[k], e.spring[k], e.root_of_damping[k], d).force;
    sums.add(e.from[k], part), sums.add(e.to[k], -part);
  }
  for (int t = 0; t < e.membranes; ++t) {
    const auto corner = [&](int c) { return e.membrane_corner.at(t, c); };
    const auto m = membrane_of<float>(e, [&](const Blocked<float>& array, int f) { return array.at(t, f); });
    const Vector3<float> x0 = load(x, corner(0));
    const auto f = deformation_of(m, load(x, corner(1)) - x0, load(x, corner(2)) - x0);
    const auto parts = parts_of_membrane(m, stress_of_membrane(e, f));
    for (int c = 0; c < 3; ++c) sums.add(corner(c), parts.of[c]);
  }
  const auto corner = [&](int t, int c) { return e.facet_corner[e.place_of(t, c)]; };
  const auto facet = [&](int t) {
    return facet_of(load(x, corner(t, 0)), load(x, corner(t, 1)), load(x, corner(t, 2)));
  };
  for (int t = 0; t < e.facets; ++t) {
    const Facet<float> own = facet(t);
    const auto torque = [&](int c) {
      const int side = e.place_of(t, c);
      const Facet<float> beside = facet(e.facet_beside[side]);
      return resistance_of_hinge(e.hinge_stiffness, e.rest_sine_at[side], e.root_of_damping_at[side], own.normal,
                                 own.size, beside.normal, beside.size,
                                 load(x, corner(t, (c + 2) % 3)) - load(x, corner(t, (c + 1) % 3)))
          .torque;
    };
    const Sides<float> push = pushes_of_facet(own.at, {torque(0), torque(1), torque(2)});
    for (int c = 0; c < 3; ++c) sums.add(corner(t, c), push.of[c] * own.normal);
  }
  return sums;
}

// All components of all vertices.
Judgement within_rounding(const ForceSums& sums, const ForceState& openmp, const ForceState& serial) {
  Judgement judgement{.verdict = Verdict::bounded, .worst_at = ""};
  const std::size_t n = sums.terms.size();
  std::vector<float> of_openmp, of_serial;
  std::vector<double> rounding;
  for (std::size_t v = 0; v < n; ++v) {
    const Vector3<float> a = load(openmp.force, v), b = load(serial.force, v);
    of_openmp.insert(of_openmp.end(), {a.x, a.y, a.z}), of_serial.insert(of_serial.end(), {b.x, b.y, b.z});
    for (int c = 0; c < 3; ++c) rounding.push_back(sums.terms[v] * unit_roundoff * sums.size[3 * v + c]);
  }
  within_bound(judgement, of_openmp, of_serial, sums.exact, rounding, [](std::size_t k) {
    return "xyz"[k % 3] + (" of vertex " + std::to_string(k / 3));
  });
  return judgement;
}

// A link reads two positions and at most four numbers, and writes three; a membrane and a folding triangle read their
// corners, and 7 and 9 numbers, and write 6 and 13. The operations: about 30, 110 and 200.
Work work_of(const Elements<float>& e) {
  const double edges = std::max({e.edges, e.hinges, e.membranes * 3 / 2});
  return {edges, "edges",
          4 * (7. * e.edges + 3. * (e.links - e.edges) + 13. * e.membranes + 25. * e.facets + 6. * e.vertices),
          30. * e.edges + 9. * (e.links - e.edges) + 110. * e.membranes + 200. * e.facets,
          2. * e.links / std::max<double>(1, e.edges_at.at.size() + e.far_at.at.size())};
}

enum class How { gather, recompute, colours, locks };

Case make(const std::string& path, How how) {
  const auto in = inputs(path);
  const auto elements = elements_of(*in);
  const auto position = std::make_shared<const Vectors<float>>(deformed_positions(*in));
  const auto serial_state = std::make_shared<State<float>>(production_cloth::serial::make_state(*elements));
  const auto openmp_state = std::make_shared<State<float>>(production_cloth::openmp::make_state(*elements));
  ForceState start;
  start.force.resize(elements->vertices);
  poison(start);
  const bool locks = how == How::locks;
  const auto sums = std::make_shared<const ForceSums>(locks ? sums_of(*elements, *position) : ForceSums{});
  const auto colours = std::make_shared<const Colours>(how == How::colours ? make_colours(*elements) : Colours{});
  const auto bounded = [sums](const ForceState& openmp, const ForceState& serial) {
    return within_rounding(*sums, openmp, serial);
  };
  const auto original = [=](ForceState& s) {
    production_cloth::serial::forces(*elements, *position, *serial_state, s.force);
  };
  const auto in_colours = [=](ForceState& s) {
    production_cloth::serial::forces_colours(*elements, *colours, *position, *serial_state, s.force);
  };
  using Run = std::function<void(ForceState&)>;
  return make_case<ForceState>({
      .start = std::make_shared<const ForceState>(start),
      .serial = how == How::colours ? Run(in_colours) : Run(original),
      .best_serial = how == How::colours ? Run(original) : Run(),
      .openmp =
          [=](ForceState& s) {
            using namespace production_cloth::openmp;
            if (how == How::gather) forces(*elements, *position, *openmp_state, s.force);
            if (how == How::recompute) forces_recompute(*elements, *position, *openmp_state, s.force);
            if (how == How::colours) forces_colours(*elements, *colours, *position, *openmp_state, s.force);
            if (how == How::locks) forces_locks(*elements, *position, *openmp_state, s.force);
          },
      .compare = locks ? bounded : std::function<Judgement(const ForceState&, const ForceState&)>(),
      .work = work_of(*elements),
  });
}

Form form(const char* name, How how) {
  Scenes scenes = material_scenes();
  scenes.bench.push_back("curtain_and_ball_55k");  // with hinges
  return {.name = name,
          .make = [how](const std::string& path) { return make(path, how); },
          .scenes = scenes,
          .order_dependent = how == How::locks};
}

const Register forces{{.name = "production_cloth/forces",
                       .place = 1,
                       .serial_forms = {"original", "colours"},
                       .forms = {form("gather", How::gather), form("recompute", How::recompute),
                                 form("colours", How::colours), form("locks", How::locks)}}};

}  // namespace
}  // namespace lockstep::verify::production_cloth_forces
