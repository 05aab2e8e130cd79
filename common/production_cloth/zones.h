// Contract: rigid impact zones, which end the collisions of a step when impulses have not.
//
// Vertices of an impact are united into one zone, and zones with a vertex in common are one. Each zone moves from its
// start as a rigid body, so that nothing in it meets. Zones only grow from call to call: where the caller goes on until
// no impact is left, this ends, with one zone in the worst case. What it costs: nothing slides within a zone.
//
//   without held vertices   c, M  centre and mass at the start; v = sum m_i v_i / M;  L = sum m_i r_i x v_i, r = x - c
//                           I w = L;  x' = c + dt v + R(dt w) (x - c), R the rotation by a vector
//   with held vertices      these go where they are to go. The others follow the rigid motion that fits the held ones
//                           best, of equal weight: their mean displacement, and the turn that makes the sum of
//                           r x (what is left) zero, found by Newton's method from none. It is exact where held
//                           vertices move rigidly. Where one held vertex, or several in a line, leave a turn
//                           undetermined, there is none.
//
//   Free vertices of zones get the velocity (x' - x) / dt. Linear momentum is kept; angular momentum is that of the
//   rotation, of which a straight way from x to x' keeps a share, sin(|w| dt) / (|w| dt) about a main axis.
//
// Limits. Collision detection sees straight ways, which shrink a zone that turns by an angle a by 1 - cos(a / 2) at the
//   middle of the step: it may find impacts within a zone. Where held vertices of a zone do not move rigidly, the zone
//   may meet itself for good. The caller needs a bound of its rounds (collide.h).
//
// All is computed in double and rounded once. Sums are in the order of vertices.
//
// In:      impacts; inverse_mass, 1/kg, 0 of a vertex that is held; time_step, s; start, m.
// In, out: zones; position, m, at the end of the step, and velocity, m/s: of free vertices of zones they are replaced.
//          position is read of held vertices alone.
// Errors:  std::bad_alloc.
// Source:  Provot, Collision and self-collision handling in cloth model dedicated to design garments, 1997; Bridson,
//          Fedkiw and Anderson 2002, section 7.4.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/placement.h"
#include "common/production_cloth/contacts.h"

namespace lockstep::production_cloth {

// Sets of union-find: the root of a zone is its least vertex; a vertex in no zone is its own root.
struct Zones {
  Array<std::int32_t> parent;  // [vertex]: a vertex of its zone, not greater than itself
  Array<std::int32_t> vertex;  // of all zones, zone after zone in the order of least vertices, each ascending
  Array<std::int32_t> begin;   // [zone], and one more: where it begins among them
};

template <Same<Zones> Z, class F>
void for_each_array(Z& zones, const F& f) {
  f("parent", zones.parent, zones.parent.size());
  f("vertex", zones.vertex, zones.vertex.size());
  f("begin", zones.begin, zones.begin.size());
}

// Leaves no zones: every vertex is its own root.
inline void clear(int vertices, Zones& zones) {
  zones.parent.resize(vertices);
  for (int v = 0; v < vertices; ++v) zones.parent[v] = v;
  zones.vertex.clear(), zones.begin.assign(1, 0);
}

template <class Real>
using MoveZones = void(const Contacts<Real>& impacts, const Array<Real>& inverse_mass, Real time_step,
                       const Vectors<Real>& start, Zones& zones, Vectors<Real>& position, Vectors<Real>& velocity);

namespace serial {
MoveZones<float> move_zones;
MoveZones<double> move_zones;
}  // namespace serial

namespace openmp {
MoveZones<float> move_zones;
}  // namespace openmp

// --- Union-find

inline std::int32_t least_of(std::int32_t v, Zones& zones) {
  for (; zones.parent[v] != v; v = zones.parent[v]) zones.parent[v] = zones.parent[zones.parent[v]];
  return v;
}

// Unites the vertices of each impact, and lists all zones anew.
template <class Real>
void unite(const Contacts<Real>& impacts, Zones& zones) {
  const auto whole = [&](std::size_t s) { return impacts.corner[s / 4 * 4]; };  // the first vertex of its impact
  for (std::size_t s = 0; s < 4 * impacts.count; ++s) {
    const std::int32_t a = least_of(impacts.corner[s], zones), b = least_of(whole(s), zones);
    zones.parent[std::max(a, b)] = std::min(a, b);
  }
  zones.vertex.insert(zones.vertex.end(), impacts.corner.begin(), impacts.corner.begin() + 4 * impacts.count);
  for (const std::int32_t v : zones.vertex) zones.parent[v] = least_of(v, zones);
  std::ranges::sort(zones.vertex, [&](std::int32_t a, std::int32_t b) {
    return zones.parent[a] != zones.parent[b] ? zones.parent[a] < zones.parent[b] : a < b;
  });
  zones.vertex.erase(std::unique(zones.vertex.begin(), zones.vertex.end()), zones.vertex.end());
  zones.begin.assign(1, 0);
  for (std::size_t k = 1; k <= zones.vertex.size(); ++k)
    if (k == zones.vertex.size() || zones.parent[zones.vertex[k]] != zones.parent[zones.vertex[k - 1]])
      zones.begin.push_back(static_cast<std::int32_t>(k));
}

// --- Rigid motions

// Sums over points of mass m at r from their centre.
struct Inertia {
  double xx = 0, yy = 0, zz = 0, xy = 0, yz = 0, zx = 0;
  Vector3<double> moment = {0, 0, 0};  // of m r x d

  void add(double m, const Vector3<double>& r, const Vector3<double>& d) {
    xx += m * (r.y * r.y + r.z * r.z), yy += m * (r.z * r.z + r.x * r.x), zz += m * (r.x * r.x + r.y * r.y);
    xy -= m * r.x * r.y, yz -= m * r.y * r.z, zx -= m * r.z * r.x;
    moment = moment + m * cross(r, d);
  }
};

// The turn w of I w = moment. Points in a line have no inertia about it, and get a little about all axes.
inline Vector3<double> turn_of(Inertia a) {
  const double mean = (a.xx + a.yy + a.zz) / 3;
  if (!(mean > 0)) return {0, 0, 0};
  const auto columns = [&] { return Matrix3<double>{{a.xx, a.xy, a.zx}, {a.xy, a.yy, a.yz}, {a.zx, a.yz, a.zz}}; };
  Matrix3<double> i = columns();
  if (!(dot(i.x, cross(i.y, i.z)) > 1e-12 * mean * mean * mean)) {
    a.xx += 1e-9 * mean, a.yy += 1e-9 * mean, a.zz += 1e-9 * mean;
    i = columns();
  }
  const Matrix3<double> cofactors = {cross(i.y, i.z), cross(i.z, i.x), cross(i.x, i.y)};
  return (1 / dot(i.x, cofactors.x)) * transposed_times(cofactors, a.moment);
}

// From x to centre + shift + turn (x - centre).
struct RigidMotion {
  Vector3<double> centre = {0, 0, 0}, shift = {0, 0, 0};
  Matrix3<double> turn = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

  Vector3<double> place(const Vector3<double>& x) const { return (centre + shift) + turn * (x - centre); }
};

inline void turn_further(const Inertia& inertia, RigidMotion& motion) {
  const Matrix3<double> r = rotation_by(turn_of(inertia)), before = motion.turn;
  motion.turn = {r * before.x, r * before.y, r * before.z};
}

inline constexpr int turns_of_held = 4;  // of Newton's method: each cubes the angle that is left

// A vertex of a zone: its weight in the sums, where it starts, how far it goes.
struct ZoneVertex {
  double mass;
  Vector3<double> start, way;
};

// Vertex v of a zone. `holds`: whether the zone has held vertices.
template <class Real>
ZoneVertex zone_vertex(std::int32_t v, bool holds, const Array<Real>& inverse_mass, Real time_step,
                       const Vectors<Real>& start, const Vectors<Real>& position, const Vectors<Real>& velocity) {
  const auto widen = [](const Vector3<Real>& x) { return Vector3<double>{x.x, x.y, x.z}; };
  const Vector3<double> from = widen(load(start, v));
  if (!holds) return {1 / double(inverse_mass[v]), from, double(time_step) * widen(load(velocity, v))};
  return {inverse_mass[v] > 0 ? 0. : 1., from, widen(load(position, v)) - from};
}

}  // namespace lockstep::production_cloth
