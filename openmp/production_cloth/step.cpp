// A step of the cloth by Newmark's method, free of collisions with itself, sixteen vertices at a time where they are
// independent.
//
// The algorithm stands in serial/production_cloth/step.cpp; its modules are kernels.
//
// The contract stands in common/production_cloth/step.h.
#include "common/production_cloth/step.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "common/production_cloth/collide_bodies.h"
#include "common/production_cloth/impulses.h"
#include "common/production_cloth/zones.h"
#include "common/real.h"
#include "common/simd.h"
#include "common/stopwatch.h"
#include "openmp/compaction.h"
#include "openmp/vector_lanes.h"

namespace lockstep::production_cloth::openmp {
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
  const Vector3<const float*> x = pointers(position), v = pointers(velocity);
  const Vector3<float*> to = pointers(end);
  // A vertex is one iteration's.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < vertices; i += lanes) store(to, i, load(x, i) + floatv(time_step) * load(v, i));
  for (std::size_t k = 0; k < script.held.size(); ++k) store(end, script.held[k], load(script.place, k));
}

// v + h g of vertices that are free.
void fall(const Cloth<Real>& cloth, Vectors<Real>& velocity) {
  const Vector3<Real> half = Real(.5) * cloth.time_step * cloth.gravity;
  const Vector3<floatv> gain = {half.x, half.y, half.z};
  const Vector3<float*> v = pointers(velocity);
  // A vertex is one iteration's.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < cloth.topology.vertices; i += lanes)
    store(v, i, load(v, i) + gain, load(&cloth.inverse_mass[i]) > 0.f);
}

// before = v + (middle - before), and halfway between the ends.
void pass_on(int vertices, const Motion<Real>& motion, const Vectors<Real>& middle, const Vectors<Real>& end,
             Vectors<Real>& before, Vectors<Real>& halfway) {
  const Vector3<const float*> x = pointers(motion.position), v = pointers(motion.velocity), to = pointers(end),
                              changed = pointers(middle);
  const Vector3<float*> w = pointers(before), between = pointers(halfway);
  // A vertex is one iteration's.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < vertices; i += lanes) {
    store(w, i, load(v, i) + (load(changed, i) - load(w, i)));
    store(between, i, floatv(Real(.5)) * (load(x, i) + load(to, i)));
  }
}

// v' = 2 w' - w, and x'.
void finish(int vertices, const Vectors<Real>& half, const Vectors<Real>& before, const Vectors<Real>& end,
            Motion<Real>& motion) {
  const Vector3<const float*> later = pointers(half), w = pointers(before), to = pointers(end);
  const Vector3<float*> v = pointers(motion.velocity), x = pointers(motion.position);
  // A vertex is one iteration's.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < vertices; i += lanes) {
    store(v, i, floatv(Real(2)) * load(later, i) - load(w, i));
    store(x, i, load(to, i));
  }
}

void rest(Vectors<Real>& velocity) {
  for (Array<Real>* component : {&velocity.x, &velocity.y, &velocity.z}) std::ranges::fill(*component, Real(0));
}

// How far the ends are from those that were predicted, along the axis where that is most; m.
Real farthest(int vertices, const Vectors<Real>& end, const Vectors<Real>& predicted) {
  const Vector3<const float*> to = pointers(end), to_be = pointers(predicted);
  Real most = 0;
  // The greatest of all is the same in whatever order it is found.
#pragma omp parallel for schedule(static) reduction(max : most)
  for (int i = 0; i < vertices; i += lanes) {
    const Vector3<floatv> off = load(to, i) - load(to_be, i);
    const floatv largest = max(abs(off.x), max(abs(off.y), abs(off.z)));
    most = std::max(most, reduce_max(select(first_lanes(vertices - i), largest, floatv(0.f))));
  }
  return most;
}

// Whether a vertex of each element has moved.
template <std::size_t n>
Array<std::int32_t> any_moved(int elements, const std::array<Array<std::int32_t>, n>& corners,
                              const Array<std::int32_t>& has_moved) {
  Array<std::int32_t> moved(padded(elements));
  // An element is one iteration's.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < elements; i += lanes) {
    intv any = 0;
    for (const auto& corner : corners) any = any | gather(has_moved.data(), load(&corner[i]));
    store(&moved[i], any);
  }
  return moved;
}

// The pairs of which a vertex has moved: one of a's, or one of b's.
void keep_moved(const Array<ElementPair>& pairs, const Array<std::int32_t>& a_moved, const Array<std::int32_t>& b_moved,
                Array<ElementPair>& kept) {
  const int count = static_cast<int>(pairs.size());
  lockstep::openmp::Compaction moved(count);
  // A chunk's pairs are one thread's.
#pragma omp parallel for schedule(static)
  for (int chunk = 0; chunk < moved.chunks(); ++chunk)
    moved.for_each_sixteen(chunk, [&](int i) {
      std::uint32_t which = 0;
      for (int l = 0; l < std::min(lanes, count - i); ++l)
        which |= std::uint32_t(a_moved[pairs[i + l].a] | b_moved[pairs[i + l].b]) << l;
      moved.choose(i, lanes_of(which));
    });
  kept.resize(moved.add_up());
  // A pair that is kept has a place of its own.
#pragma omp parallel for schedule(static)
  for (int chunk = 0; chunk < moved.chunks(); ++chunk)
    moved.for_each_sixteen(chunk, [&](int i) {
      int to = moved.before(i);
      for (std::uint32_t set = moved.which(i); set != 0; set &= set - 1) kept[to++] = pairs[i + std::countr_zero(set)];
    });
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
    ccd(cloth.topology, before_find == Module::collide_bodies ? memory.pairs : memory.again, from, to, memory.ccd,
        impacts);
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

void step_jacobi(const Cloth<Real>& cloth, const Script<Real>& script, Motion<Real>& motion, StepMemory<Real>& memory) {
  step(cloth, {repulse_jacobi, impulses_jacobi}, script, motion, memory);
}

void step_batches(const Cloth<Real>& cloth, const Script<Real>& script, Motion<Real>& motion,
                  StepMemory<Real>& memory) {
  step(cloth, {repulse_batches, impulses_batches}, script, motion, memory);
}

}  // namespace lockstep::production_cloth::openmp
