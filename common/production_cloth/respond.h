// What one contact does to the velocities of its four vertices. For numbers and for lanes.
//
//   v = sum of weight_i v_i, relative velocity;  s = n . v;  t = v - s n, sliding
//   gain D >= 0: by how much s is to rise
//   friction takes min(mu D, |t|) from |t|: Coulomb's law of the two impulses
//   impulse J = (change of v) / (sum of weight_i^2 / m_i),  v_i += weight_i J / m_i
//
// Impulses of one contact sum to 0. Their moments do, too, but for friction: it acts on two points that are apart.
//
// Source: Bridson, Fedkiw and Anderson, Robust treatment of collisions, contact and friction for cloth animation,
//         SIGGRAPH 2002, section 7.
#pragma once

#include "common/production_cloth/closest_points.h"
#include "common/production_cloth/cloth.h"

namespace lockstep::production_cloth {

// A contact and its vertices.
template <class V>
struct Touching {
  V weight[4];
  Vector3<V> normal;
  V distance;  // or time
  Vector3<V> velocity[4];
  V inverse_mass[4];  // 1/kg, 0 of a vertex that is held
};

template <class V>
struct Response {
  Vector3<V> impulse;  // N s
  V gain;              // m/s
};

template <class V>
inline Vector3<V> weighted(const V (&weight)[4], const Vector3<V> (&x)[4]) {
  return ((weight[0] * x[0] + weight[1] * x[1]) + weight[2] * x[2]) + weight[3] * x[3];
}

// 1/kg: of the relative velocity's mass.
template <class V>
inline V inverse_mass_of(const Touching<V>& c) {
  const auto part = [&](int i) { return (c.weight[i] * c.weight[i]) * c.inverse_mass[i]; };
  return ((part(0) + part(1)) + part(2)) + part(3);
}

// gain_of(speed, touching): the gain wanted where the speed along the normal is `speed`.
template <class V, class GainOf>
inline Response<V> respond(const Touching<V>& c, const GainOf& gain_of, const V& friction) {
  const Vector3<V> relative = weighted(c.weight, c.velocity);
  const V speed = dot(c.normal, relative);
  const V inverse_mass = inverse_mass_of(c);
  const V gain = select(inverse_mass > V(0), gain_of(speed, c), V(0));
  const Vector3<V> slide = relative - speed * c.normal;
  const V slide_speed = sqrt(dot(slide, slide));
  const V stopped = share_of(min(friction * gain, slide_speed), slide_speed);
  return {share_of(V(1), inverse_mass) * (gain * c.normal - stopped * slide), gain};
}

// --- Gains

// Of an impact: what stops it.
struct StopGain {
  template <class V>
  V operator()(const V& speed, const Touching<V>&) const {
    return max(-speed, V(0));
  }
};

// Of a repulsion: what stops it, and a spring's push against the overlap, of which a step undoes a tenth at most.
template <class Real>
struct RepulsionGain {
  Real thickness, push, most;  // m; N s/m: stiffness times time step; 1/s: a tenth a step

  template <class V>
  V operator()(const V& speed, const Touching<V>& c) const {
    const V zero(0), overlap = max(V(thickness) - c.distance, zero);
    const V mean = V(Real(.25)) * (((c.inverse_mass[0] + c.inverse_mass[1]) + c.inverse_mass[2]) + c.inverse_mass[3]);
    const V left = V(most) * overlap - max(speed, zero);
    return max(-speed, zero) + max(min(V(push) * overlap * mean, left), zero);
  }
};

template <class Real>
RepulsionGain<Real> gain_of_repulsion(const Contact& contact, Real time_step) {
  return {static_cast<Real>(contact.thickness), static_cast<Real>(contact.stiffness) * time_step, Real(.1) / time_step};
}

// --- Jacobi

// The share of its impulse that a contact keeps, given how much all impulses together change its speed. Where that is
// more than its gain, others push it too, and it steps back in proportion.
template <class V>
inline V share_kept(const V& gain, const V& change) {
  const auto exceeds = (gain > V(0)) & (change > gain);
  return select(exceeds, gain / select(exceeds, change, V(1)), V(1));
}

}  // namespace lockstep::production_cloth
