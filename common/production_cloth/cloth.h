// A production cloth: a triangle mesh with masses, positions and velocities, which never passes through itself.
//
// Vertices are the unknowns. Positions and velocities are one array a component (Vectors). Vectors of solvers hold
// component c of vertex v at 3 v + c, as the products of common/linear do.
//
// Source: Bridson, Marino and Fedkiw, Simulation of clothing with folds and wrinkles, SCA 2003; Bridson, Fedkiw and
//         Anderson, Robust treatment of collisions, contact and friction for cloth animation, SIGGRAPH 2002; [ITJ07]
//         "Production Cloth".
#pragma once

#include <cstdint>

#include "common/arrays.h"
#include "common/production_cloth/topology.h"
#include "common/vector3.h"

namespace lockstep::production_cloth {

// How a cloth resists in its plane and across it.
enum class Stretch { springs, stvk, corotated };  // edge springs; membranes of linear triangles
enum class Bend { none, hinges, quadratic };      // Bridson 2003; isometric quadratic, flat at rest

// Units: m, kg, s. A force a length is in N/m.
struct Material {
  double density = .2;  // kg/m^2
  Stretch stretch = Stretch::springs;
  double stiffness = 1;         // springs: N, the force of a spring stretched to twice its length
  double membrane = 100;        // stvk, corotated: N/m, Young's modulus times the thickness of the cloth
  double poisson = .3;          // of the membrane, -1 < nu < .5
  double stretch_damping = .1;  // springs: share of critical damping; membranes: s, of stiffness
  Bend bend = Bend::quadratic;
  double bending = 1e-5;     // N m: the plate constant D; hinges: k of Bridson's force, N
  double bend_damping = .1;  // hinges: share of critical damping; quadratic: s, of stiffness
};

// What ends collisions that impulses do not end: rigid zones, or inelastic ones and, should these not do, rigid ones.
enum class ZoneForm { rigid, inelastic };

// What contact needs, of the cloth with itself.
struct Contact {
  double thickness = 1e-3;  // m: repulsions act where elements are nearer than this
  double stiffness = 30;    // N/m, of the repulsion
  double friction = .3;     // Coulomb's coefficient
  ZoneForm zones = ZoneForm::rigid;
};

// By how much the last two damping solves of a kind changed velocities, and how much of each is guessed of the next:
// nothing is guessed where both weights are 0.
// Records hold component c of vertex v at 4 v + c, and 0 at 4 v + 3; they are filled up to whole vectors of vertices.
template <class Real>
struct Changes {
  Array<Real> last, before;  // m/s
  Array<Real> weight;        // of `last` and of `before`
};

template <Is<Changes> C, class F>
void for_each_array(C& changes, const F& f) {
  f("last change", changes.last, changes.last.size());
  f("change before", changes.before, changes.before.size());
  f("weight of changes", changes.weight, changes.weight.size());
}

// The numbers of such records, for lanes.
constexpr std::size_t numbers_of_records(std::size_t vertices) { return 4 * ((vertices + 15) / 16 * 16); }

// None yet.
template <class Real>
Changes<Real> make_changes(std::size_t vertices) {
  const Array<Real> none(numbers_of_records(vertices));
  return {none, none, Array<Real>(2)};
}

// The state that steps change.
template <class Real>
struct Motion {
  Vectors<Real> position;                                 // m
  Vectors<Real> velocity;                                 // m/s
  Changes<Real> by_first_half = {}, by_second_half = {};  // by damping_solve
};

template <Is<Motion> M, class F>
void for_each_array(M& motion, const F& f) {
  f("position", motion.position, motion.position.x.size());
  f("velocity", motion.velocity, motion.velocity.x.size());
  for_each_array(motion.by_first_half, f), for_each_array(motion.by_second_half, f);
}

}  // namespace lockstep::production_cloth
