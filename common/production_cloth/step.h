// Contract: a step of the cloth, by Newmark's method: explicit in the elastic forces, implicit in damping; in it the
// cloth does not pass through itself.
//
//   1. search          pairs of elements that may meet
//   2. v* = v + h a(x, v*), h half a step: the elastic forces of x; damping by conjugate gradients
//   3. repulsions of elements that are near each other at x change v*
//   4. x' = x + 2 h v*; vertices in bodies are pushed out
//   5. continuous collision detection, impulses, zones (collide.h), until nothing meets between x and x'
//   6. w = v + (what 3 to 5 changed v* by);  w' = w + h a((x + x') / 2, w');  v' = 2 w' - w
//
// Held vertices go to their places, whatever pushes them.
//
// The search covers motions that end within `room` of x + 2 h v, along each axis. It is repeated where 4 or 5 leave
// that.
//
// Every change of the motion is followed by collision detection of all pairs that it moves; the others did not meet,
// and do not now. So a step ends without collisions, or is cut off: where `most_zone_rounds` of zones leave some, the
// cloth stays where it was, and rests.
//
//   original   repulsions and impulses one after another, in the order of pairs; serial alone
//   jacobi     all at once, from the velocities before; a vertex takes the sum
//   batches    batch after batch, in each of which no two share a vertex
//
// In:      cloth; script, of this step.
// In, out: motion, finite and free of intersections.
// Scratch: memory, which keeps its room from step to step; what the step took comes out in it.
// Errors:  std::bad_alloc; InputError where pairs do not fit the memory.
// Source:  Bridson, Marino and Fedkiw, Simulation of clothing with folds and wrinkles, SCA 2003; Bridson, Fedkiw and
//          Anderson, SIGGRAPH 2002; [ITJ07] "Production Cloth".
#pragma once

#include "common/linear/conjugate_gradients.h"
#include "common/production_cloth/bvh.h"
#include "common/production_cloth/ccd.h"
#include "common/production_cloth/cloth.h"
#include "common/production_cloth/collide.h"
#include "common/production_cloth/damping_solve.h"
#include "common/production_cloth/forces.h"
#include "common/production_cloth/pairs.h"
#include "common/production_cloth/repulsions.h"
#include "common/production_cloth/script.h"

namespace lockstep::production_cloth {

// A cloth, and what follows from it once.
template <class Real>
struct Cloth {
  Topology topology;
  Elements<Real> elements;
  Search search;
  ElementPairs near_at_rest;       // pairs that do not repel each other
  Array<Real> mass, inverse_mass;  // kg, 1/kg, padded with 0; inverse_mass is 0 of held vertices, too
  Contact contact;
  Vector3<Real> gravity;  // m/s^2
  Real time_step;         // s
  linear::Stop stop;      // of a solve
};

// The search's room beside the predicted ends, in thicknesses. At least a half: then elements that are nearer than the
// thickness at x are found.
inline constexpr double room_of_search = 1.25;

// Pairs nearer than this at rest, in thicknesses, do not repel: neighbours of neighbours.
inline constexpr double neighbours_within = 1.5;

// The modules of a step.
enum class Module { search, forces, damping_solve, repulsions, collide_bodies, ccd, impulses, zones, move, count };
inline constexpr const char* name_of_module[] = {"search", "forces",   "damping_solve", "repulsions", "collide_bodies",
                                                 "ccd",    "impulses", "zones",         "move"};

// What a step took.
struct Took {
  std::int64_t searches = 0, pairs = 0, near = 0, iterations = 0;
  Collided collided;  // not free: the step was cut off
};

template <Same<Took> T, class F>
void for_each_field(T& took, const F& f) {
  f("searches", took.searches), f("pairs", took.pairs), f("near", took.near), f("iterations", took.iterations);
  f("free", took.collided.free), f("impacts", took.collided.impacts), f("rounds", took.collided.rounds);
  f("inelastic_rounds", took.collided.inelastic_rounds), f("zone_rounds", took.collided.zone_rounds),
      f("zone_vertices", took.collided.zone_vertices);
}

// Scratch, which keeps its room from step to step; and what the last step took.
template <class Real>
struct StepMemory {
  Vectors<Real> predicted;  // m: the ends that the search covers, but for its room
  Vectors<Real> middle;     // m/s: v*; then w'
  Vectors<Real> before;     // m/s: v* before contact; then w
  Vectors<Real> end;        // m: x'
  Vectors<Real> halfway;    // m: (x + x') / 2
  Vectors<Real> force;      // N
  State<Real> state;
  DampingMemory<Real> damping;
  SearchBoxes<Real> boxes;
  ElementPairs pairs;
  Contacts<Real> near;
  CollideMemory<Real> collide;
  Array<std::int32_t> has_moved;  // [vertex]: since collisions were looked for last, 0 or 1
  ElementPairs again;             // the pairs of such vertices
  openmp::CcdMemory ccd;          // of openmp alone
  Took took;
  double seconds[int(Module::count)] = {};  // by module
};

template <class Real>
using Step = void(const Cloth<Real>& cloth, const Script<Real>& script, Motion<Real>& motion, StepMemory<Real>& memory);

namespace serial {
StepMemory<float> make_memory(const Cloth<float>& cloth);
StepMemory<double> make_memory(const Cloth<double>& cloth);
Step<float> step_original, step_jacobi, step_batches;
Step<double> step_original, step_jacobi, step_batches;
}  // namespace serial

namespace openmp {
StepMemory<float> make_memory(const Cloth<float>& cloth);
Step<float> step_jacobi, step_batches;
}  // namespace openmp

// --- Shared by the two versions

// Marks the vertices of impacts, to which impulses were given, or those of zones.
template <class Real>
void mark(const Contacts<Real>& impacts, Array<std::int32_t>& has_moved) {
  for (std::size_t s = 0; s < 4 * impacts.count; ++s) has_moved[impacts.corner[s]] = 1;
}
inline void mark(const Zones& zones, Array<std::int32_t>& has_moved) {
  for (const std::int32_t v : zones.vertex) has_moved[v] = 1;
}

// m: how far a vertex may end from where it was predicted to, along each axis.
template <class Real>
Real room(const Cloth<Real>& cloth) {
  return static_cast<Real>(room_of_search * cloth.contact.thickness);
}

inline std::int64_t count(const ElementPairs& pairs) {
  return static_cast<std::int64_t>(pairs.point_triangle.size() + pairs.edge_edge.size());
}

}  // namespace lockstep::production_cloth
