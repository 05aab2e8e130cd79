// Repulsions, as the verifier and the benchmark see them: bitwise with the serial twin of the same order.
#include "common/production_cloth/repulsions.h"

#include "verify/production_cloth/contact_inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_cloth_repulsions {
namespace {

using namespace production_cloth;
using namespace production_cloth_inputs;

// Pairs, those that are left out, corners and positions are read once, and contacts written. A pair takes about 150
// operations.
Case make_near_contacts(const std::string& path) {
  const auto in = contact_inputs(path);
  const auto count = [](const ElementPairs& p) {
    return static_cast<double>(p.point_triangle.size() + p.edge_edge.size());
  };
  const Topology& t = in->scene->topology;
  const double pairs = count(in->pairs), bytes = sizeof(ElementPair) * (pairs + count(in->excluded)) +
                                                 12. * t.triangles.size() + 8. * t.edges.size() + 12. * t.vertices +
                                                 48. * static_cast<double>(in->nearby.count);
  const auto run = [in](NearContacts<float>* near_contacts) {
    return [=](Contacts<float>& contacts) {
      near_contacts(in->scene->topology, in->pairs, in->excluded, in->position,
                    static_cast<float>(in->scene->contact.thickness), contacts);
    };
  };
  Contacts<float> start = in->nearby;
  poison(start);
  return make_case<Contacts<float>>({
      .start = std::make_shared<const Contacts<float>>(start),
      .serial = run(serial::near_contacts),
      .best_serial = nullptr,
      .openmp = run(openmp::near_contacts),
      .compare = nullptr,
      .work = {pairs, "pairs", bytes, 150 * pairs},
  });
}

struct Velocities {
  Vectors<float> velocity;
};
template <Same<Velocities> S, class F>
void for_each_array(S& s, const F& f) {
  f("velocity", s.velocity, s.velocity.x.size());
}

Case make(const std::string& path, Repulse<float>* serial_form, Repulse<float>* openmp_form, bool in_batches) {
  const auto in = contact_inputs(path);
  const auto run = [in](Repulse<float>* repulse) {
    return [=](Velocities& s) { repulse(in->nearby, in->scene->contact, in->inverse_mass, in->time_step, s.velocity); };
  };
  return make_case<Velocities>({
      .start = std::make_shared<const Velocities>(Velocities{in->velocity}),
      .serial = run(serial_form),
      .best_serial = run(serial::repulse_original),
      .openmp = run(openmp_form),
      .compare = [](const Velocities& openmp,
                    const Velocities& serial) { return bitwise(openmp, serial, of_element("vertex")); },
      .work = work_of_contacts(*in, in_batches ? lane_use_of_batches(*in) : 0),
  });
}

Case make_batches(const std::string& path) {
  return make(path, serial::repulse_batches, openmp::repulse_batches, true);
}
Case make_jacobi(const std::string& path) { return make(path, serial::repulse_jacobi, openmp::repulse_jacobi, false); }

const Register repulsions{{.name = "production_cloth/repulsions",
                           .place = 6,
                           .serial_forms = {"near_contacts", "original", "batches", "jacobi"},
                           .forms = {{.name = "near_contacts", .make = make_near_contacts, .scenes = all_scenes()},
                                     {.name = "batches", .make = make_batches, .scenes = all_scenes()},
                                     {.name = "jacobi", .make = make_jacobi, .scenes = all_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_cloth_repulsions
