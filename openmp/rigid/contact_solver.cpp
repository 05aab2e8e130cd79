// Solves contacts: finds impulses that keep bodies apart, and friction that holds or slows them.
//
// The algorithm and its serial form stand in serial/rigid/contact_solver.cpp. Contacts of a batch share no body that
// moves, so their order does not matter. Sixteen of them are solved at once, one per lane, and all threads share a
// batch's vectors. A barrier stands between batches. A contact's numbers are put into vectors once a step, in the order
// of the batches. Lanes load and store a body's velocity as a whole record.
//
// The last batches hold a few contacts each. One thread takes several small batches in a row, which needs no barrier
// between them.
//
// A block of `blocks` is one thread's, which goes through its groups of sixteen in order. A barrier stands between
// rounds.
//
// In the original order a contact waits for the one before it at either of its bodies. Contacts that wait for none are
// level 0, those that wait for level 0 alone are level 1, and so on. Levels are batches, too, and keep the order
// wherever it matters.
//
// Source: [LRB08] Figures 12 and 13; [ITJ07] Figures 2 to 5. The contract stands in common/rigid/contact_solver.h, the
// formulas in common/rigid/contact_row.h.
#include "common/rigid/contact_solver.h"

#include <algorithm>
#include <memory>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/contact_row.h"
#include "common/simd.h"
#include "openmp/rigid/contact_plan.h"
#include "openmp/rigid/lanes.h"
#include "openmp/spatial/workspace.h"

namespace lockstep::rigid::openmp {
namespace {

// What contacts read and write of a body, in one cache line: its velocity, and how far it has moved since the step
// began.
struct alignas(array_alignment) BodyState {
  Motion<Real> motion, moved;
};
constexpr int records_of_body = sizeof(BodyState) / sizeof(Motion<Real>);

// Sixteen contacts of one batch, or the rest of it. Lanes without a contact repeat the first one. They have no point
// and move no body.
struct Contacts {
  Indices index, a, b;                                     // manifolds; bodies' records in the array of BodyStates
  std::uint16_t has_point[most_points], a_moves, b_moves;  // a bit a lane
  ContactConstraint<floatv> constraint;
};

// --- Contacts into lanes

ContactBody<floatv> load_body(const Bodies<Real>& bodies, const Indices& i) {
  const intv index = load(i.index);
  return {load_pose(bodies.pose, i), velocity_of(load_motion(bodies.motion, i)), load_quad(bodies.inverse_mass, i),
          gather(bodies.friction.data(), index), gather(bodies.restitution.data(), index)};
}

// Record `part` of structs that are several records of eight each.
template <class Struct>
Records load_part(std::span<const Struct> structs, const Indices& index, int part) {
  constexpr int parts = sizeof(Struct) / (8 * sizeof(Real));
  const Indices records = indices_of(load(index.index) * parts + part);
  return load_records(reinterpret_cast<const Real*>(structs.data()), records.index);
}
template <class Struct>
void store_part(std::span<Struct> structs, const Indices& index, int part, const Records& values, maskv mask) {
  constexpr int parts = sizeof(Struct) / (8 * sizeof(Real));
  const Indices records = indices_of(load(index.index) * parts + part);
  store_records(reinterpret_cast<Real*>(structs.data()), records.index, values, mask);
}

// Assigns up to sixteen contacts of a batch to lanes: their manifolds and bodies, and which lanes have points and
// bodies that move.
void assign_lanes(std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> order,
                  std::span<const std::int32_t> body, const Bodies<Real>& bodies, Contacts& contacts) {
  std::int32_t count[lanes];
  std::uint32_t a_moves = 0, b_moves = 0;
  for (int l = 0; l < lanes; ++l) {
    const bool there = l < static_cast<int>(order.size());
    const Manifold<Real>& m = manifolds[contacts.index.index[l] = order[there ? l : 0]];
    contacts.a.index[l] = body[m.a], contacts.b.index[l] = body[m.b];
    count[l] = there ? m.count : 0;
    a_moves |= std::uint32_t(there && bodies.inverse_mass[contacts.a.index[l]].w > 0) << l;
    b_moves |= std::uint32_t(there && bodies.inverse_mass[contacts.b.index[l]].w > 0) << l;
  }
  contacts.a_moves = static_cast<std::uint16_t>(a_moves), contacts.b_moves = static_cast<std::uint16_t>(b_moves);
  for (int k = 0; k < most_points; ++k) contacts.has_point[k] = static_cast<std::uint16_t>(bits(load(count) > k));
}

void make_contacts(std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> order, Real bounce_from,
                   std::span<const std::int32_t> body, const Bodies<Real>& bodies,
                   std::span<const Impulses<Real>> impulses, Contacts& contacts) {
  assign_lanes(manifolds, order, body, bodies, contacts);
  const ContactBody<floatv> a = load_body(bodies, contacts.a), b = load_body(bodies, contacts.b);
  ContactConstraint<floatv>& c = contacts.constraint;
  const Records head = load_part(manifolds, contacts.index, 0);
  make_constraint({head.field[0], head.field[1], head.field[2]}, a, b, c);
  const Records normals_and_tangents = load_part(impulses, contacts.index, 0),
                bitangents = load_part(impulses, contacts.index, 1);
  for (int k = 0; k < most_points && contacts.has_point[k] != 0; ++k) {
    const Records two_points = load_part(manifolds, contacts.index, 1 + k / 2);
    const floatv* field = two_points.field + 4 * (k % 2);
    const PointImpulse<floatv> impulse = {normals_and_tangents.field[k], normals_and_tangents.field[most_points + k],
                                          bitangents.field[k]};
    make_point<floatv>(c, a, b, {{field[0], field[1], field[2]}, field[3]}, impulse, bounce_from, c.point[k]);
  }
  contacts.a = indices_of(load(contacts.a.index) * records_of_body);
  contacts.b = indices_of(load(contacts.b.index) * records_of_body);
}

// Points that are not there get 0, as in match_contacts.
void store_impulses(const Contacts& contacts, std::span<Impulses<Real>> impulses) {
  Records normals_and_tangents, bitangents;
  for (int k = 0; k < most_points; ++k) {
    const maskv has_point = lanes_of(contacts.has_point[k]);
    const ConstraintPoint<floatv>& p = contacts.constraint.point[k];
    const auto impulse = [&](const Row<floatv>& row) {
      return any(has_point) ? select(has_point, row.impulse, 0.f) : 0.f;
    };
    normals_and_tangents.field[k] = impulse(p.normal);
    normals_and_tangents.field[most_points + k] = impulse(p.tangent);
    bitangents.field[k] = impulse(p.bitangent);
    bitangents.field[most_points + k] = 0.f;
  }
  store_part(impulses, contacts.index, 0, normals_and_tangents, lanes_of(contacts.has_point[0]));
  store_part(impulses, contacts.index, 1, bitangents, lanes_of(contacts.has_point[0]));
}

// --- Sweeps

// The motions in bodies' states, as records. Body i has record records_of_body * i.
std::span<Motion<Real>> motions(Array<BodyState>& states) {
  return {&states.data()->motion, records_of_body * states.size()};
}
std::span<Motion<Real>> movements(Array<BodyState>& states) { return motions(states).subspan(1); }

struct Velocities {
  Velocity<floatv> a, b;
};
LOCKSTEP_INLINE Velocities load_velocities(const Contacts& contacts, std::span<const Motion<Real>> motion) {
  return {velocity_of(load_motion(motion, contacts.a)), velocity_of(load_motion(motion, contacts.b))};
}
LOCKSTEP_INLINE void store_velocities(const Velocities& v, const Contacts& contacts, std::span<Motion<Real>> motion) {
  store_motion(motion, contacts.a, {v.a.linear, v.a.angular, {0.f, 0.f}}, lanes_of(contacts.a_moves));
  store_motion(motion, contacts.b, {v.b.linear, v.b.angular, {0.f, 0.f}}, lanes_of(contacts.b_moves));
}

void warm_start(const Contacts& contacts, Array<BodyState>& states) {
  const ContactConstraint<floatv>& c = contacts.constraint;
  Velocities v = load_velocities(contacts, motions(states));
  for (int k = 0; k < most_points && contacts.has_point[k] != 0; ++k)
    warm_start_point(lanes_of(contacts.has_point[k]), c, c.point[k], v.a, v.b);
  store_velocities(v, contacts, motions(states));
}

LOCKSTEP_INLINE void solve_frictions(Contacts& contacts, Velocities& v) {
  ContactConstraint<floatv>& c = contacts.constraint;
  for (int k = 0; k < most_points && contacts.has_point[k] != 0; ++k)
    solve_friction(lanes_of(contacts.has_point[k]), c, c.point[k], v.a, v.b);
}

LOCKSTEP_INLINE void solve_normals(Contacts& contacts, const Sweep<Real>& sweep, Array<BodyState>& states,
                                   Velocities& v) {
  ContactConstraint<floatv>& c = contacts.constraint;
  const Velocities moved = load_velocities(contacts, movements(states));
  const Sweep<floatv> in_lanes = {
      sweep.per_step, {sweep.soft.rate, sweep.soft.mass, sweep.soft.impulse}, sweep.max_bias_velocity};
  for (int k = 0; k < most_points && contacts.has_point[k] != 0; ++k)
    solve_normal(lanes_of(contacts.has_point[k]), c, c.point[k], in_lanes, moved.a, moved.b, v.a, v.b);
}

void solve_biased(Contacts& contacts, const Sweep<Real>& sweep, Array<BodyState>& states) {
  Velocities v = load_velocities(contacts, motions(states));
  solve_normals(contacts, sweep, states, v);
  store_velocities(v, contacts, motions(states));
}

void relax(Contacts& contacts, const Sweep<Real>& sweep, Array<BodyState>& states) {
  Velocities v = load_velocities(contacts, motions(states));
  solve_frictions(contacts, v);
  solve_normals(contacts, sweep, states, v);
  store_velocities(v, contacts, motions(states));
}

void bounce(const Contacts& contacts, Array<BodyState>& states) {
  const ContactConstraint<floatv>& c = contacts.constraint;
  Velocities v = load_velocities(contacts, motions(states));
  maskv changed = first_lanes(0);
  for (int k = 0; k < most_points && contacts.has_point[k] != 0; ++k) {
    const maskv bounces = lanes_of(contacts.has_point[k]) & has_bounce(c.point[k]);
    if (any(bounces)) solve_bounce(bounces, c, c.point[k], v.a, v.b);
    changed |= bounces;
  }
  if (any(changed)) store_velocities(v, contacts, motions(states));
}

// --- Orders

// The calling thread's own, kept from call to call (openmp/spatial/workspace.h says why).
struct Memory {
  Array<BodyState> states;
  Array<Motion<Real>> before;  // [body]: as the step found it
  std::unique_ptr<Contacts[]> contacts;
  int room = 0;  // contacts allocated

  // Contacts for the vectors of the plan. The team writes a page first, not the thread that asks.
  std::span<Contacts> make_room(int vectors) {
    if (room < vectors) {
      contacts.reset(), room = 0;
      contacts = std::make_unique_for_overwrite<Contacts[]>(vectors + vectors / 2);
      room = vectors + vectors / 2;
    }
    return {contacts.get(), static_cast<std::size_t>(vectors)};
  }
};
Memory& own_memory() {
  thread_local Memory mine;
  return mine;
}

// An order has `vectors` of contacts that are solved at once. The team calls order.prepare() before it asks for
// order.contacts(vector), the manifolds of one, and order.for_each(action), which calls action(vector) for all: of two
// that share a body that moves, the earlier comes first, and a barrier or one thread's own order stands between them.
template <class Order>
void solve(const SolverSettings& settings, std::span<const Manifold<Real>> manifolds,
           std::span<const std::int32_t> body, int vectors, const Order& order, Bodies<Real>& bodies,
           std::span<Impulses<Real>> impulses, Array<Motion<Real>>& moving) {
  const Substep<Real> substep = substep_of<Real>(settings);
  const auto moves = [&](int i) { return bodies.inverse_mass[i].w > 0; };
  Memory& memory = own_memory();
  const std::span<Contacts> contacts = memory.make_room(vectors);
  Array<BodyState>& states = memory.states;
  Array<Motion<Real>>& before = memory.before;
  spatial::openmp::grow(states, bodies.count);
  spatial::openmp::grow(before, bodies.count);
  moving.resize(bodies.motion.size(), {});
  std::fill(moving.begin() + bodies.count, moving.end(), Motion<Real>{});
  // In loops over bodies or vectors, each one belongs to one thread. Between two barriers other bodies' velocities are
  // only read.
#pragma omp parallel
  {
#pragma omp for schedule(static) nowait
    for (int i = 0; i < bodies.count; ++i) {
      before[i] = bodies.motion[i];
      states[i] = {bodies.motion[i], {}};
    }
    order.prepare();
#pragma omp for schedule(static)
    for (int i = 0; i < vectors; ++i)
      make_contacts(manifolds, order.contacts(i), static_cast<Real>(settings.bounce_from), body, bodies, impulses,
                    contacts[i]);
    const auto for_all = [&](const auto& action) { order.for_each([&](int i) { action(contacts[i]); }); };
    for (int part = 0; part < settings.substeps; ++part) {
#pragma omp for schedule(static)
      for (int i = 0; i < bodies.count; ++i)
        if (moves(i)) begin_substep(substep.gravity_dv, before[i], states[i].motion);
      if (part == 0) for_all([&](const Contacts& c) { warm_start(c, states); });
      for (int sweep = 0; sweep < settings.biased_sweeps; ++sweep)
        for_all([&](Contacts& c) { solve_biased(c, substep.biased, states); });
#pragma omp for schedule(static)
      for (int i = 0; i < bodies.count; ++i)
        if (moves(i)) move_on(substep.h, states[i].motion, states[i].moved);
      for (int sweep = 0; sweep < settings.relax_sweeps; ++sweep)
        for_all([&](Contacts& c) { relax(c, substep.relax, states); });
    }
    for_all([&](const Contacts& c) { bounce(c, states); });
    const Real per_step = static_cast<Real>(1 / settings.time_step);
#pragma omp for schedule(static)
    for (int i = 0; i < bodies.count; ++i) {
      bodies.motion[i] = states[i].motion;
      moving[i] = mean_motion(per_step, states[i].moved);
    }
    // A manifold is in one vector, so its impulses belong to one thread.
#pragma omp for schedule(static)
    for (int i = 0; i < vectors; ++i) store_impulses(contacts[i], impulses);
  }
}

// The order of blocks, likewise.
struct InBlocks {
  const ContactBlocks& blocks;

  void prepare() const {}
  std::span<const std::int32_t> contacts(int group) const {
    return {&blocks.order[blocks.groups[group]],
            static_cast<std::size_t>(blocks.groups[group + 1] - blocks.groups[group])};
  }
  // The blocks of a round share no body that moves, and one thread takes the groups of a block in order. The barrier at
  // the end of a round makes its writes visible to the next one.
  template <class Action>
  void for_each(const Action& action) const {
    for (std::size_t round = 0; round + 1 < blocks.rounds.size(); ++round) {
#pragma omp for schedule(static)
      for (int block = blocks.rounds[round]; block < blocks.rounds[round + 1]; ++block)
        for (int group = blocks.blocks[block]; group < blocks.blocks[block + 1]; ++group) action(group);
    }
  }
};

}  // namespace

void contact_solver_batches(const SolverSettings& settings, std::span<const Manifold<Real>> manifolds,
                            std::span<const std::int32_t> body, const Batches& batches, Bodies<Real>& bodies,
                            std::span<Impulses<Real>> impulses, Array<Motion<Real>>& moving) {
  thread_local Plan kept;
  Plan& plan = kept;  // the team's threads would each see their own `kept`
  cut(batches, plan);
  const InBatches<Real> order = {batches, manifolds, plan};
  solve(settings, manifolds, body, static_cast<int>(plan.vectors.size()), order, bodies, impulses, moving);
}

void contact_solver_blocks(const SolverSettings& settings, std::span<const Manifold<Real>> manifolds,
                           std::span<const std::int32_t> body, const ContactBlocks& blocks, Bodies<Real>& bodies,
                           std::span<Impulses<Real>> impulses, Array<Motion<Real>>& moving) {
  const InBlocks order = {blocks};
  solve(settings, manifolds, body, static_cast<int>(blocks.groups.size()) - 1, order, bodies, impulses, moving);
}

void contact_solver_original(const SolverSettings& settings, std::span<const Manifold<Real>> manifolds,
                             std::span<const std::int32_t> body, Bodies<Real>& bodies,
                             std::span<Impulses<Real>> impulses, Array<Motion<Real>>& moving) {
  std::vector<std::int32_t> a, b;
  for (const Manifold<Real>& m : manifolds) a.push_back(body[m.a]), b.push_back(body[m.b]);
  std::vector<char> movable(bodies.count);
  for (int i = 0; i < bodies.count; ++i) movable[i] = bodies.inverse_mass[i].w > 0;
  contact_solver_batches(settings, manifolds, body, make_levels(a, b, movable), bodies, impulses, moving);
}

}  // namespace lockstep::rigid::openmp
