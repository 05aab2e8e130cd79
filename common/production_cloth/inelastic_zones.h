// Contract: inelastic impact zones: what still meets stops along its normals alone, and goes on sliding.
//
// Vertices of impacts are united as in rigid zones (zones.h), and a zone keeps all impacts of its vertices, of this
// call and of earlier ones. Its velocities become the nearest ones in which no impact approaches, by kinetic energy:
//
//   least sum over vertices of m_i |v'_i - v_i|^2 / 2,  for all impacts k:  s_k = n_k . (sum of w_ki v'_i) >= 0
//
// The solution is v'_i = v_i + sum over k of J_k w_ki n_k / m_i: impulses J_k >= 0 along normals, 0 where s_k > 0. They
// are found by sweeps over the impacts in order (Hildreth's method): each J_k takes the value that would stop its own
// impact, or 0. Sweeps end where none changes a speed by more than tolerance_of_inelastic of the greatest change of the
// first sweep, or after most_inelastic_sweeps of them. Whenever they end, every impulse is along its normal and equal
// on both sides: momentum is kept to rounding; angular momentum where the points of the impact are at one place.
//
//   Free vertices of zones end at x + dt v'.
//
// Limits. s_k is of the impact's own weights and normal. What slides on meets elsewhere, and comes again as another
//   impact: the caller needs a bound of its rounds, and rigid zones after them. There is no friction. Impacts between
//   held vertices alone stay what they are; where held vertices leave no solution, sweeps end by their number.
//
// Velocities are in double within a call, and rounded once.
//
// In:      impacts; inverse_mass, 1/kg, 0 of a vertex that is held; time_step, s; start, m.
// In, out: zones; position, m, at the end of the step, and velocity, m/s, of free vertices of zones.
// Errors:  std::bad_alloc.
// Source:  Harmon, Vouga, Tamstorf and Grinspun, Robust treatment of simultaneous collisions, SIGGRAPH 2008 (which
//          keeps s_k = 0); Hildreth, A quadratic programming procedure, 1957.
#pragma once

#include "common/counting_sort.h"
#include "common/production_cloth/zones.h"

namespace lockstep::production_cloth {

inline constexpr int most_inelastic_sweeps = 500;
inline constexpr double tolerance_of_inelastic = 1e-4;

// Zones with their impacts.
template <class Real>
struct InelasticZones {
  Zones zones;
  Contacts<Real> impacts;     // of all calls, as they came
  Array<std::int32_t> place;  // [vertex of a zone]: its place in zones.vertex
  Array<std::int32_t> order;  // of all impacts, zone after zone, in their order
  Array<std::int32_t> first;  // [zone], and one more: where its impacts begin in `order`
  Array<double> impulse;      // N s, [impact]
  Array<double> velocity;     // m/s: [4 place + c]
};

template <Is<InelasticZones> Z, class F>
void for_each_array(Z& z, const F& f) {
  for_each_array(z.zones, f), for_each_array(z.impacts, f);
  f("order", z.order, z.order.size());
  f("impulse", z.impulse, z.impulse.size());
  f("velocities of zones", z.velocity, z.velocity.size());
}

template <class Real>
void clear(int vertices, InelasticZones<Real>& zones) {
  clear(vertices, zones.zones);
  zones.impacts.resize(0), zones.place.resize(vertices);
}

template <class Real>
using MoveInelasticZones = void(const Contacts<Real>& impacts, const Array<Real>& inverse_mass, Real time_step,
                                const Vectors<Real>& start, InelasticZones<Real>& zones, Vectors<Real>& position,
                                Vectors<Real>& velocity);

namespace serial {
MoveInelasticZones<float> move_zones_inelastic;
MoveInelasticZones<double> move_zones_inelastic;
}  // namespace serial

namespace openmp {
MoveInelasticZones<float> move_zones_inelastic;
}  // namespace openmp

// --- The impacts of each zone

// Keeps the impacts, unites their vertices, and sorts all impacts by zone.
template <class Real>
void collect(const Contacts<Real>& impacts, InelasticZones<Real>& z) {
  Contacts<Real>& all = z.impacts;
  const std::size_t before = all.count;
  all.resize(before + impacts.count);
  std::copy_n(impacts.corner.begin(), 4 * impacts.count, all.corner.begin() + 4 * before);
  std::copy_n(impacts.weight.begin(), 4 * impacts.count, all.weight.begin() + 4 * before);
  std::copy_n(impacts.normal.begin(), 4 * impacts.count, all.normal.begin() + 4 * before);
  unite(impacts, z.zones);
  const int zones = static_cast<int>(z.zones.begin.size()) - 1, count = static_cast<int>(all.count);
  Array<std::int32_t> zone_of(z.zones.vertex.size());  // [place]
  for (int zone = 0; zone < zones; ++zone)
    for (int k = z.zones.begin[zone]; k < z.zones.begin[zone + 1]; ++k)
      z.place[z.zones.vertex[k]] = k, zone_of[k] = zone;
  z.order.resize(count);
  const auto for_each = [&](const auto& visit) {
    for (int k = 0; k < count; ++k) visit(k, zone_of[z.place[all.corner[4 * k]]]);
  };
  stable_counting_sort(
      zones, for_each, [&](int k, int place) { z.order[place] = k; }, z.first);
  z.impulse.assign(count, 0), z.velocity.resize(4 * z.zones.vertex.size());
}

// --- Formulas

// An impact in double: what its impulse does to its four vertices.
struct ZoneImpact {
  Vector3<double> normal;
  double weight[4], gain[4];  // gain: weight / mass
  double* velocity[4];
  double mass;  // kg, of the impact: 0 where all four are held
};

template <class Real>
ZoneImpact zone_impact(std::int32_t k, const Array<Real>& inverse_mass, InelasticZones<Real>& z) {
  const Contacts<Real>& all = z.impacts;
  const Real* const n = &all.normal[4 * k];
  ZoneImpact impact = {.normal = {n[0], n[1], n[2]}, .weight = {}, .gain = {}, .velocity = {}, .mass = 0};
  double per_mass = 0;
  for (int i = 0; i < 4; ++i) {
    const std::int32_t v = all.corner[4 * k + i];
    impact.weight[i] = all.weight[4 * k + i], impact.gain[i] = impact.weight[i] * double(inverse_mass[v]);
    impact.velocity[i] = &z.velocity[4 * z.place[v]];
    per_mass += impact.weight[i] * impact.gain[i];
  }
  impact.mass = per_mass > 0 ? 1 / per_mass : 0;
  return impact;
}

// m/s: how fast the impact's points part.
inline double speed_of(const ZoneImpact& impact) {
  double speed = 0;
  for (int i = 0; i < 4; ++i) {
    const double* const v = impact.velocity[i];
    speed += impact.weight[i] * (impact.normal.x * v[0] + impact.normal.y * v[1] + impact.normal.z * v[2]);
  }
  return speed;
}

// Brings the impulse to where the impact's speed is 0, or to 0. Returns by how much that changes the speed, m/s.
inline double stop(const ZoneImpact& impact, double& impulse) {
  if (!(impact.mass > 0)) return 0;
  const double goal = std::max(impulse - impact.mass * speed_of(impact), 0.), change = goal - impulse;
  impulse = goal;
  for (int i = 0; i < 4; ++i) {
    const double by = impact.gain[i] * change;
    impact.velocity[i][0] += by * impact.normal.x;
    impact.velocity[i][1] += by * impact.normal.y;
    impact.velocity[i][2] += by * impact.normal.z;
  }
  return std::abs(change) / impact.mass;
}

}  // namespace lockstep::production_cloth
