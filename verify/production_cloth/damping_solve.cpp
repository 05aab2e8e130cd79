// The implicit damping, as the verifier and the benchmark see it: bitwise with the serial twin, iteration by iteration,
// each on the state that its own `forces` has made.
#include "common/production_cloth/damping_solve.h"

#include <algorithm>
#include <cstdio>

#include "common/production_cloth/masses.h"
#include "verify/production_cloth/deformed.h"
#include "verify/twin.h"

namespace lockstep::production_cloth {

// What a solve changes: velocities, and what the next guess is made of; iterations, and |r| / |b|.
struct Damped {
  Vectors<float> velocity;
  Changes<float> changes;
  Array<double> number;
};

template <Same<Damped> S, class F>
void for_each_array(S& damped, const F& f) {
  f("velocity", damped.velocity, damped.velocity.x.size());
  for_each_array(damped.changes, f);
  f("number", damped.number, damped.number.size());
}

}  // namespace lockstep::production_cloth

namespace lockstep::verify::production_cloth_damping_solve {
namespace {

using namespace production_cloth;
using namespace production_cloth_inputs;

struct DampingInputs {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Elements<float>> elements;
  State<float> serial_state, openmp_state;
  Vectors<float> force;
  Array<float> mass, inverse_mass;
  float half_step;
  linear::Stop stop;
};

std::shared_ptr<const DampingInputs> damping_inputs(const std::string& path) {
  const auto in = std::make_shared<DampingInputs>();
  in->scene = inputs(path), in->elements = elements_of(*in->scene);
  const Vectors<float> position = deformed_positions(*in->scene);
  in->serial_state = production_cloth::serial::make_state(*in->elements);
  in->openmp_state = production_cloth::openmp::make_state(*in->elements);
  in->force.resize(in->elements->vertices);
  production_cloth::openmp::forces(*in->elements, position, in->openmp_state, in->force);
  production_cloth::serial::forces(*in->elements, position, in->serial_state, in->force);
  for (const double m : lumped_masses(in->scene->topology, in->scene->rest, in->scene->material.density))
    in->mass.push_back(static_cast<float>(m));
  in->inverse_mass = inverse_masses(*in->scene);
  in->half_step = static_cast<float>(.5 * in->scene->frame_time / in->scene->substeps);
  in->stop = {.tolerance = in->scene->tolerance, .iterations = in->scene->iterations};
  return in;
}

// An iteration multiplies by D, takes three dot products and updates three vectors of four numbers a vertex. Of what it
// reads and writes, elements apart: the product two, p . q two, precondition three, r . z two, x and p five, r three;
// these are five vectors. A link takes about 20 operations, a membrane 90, a
// folding triangle 60, a vertex 50.
Work work_of(const DampingInputs& in, int iterations) {
  const Elements<float>& e = *in.elements;
  const double elements = 4 * (5. * e.edges + 2. * (e.links - e.edges) + 13. * e.membranes + 15. * e.facets),
               bytes = elements + 4 * (4 * 17. + 2) * e.vertices;
  const double flops = 20. * e.links + 90. * e.membranes + 60. * e.facets + 50. * e.vertices;
  return {double(e.vertices) * iterations,
          "vertices",
          bytes * iterations,
          flops * iterations,
          2. * e.links / std::max<double>(1, e.edges_at.at.size() + e.far_at.at.size()),
          elements + 4 * (4 * 5. + 2) * e.vertices};
}

// Adds how the solve went, and asks that it has not broken off.
Judgement same_solve(const DampingInputs& in, const Damped& openmp, const Damped& serial) {
  Judgement judgement = bitwise(openmp, serial);
  if (!judgement.passed) return judgement;
  char text[80];
  std::snprintf(text, sizeof text, "%.0f iterations, |r|/|b| %.2e", openmp.number[0], openmp.number[1]);
  judgement.worst_at = text;
  judgement.passed = openmp.number[1] <= in.stop.tolerance || openmp.number[0] >= in.stop.iterations;
  return judgement;
}

Case make(const std::string& path) {
  const auto in = damping_inputs(path);
  Damped start = {shaken_velocities(*in->scene), make_changes<float>(in->elements->vertices), Array<double>(2)};
  const auto serial_memory =
      std::make_shared<DampingMemory<float>>(production_cloth::serial::make_damping_memory(*in->elements));
  const auto openmp_memory =
      std::make_shared<DampingMemory<float>>(production_cloth::openmp::make_damping_memory(*in->elements));
  const auto keep = [](Damped& d, const linear::Solution& solution) {
    d.number = {double(solution.iterations), solution.recursive_residual};
  };
  const auto serial = [=](Damped& d) {
    keep(d, production_cloth::serial::damping_solve(*in->elements, in->serial_state, in->mass, in->inverse_mass,
                                                    in->half_step, in->force, in->stop, d.velocity, d.changes,
                                                    *serial_memory));
  };
  // What a guess is made of: the changes of velocities that have the waves in common, and not the shakes.
  for (const unsigned seed : {3, 4, 5}) {
    Damped earlier = {shaken_velocities(*in->scene, seed), start.changes, start.number};
    serial(earlier);
    start.changes = earlier.changes;
  }
  Damped once = start;
  serial(once);
  return make_case<Damped>({
      .start = std::make_shared<const Damped>(start),
      .serial = serial,
      .best_serial = nullptr,
      .openmp =
          [=](Damped& d) {
            keep(d, production_cloth::openmp::damping_solve(*in->elements, in->openmp_state, in->mass, in->inverse_mass,
                                                            in->half_step, in->force, in->stop, d.velocity, d.changes,
                                                            *openmp_memory));
          },
      .compare = [in](const Damped& openmp, const Damped& serial) { return same_solve(*in, openmp, serial); },
      .work = work_of(*in, static_cast<int>(once.number[0])),
  });
}

const Register damping_solve{
    {.name = "production_cloth/damping_solve", .place = 2, .forms = {{.make = make, .scenes = material_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_cloth_damping_solve
