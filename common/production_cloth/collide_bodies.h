// Contract: vertices that a step has moved into solid bodies are pushed out to their surfaces, along the shortest way.
// Friction takes back what they have slid over the surface, relative to the body: at most all of it, and at most
// friction times the depth, which is Coulomb's law of the impulses.
//
// Bodies are tried in rounds until the vertex is in none of them, at most cloth::most_rounds times
// (common/cloth/collide.h). A vertex that was pushed gets the velocity (position - start) / time_step.
//
// In:      bodies, where they are at the end of the step, thickness included; time_step, s; inverse_mass, 1/kg, 0 of a
//          vertex that is held, which is not pushed; start, m: positions at the start of the step.
// In, out: position, m, and velocity, m/s, at the end of the step.
// Arrays are padded; the padding of inverse_mass is 0.
//
// Source: Bridson, Fedkiw and Anderson 2002, section 6 (friction); Bridson, Marino and Fedkiw 2003, section 5.
#pragma once

#include "common/cloth/collide.h"
#include "common/cloth/push_out.h"
#include "common/production_cloth/bodies.h"

namespace lockstep::production_cloth {

template <class Real>
using CollideBodies = void(const MovedBodies<Real>& bodies, int vertices, Real time_step,
                           const Array<Real>& inverse_mass, const Vectors<Real>& start, Vectors<Real>& position,
                           Vectors<Real>& velocity);

namespace serial {
CollideBodies<float> collide_bodies;
CollideBodies<double> collide_bodies;
}  // namespace serial

namespace openmp {
CollideBodies<float> collide_bodies;
}  // namespace openmp

// --- Formulas; of a number or of lanes

// How far the point of the body that ends at x has moved in the step.
template <class V, class Real, template <class> class Shape>
inline Vector3<V> displacement_of(const Moved<Real, Shape>& body, const Vector3<V>& x) {
  const Matrix3<V> turn = {cloth::spread<V>(body.turn.x), cloth::spread<V>(body.turn.y), cloth::spread<V>(body.turn.z)};
  return turn * x + cloth::spread<V>(body.shift);
}

// Pushes active vertices out of the body, and says which were inside.
template <class V, class Real, template <class> class Shape, class Mask>
inline Mask push_out_of(const Moved<Real, Shape>& body, const Vector3<V>& start, Mask active, Vector3<V>& position) {
  return cloth::push_out(body.shape, body.friction, start + displacement_of(body, position), active, position);
}

// One round over all bodies; says which active vertices were inside of one.
template <class V, class Real, class Mask>
inline Mask push_out_of_all(const MovedBodies<Real>& bodies, const Vector3<V>& start, Mask active,
                            Vector3<V>& position) {
  Mask inside = active & !active;  // of no lane yet
  for (const auto& body : bodies.planes) inside |= push_out_of(body, start, active, position);
  for (const auto& body : bodies.capsules) inside |= push_out_of(body, start, active, position);
  for (const auto& body : bodies.boxes) inside |= push_out_of(body, start, active, position);
  for (const auto& body : bodies.level_sets) inside |= push_out_of(body, start, active, position);
  return inside;
}

}  // namespace lockstep::production_cloth
