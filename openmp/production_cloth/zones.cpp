// Rigid impact zones: vertices that go on meeting move on as one rigid body.
//
// Zones are shared out to threads as they come: their sizes differ. Each is one thread's, with sums in the order of
// vertices, so that who takes which does not matter. Impacts are united in sequence, which is little beside finding
// them.
//
// The contract stands in common/production_cloth/zones.h.
#include "common/production_cloth/zones.h"

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

}  // namespace lockstep::production_cloth::openmp
