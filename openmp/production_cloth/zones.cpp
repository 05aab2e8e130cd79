// Rigid impact zones: vertices that go on meeting move on as one rigid body.
//
// Zones are shared out to threads as they come: their sizes differ. Each is one thread's, with sums in the order of
// vertices, so the choice of thread does not matter. Impacts are united in sequence, which is little beside finding
// them.
//
// Inelastic zones stop impacts along their normals alone: impulses are found by sweeps over all impacts of a zone, of
// earlier rounds, too, so that stopping one does not bring back another, and what slides goes on.
//
// The contracts stand in common/production_cloth/zones.h and inelastic_zones.h.
#include "common/production_cloth/zones.h"

#include "common/production_cloth/inelastic_zones.h"
#include "common/real.h"

namespace lockstep::production_cloth::openmp {
namespace {

// The motion of the vertices of a zone, which `read` gives.
template <class Read>
RigidMotion motion_of(const std::int32_t* begin, const std::int32_t* end, bool holds, const Read& read) {
  RigidMotion motion;
  double mass = 0;
  for (const std::int32_t* v = begin; v < end; ++v) {
    const ZoneVertex x = read(*v, holds);
    mass += x.mass;
    motion.centre = motion.centre + x.mass * x.start, motion.shift = motion.shift + x.mass * x.way;
  }
  motion.centre = (1 / mass) * motion.centre, motion.shift = (1 / mass) * motion.shift;
  for (int turn = 0; turn < (holds ? turns_of_held : 1); ++turn) {
    Inertia inertia;
    for (const std::int32_t* v = begin; v < end; ++v) {
      const ZoneVertex x = read(*v, holds);
      inertia.add(x.mass, motion.turn * (x.start - motion.centre), (x.start + x.way) - motion.place(x.start));
    }
    turn_further(inertia, motion);
  }
  return motion;
}

// Velocities in which the impacts of a zone do not approach.
void stop_all(const std::int32_t* begin, const std::int32_t* end, const Array<Real>& inverse_mass,
              InelasticZones<Real>& z) {
  double most = 0;
  for (int sweep = 0; sweep < most_inelastic_sweeps; ++sweep) {
    double greatest = 0;
    for (const std::int32_t* k = begin; k < end; ++k)
      greatest = std::max(greatest, stop(zone_impact(*k, inverse_mass, z), z.impulse[*k]));
    if (sweep == 0) most = greatest;
    if (!(greatest > tolerance_of_inelastic * most)) return;
  }
}

}  // namespace

void move_zones(const Contacts<Real>& impacts, const Array<Real>& inverse_mass, Real time_step,
                const Vectors<Real>& start, Zones& zones, Vectors<Real>& position, Vectors<Real>& velocity) {
  unite(impacts, zones);
  const auto read = [&](std::int32_t v, bool holds) {
    return zone_vertex(v, holds, inverse_mass, time_step, start, position, velocity);
  };
  const auto is_held = [&](std::int32_t v) { return !(inverse_mass[v] > 0); };
  const int count = static_cast<int>(zones.begin.size()) - 1;
  // Zones share no vertex.
#pragma omp parallel for schedule(dynamic, 4)
  for (int zone = 0; zone < count; ++zone) {
    const std::int32_t *begin = zones.vertex.data() + zones.begin[zone],
                       *end = zones.vertex.data() + zones.begin[zone + 1];
    const RigidMotion motion = motion_of(begin, end, std::any_of(begin, end, is_held), read);
    for (const std::int32_t* v = begin; v < end; ++v) {
      if (is_held(*v)) continue;
      const Vector3<Real> from = load(start, *v);
      const Vector3<double> to = motion.place({from.x, from.y, from.z});
      store(position, *v, Vector3<Real>{Real(to.x), Real(to.y), Real(to.z)});
      store(velocity, *v, (1 / time_step) * (load(position, *v) - from));
    }
  }
}

void move_zones_inelastic(const Contacts<Real>& impacts, const Array<Real>& inverse_mass, Real time_step,
                          const Vectors<Real>& start, InelasticZones<Real>& z, Vectors<Real>& position,
                          Vectors<Real>& velocity) {
  collect(impacts, z);
  const int count = static_cast<int>(z.zones.begin.size()) - 1;
  // Zones share no vertex, and no impact.
#pragma omp parallel for schedule(dynamic, 4)
  for (int zone = 0; zone < count; ++zone) {
    const int begin = z.zones.begin[zone], end = z.zones.begin[zone + 1];
    for (int k = begin; k < end; ++k) {
      const Vector3<Real> v = load(velocity, z.zones.vertex[k]);
      z.velocity[4 * k] = v.x, z.velocity[4 * k + 1] = v.y, z.velocity[4 * k + 2] = v.z;
    }
    stop_all(z.order.data() + z.first[zone], z.order.data() + z.first[zone + 1], inverse_mass, z);
    for (int k = begin; k < end; ++k) {
      const std::int32_t i = z.zones.vertex[k];
      if (!(inverse_mass[i] > 0)) continue;
      store(velocity, i, {Real(z.velocity[4 * k]), Real(z.velocity[4 * k + 1]), Real(z.velocity[4 * k + 2])});
      store(position, i, load(start, i) + time_step * load(velocity, i));
    }
  }
}

}  // namespace lockstep::production_cloth::openmp
