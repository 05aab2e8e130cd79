// Rigid and inelastic zones, as the verifier and the benchmark see them: bitwise with the serial twin.
#include "common/production_cloth/inelastic_zones.h"

#include "verify/production_cloth/contact_inputs.h"
#include "verify/twin.h"

namespace lockstep::production_cloth {

// What rigid zones change.
struct Zoned {
  Zones zones;
  Vectors<float> position, velocity;
};
template <Same<Zoned> S, class F>
void for_each_array(S& s, const F& f) {
  for_each_array(s.zones, f);
  f("position", s.position, s.position.x.size());
  f("velocity", s.velocity, s.velocity.x.size());
}

// The same of inelastic zones.
struct ZonedInelastic {
  InelasticZones<float> zones;
  Vectors<float> position, velocity;
};
template <Same<ZonedInelastic> S, class F>
void for_each_array(S& s, const F& f) {
  for_each_array(s.zones, f);
  f("position", s.position, s.position.x.size());
  f("velocity", s.velocity, s.velocity.x.size());
}

}  // namespace lockstep::production_cloth

namespace lockstep::verify::production_cloth_zones {
namespace {

using namespace production_cloth;
using namespace production_cloth_inputs;

// Contacts from `first` on, at such intervals that about a third of all vertices are in zones.
Contacts<float> impacts_from(const ContactInputs& in, std::size_t first) {
  const std::size_t every = 1 + 12 * in.nearby.count / in.scene->topology.vertices;
  Contacts<float> impacts;
  for (std::size_t k = first; k < in.nearby.count; k += every) {
    const std::size_t to = 4 * impacts.count;
    impacts.resize(impacts.count + 1);
    std::copy_n(&in.nearby.corner[4 * k], 4, &impacts.corner[to]);
    std::copy_n(&in.nearby.weight[4 * k], 4, &impacts.weight[to]);
    std::copy_n(&in.nearby.normal[4 * k], 4, &impacts.normal[to]);
  }
  return impacts;
}

// A vertex of a zone is read twice, and takes about 80 operations; an impact takes about 60 a sweep.
template <class State, class Kernel>
Case make(const std::string& path, Kernel* in_serial, Kernel* in_openmp) {
  const auto in = contact_inputs(path);
  const auto first = std::make_shared<const Contacts<float>>(impacts_from(*in, 0)),
             second = std::make_shared<const Contacts<float>>(impacts_from(*in, 1));
  State start = {.zones = {}, .position = in->position, .velocity = in->velocity};
  const int vertices = in->scene->topology.vertices;
  clear(vertices, start.zones);
  for (int v = 0; v < vertices; ++v)
    store(start.position, v, load(in->position, v) + in->time_step * load(in->velocity, v));
  const auto run = [=](Kernel* move_zones) {
    return [=](State& s) {
      for (const auto& impacts : {first, second})
        move_zones(*impacts, in->inverse_mass, in->time_step, in->position, s.zones, s.position, s.velocity);
    };
  };
  State end = start;
  run(in_serial)(end);
  double n = 0;
  for (int v = 0; v < vertices; ++v) n += load(end.velocity, v).x != load(start.velocity, v).x;
  return make_case<State>({
      .start = std::make_shared<const State>(start),
      .serial = run(in_serial),
      .best_serial = nullptr,
      .openmp = run(in_openmp),
      .compare = nullptr,
      .work = {n, "vertices", 2 * 4 * 20 * n, 2 * 80 * n},
  });
}

Case make_rigid(const std::string& path) {
  MoveZones<float>* const in_serial = serial::move_zones;
  return make<Zoned>(path, in_serial, openmp::move_zones);
}
Case make_inelastic(const std::string& path) {
  MoveInelasticZones<float>* const in_serial = serial::move_zones_inelastic;
  return make<ZonedInelastic>(path, in_serial, openmp::move_zones_inelastic);
}

const Register zones{{.name = "production_cloth/zones",
                      .place = 8,
                      .serial_forms = {"rigid", "inelastic"},
                      .forms = {{.name = "rigid", .make = make_rigid, .scenes = all_scenes()},
                                {.name = "inelastic", .make = make_inelastic, .scenes = all_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_cloth_zones
