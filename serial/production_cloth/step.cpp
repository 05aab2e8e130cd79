// A step of the cloth by Newmark's method, free of collisions with itself.
//
// Elastic forces are explicit: one pass over the elements. They bound the length of a step, and folds need short steps
// anyway. Damping would bound it further. It is linear in velocities and positive definite, so it is solved for: a few
// iterations of conjugate gradients.
//
// Contact changes the velocity in the middle of the step. Repulsions of near elements come first; they are cheap, and
// leave few collisions. Collisions cost more: continuous collision detection with rounds of impulses, then zones. The
// change of the middle velocity counts as an impulse at the start of the step, so the second half begins with it.
//
// One search for pairs serves a step. It covers the motion that the start's velocities predict, and some room beside
// it. It is repeated where the motion leaves that room. Later rounds of collision detection look at those of the pairs
// that the round before has moved.
//
// The contract stands in common/production_cloth/step.h.
#include "common/production_cloth/step.h"

#include <algorithm>
#include <cmath>

#include "common/production_cloth/collide_bodies.h"
#include "common/production_cloth/impulses.h"
#include "common/production_cloth/zones.h"
#include "common/real.h"
#include "common/stopwatch.h"

namespace lockstep::production_cloth::serial {
namespace {

struct Forms {
  Repulse<Real>* repulse;
  Impulses<Real>* impulses;
};

// --- Loops over vertices

// Velocities that bring held vertices to their places.
void hold(const Script<Real>& script, Real time_step, const Vectors<Real>& position, Vectors<Real>& velocity) {
  const Real per_step = 1 / time_step;
  for (std::size_t k = 0; k < script.held.size(); ++k) {
    const std::size_t i = script.held[k];
    store(velocity, i, per_step * (load(script.place, k) - load(position, i)));
  }
}

// Positions x + dt v; held vertices are in their places, whatever rounding does.
void move(const Script<Real>& script, int vertices, Real time_step, const Vectors<Real>& position,
          const Vectors<Real>& velocity, Vectors<Real>& end) {
  for (int i = 0; i < vertices; ++i) store(end, i, load(position, i) + time_step * load(velocity, i));
  for (std::size_t k = 0; k < script.held.size(); ++k) store(end, script.held[k], load(script.place, k));
}

// v + h g of vertices that are free.
void fall(const Cloth<Real>& cloth, Vectors<Real>& velocity) {
  const Vector3<Real> gain = Real(.5) * cloth.time_step * cloth.gravity;
  for (int i = 0; i < cloth.topology.vertices; ++i)
    if (cloth.inverse_mass[i] > 0) store(velocity, i, load(velocity, i) + gain);
}

// before = v + (middle - before), and halfway between the ends.
void pass_on(int vertices, const Motion<Real>& motion, const Vectors<Real>& middle, const Vectors<Real>& end,
             Vectors<Real>& before, Vectors<Real>& halfway) {
  for (int i = 0; i < vertices; ++i) {
    store(before, i, load(motion.velocity, i) + (load(middle, i) - load(before, i)));
    store(halfway, i, Real(.5) * (load(motion.position, i) + load(end, i)));
  }
}

// v' = 2 w' - w, and x'.
void finish(int vertices, const Vectors<Real>& half, const Vectors<Real>& before, const Vectors<Real>& end,
            Motion<Real>& motion) {
  for (int i = 0; i < vertices; ++i) {
    store(motion.velocity, i, Real(2) * load(half, i) - load(before, i));
    store(motion.position, i, load(end, i));
  }
}

void rest(Vectors<Real>& velocity) {
  for (Array<Real>* component : {&velocity.x, &velocity.y, &velocity.z}) std::ranges::fill(*component, Real(0));
}

// How far the ends are from those that were predicted, along the axis where that is most; m.
Real farthest(int vertices, const Vectors<Real>& end, const Vectors<Real>& predicted) {
  Real most = 0;
  for (int i = 0; i < vertices; ++i) {
    const Vector3<Real> off = load(end, i) - load(predicted, i);
    most = std::max({most, std::abs(off.x), std::abs(off.y), std::abs(off.z)});
  }
  return most;
}

// Whether a vertex of each element has moved.
template <std::size_t n>
Array<std::int32_t> any_moved(int elements, const std::array<Array<std::int32_t>, n>& corners,
                              const Array<std::int32_t>& has_moved) {
  Array<std::int32_t> moved(elements);
  for (int i = 0; i < elements; ++i)
    for (const auto& corner : corners) moved[i] |= has_moved[corner[i]];
  return moved;
}

// The pairs of which a vertex has moved: one of a's, or one of b's.
void keep_moved(const Array<ElementPair>& pairs, const Array<std::int32_t>& a_moved, const Array<std::int32_t>& b_moved,
                Array<ElementPair>& kept) {
  kept.clear();
  for (const ElementPair& pair : pairs)
    if (a_moved[pair.a] | b_moved[pair.b]) kept.push_back(pair);
}
void keep_moved(const Search& search, const ElementPairs& pairs, const Array<std::int32_t>& has_moved,
                ElementPairs& kept) {
  const Array<std::int32_t> edges = any_moved(search.edges.elements, search.ends, has_moved);
  const Array<std::int32_t> triangles = any_moved(search.triangles.elements, search.corners, has_moved);
  keep_moved(pairs.point_triangle, has_moved, triangles, kept.point_triangle);
  keep_moved(pairs.edge_edge, edges, edges, kept.edge_edge);
}

// --- Modules

void search(const Cloth<Real>& cloth, const Vectors<Real>& position, StepMemory<Real>& memory) {
  refit(cloth.search, position, memory.predicted, room(cloth), memory.boxes);
  find_pairs(cloth.search, memory.boxes, memory.pairs);
  ++memory.took.searches;
  memory.took.pairs += count(memory.pairs);
}

// Velocities after half a step, by gravity and the forces at `position`.
template <class Done>
void half_step(const Cloth<Real>& cloth, const Vectors<Real>& position, Vectors<Real>& velocity, Changes<Real>& changes,
               StepMemory<Real>& memory, const Done& done) {
  forces(cloth.elements, position, memory.state, memory.force);
  fall(cloth, velocity);
  done(Module::forces);
  memory.took.iterations +=
      damping_solve(cloth.elements, memory.state, cloth.mass, cloth.inverse_mass, Real(.5) * cloth.time_step,
                    memory.force, cloth.stop, velocity, changes, memory.damping)
          .iterations;
  done(Module::damping_solve);
}

void step(const Cloth<Real>& cloth, const Forms& forms, const Script<Real>& script, Motion<Real>& motion,
          StepMemory<Real>& memory) {
  const int n = cloth.topology.vertices;
  const Real dt = cloth.time_step;
  const Vectors<Real>& start = motion.position;
  memory.took = {};
  std::fill(std::begin(memory.seconds), std::end(memory.seconds), 0.);
  Stopwatch stopwatch;
  const auto done = [&](Module module) { memory.seconds[int(module)] += stopwatch.lap(); };

  hold(script, dt, start, motion.velocity);
  move(script, n, dt, start, motion.velocity, memory.predicted);
  done(Module::move);
  search(cloth, start, memory);
  done(Module::search);

  memory.middle = motion.velocity;
  half_step(cloth, start, memory.middle, motion.by_first_half, memory, done);
  memory.before = memory.middle;
  near_contacts(cloth.topology, memory.pairs, cloth.near_at_rest, start, Real(cloth.contact.thickness), memory.near);
  forms.repulse(memory.near, cloth.contact, cloth.inverse_mass, dt, memory.middle);
  memory.took.near = static_cast<std::int64_t>(memory.near.count);
  done(Module::repulsions);
  move(script, n, dt, start, memory.middle, memory.end);
  done(Module::move);
  collide_bodies(script.bodies, n, dt, cloth.inverse_mass, start, memory.end, memory.middle);
  done(Module::collide_bodies);

  Module before_find = Module::collide_bodies;
  const auto find = [&](const Vectors<Real>& from, const Vectors<Real>& to, Contacts<Real>& impacts) {
    done(before_find);
    if (farthest(n, to, memory.predicted) > room(cloth)) {
      memory.predicted = to;
      search(cloth, from, memory);
      done(Module::search);
    }
    if (before_find == Module::zones)
      mark(memory.collide.zones, memory.has_moved), mark(memory.collide.inelastic.zones, memory.has_moved);
    if (before_find != Module::collide_bodies) keep_moved(cloth.search, memory.pairs, memory.has_moved, memory.again);
    ccd(cloth.topology, before_find == Module::collide_bodies ? memory.pairs : memory.again, from, to, impacts);
    std::ranges::fill(memory.has_moved, 0);
    done(Module::ccd);
    before_find = Module::zones;
  };
  const auto stop = [&](const Contacts<Real>& impacts, Vectors<Real>& velocity) {
    forms.impulses(impacts, static_cast<Real>(cloth.contact.friction), cloth.inverse_mass, velocity);
    mark(impacts, memory.has_moved);
    done(Module::impulses);
    before_find = Module::impulses;
  };
  memory.took.collided = collide<Real>(find, stop, {move_zones, move_zones_inelastic, cloth.contact.zones},
                                       cloth.inverse_mass, dt, start, memory.end, memory.middle, memory.collide);
  if (!memory.took.collided.free) {
    rest(motion.velocity);
    return;
  }

  pass_on(n, motion, memory.middle, memory.end, memory.before, memory.halfway);
  done(Module::move);
  memory.middle = memory.before;
  half_step(cloth, memory.halfway, memory.middle, motion.by_second_half, memory, done);
  finish(n, memory.middle, memory.before, memory.end, motion);
  done(Module::move);
}

}  // namespace

StepMemory<Real> make_memory(const Cloth<Real>& cloth) {
  StepMemory<Real> memory;
  const std::size_t n = cloth.topology.vertices;
  for (Vectors<Real>* v :
       {&memory.predicted, &memory.middle, &memory.before, &memory.end, &memory.halfway, &memory.force})
    v->resize(n);
  memory.has_moved.assign(n, 0);
  memory.state = make_state(cloth.elements), memory.damping = make_damping_memory(cloth.elements);
  return memory;
}

void step_original(const Cloth<Real>& cloth, const Script<Real>& script, Motion<Real>& motion,
                   StepMemory<Real>& memory) {
  step(cloth, {repulse_original, impulses_original}, script, motion, memory);
}

void step_jacobi(const Cloth<Real>& cloth, const Script<Real>& script, Motion<Real>& motion, StepMemory<Real>& memory) {
  step(cloth, {repulse_jacobi, impulses_jacobi}, script, motion, memory);
}

void step_batches(const Cloth<Real>& cloth, const Script<Real>& script, Motion<Real>& motion,
                  StepMemory<Real>& memory) {
  step(cloth, {repulse_batches, impulses_batches}, script, motion, memory);
}

}  // namespace lockstep::production_cloth::serial
