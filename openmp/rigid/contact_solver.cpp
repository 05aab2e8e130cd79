// Contacts, solved: impulses such that bodies do not move into one another, and friction holds or slows them.
//
// The algorithm, and its serial form, stand in serial/rigid/contact_solver.cpp. Contacts of a batch share no body that moves, so whichever
// comes first, each sees the same velocities: sixteen of them are solved at once, one a lane, and a batch's vectors on all threads. Between
// batches is a barrier. A contact's numbers are put into vectors once a step, in the order of the batches; of a body, lanes load the whole
// record of its velocity, and store it.
//
// Batches shrink: the last ones hold a few contacts each. Several small batches in a row are one thread's, which needs no barrier between
// them.
//
// In the original order a contact waits for the one before it at either of its bodies. Those that wait for nobody are level 0, those that
// wait for level 0 alone are level 1: levels are batches, too, and leave the order as it was where it matters.
//
// Source: [LRB08] Figures 12 and 13; [ITJ07] Figures 2 to 5. The contract stands in common/rigid/contact_solver.h.
#include "common/rigid/contact_solver.h"

#include <algorithm>
#include <bit>
#include <memory>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/contact_row.h"
#include "common/simd.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {
namespace {

// What contacts read and write of a body, in one cache line: how fast it moves, and how far it has come since the step began.
struct alignas(array_alignment) BodyState {
  Motion<Real> motion, moved;
};
constexpr int records_of_body = sizeof(BodyState) / sizeof(Motion<Real>);

// Sixteen contacts of one batch, or what is left of it.
struct Contacts {
  Indices index, a, b;  // manifolds; bodies' records of motion; some of the batch in lanes without a contact
  std::uint16_t has_point[most_points], a_moves, b_moves;
  ContactConstraint<floatv> constraint;
};

LOCKSTEP_INLINE Velocity<floatv> load_motion(const Motion<Real>& first, const Indices& records) {
  const Records r = load_records(&first.velocity.x, records.index);
  return {{r.field[0], r.field[1], r.field[2]}, {r.field[3], r.field[4], r.field[5]}};
}
LOCKSTEP_INLINE Velocity<floatv> load_velocities(const Array<BodyState>& bodies, const Indices& records) {
  return load_motion(bodies.data()->motion, records);
}
LOCKSTEP_INLINE Velocity<floatv> load_moved(const Array<BodyState>& bodies, const Indices& records) {
  return load_motion(bodies.data()->moved, records);
}

LOCKSTEP_INLINE void write(const Velocity<floatv>& v, const Indices& records, maskv moves, Array<BodyState>& bodies) {
  store_records(&bodies.data()->motion.velocity.x, records.index,
                {v.linear.x, v.linear.y, v.linear.z, v.angular.x, v.angular.y, v.angular.z, 0.f, 0.f}, moves);
}

Movability<floatv> movability_of(const Bodies<Real>& bodies, const Indices& indices, const Quaternion<floatv>& orientation) {
  const Quad<floatv> inverse = load_quad(bodies.inverse_mass, indices);
  return {inverse.w, turned(matrix_of(orientation), inverse.x, inverse.y, inverse.z)};
}

// Up to sixteen contacts of a batch, from `order` on.
void make_contacts(std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> order, Real bounce_from,
                   std::span<const std::int32_t> body, const Bodies<Real>& bodies, std::span<const Impulses<Real>> impulses,
                   Contacts& contacts) {
  std::int32_t records[lanes], count[lanes];
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

  constexpr int records_each = sizeof(Manifold<Real>) / (8 * sizeof(Real)),
                impulse_records_each = sizeof(Impulses<Real>) / (8 * sizeof(Real));
  const auto records_of = [&](const auto* base, int each, int which) {
    for (int l = 0; l < lanes; ++l) records[l] = each * contacts.index.index[l] + which;
    return load_records(reinterpret_cast<const Real*>(base), records);
  };
  const auto manifold_records = [&](int which) { return records_of(manifolds.data(), records_each, which); };

  const Pose<floatv> pose_a = load_pose(bodies.pose, contacts.a), pose_b = load_pose(bodies.pose, contacts.b);
  const Motion<Real>& motion = *bodies.motion.data();
  const Velocity<floatv> a = load_motion(motion, contacts.a), b = load_motion(motion, contacts.b);
  ContactConstraint<floatv>& c = contacts.constraint;
  const Records head = manifold_records(0);
  c.normal = {head.field[0], head.field[1], head.field[2]};
  make_tangents(c.normal, c.tangent, c.bitangent);
  const auto of_body = [&](const Array<Real>& value, const Indices& indices) { return gather(value.data(), load(indices.index)); };
  c.friction = sqrt(of_body(bodies.friction, contacts.a) * of_body(bodies.friction, contacts.b));
  c.a = movability_of(bodies, contacts.a, pose_a.orientation), c.b = movability_of(bodies, contacts.b, pose_b.orientation);
  const floatv restitution = max(of_body(bodies.restitution, contacts.a), of_body(bodies.restitution, contacts.b));

  const Records along_normal_and_tangent = records_of(impulses.data(), impulse_records_each, 0);
  const Records along_bitangent = records_of(impulses.data(), impulse_records_each, 1);
  for (int pair = 0; pair < most_points / 2; ++pair) {
    const Records two_points = manifold_records(1 + pair);
    for (int k = 2 * pair; k < 2 * pair + 2; ++k) {
      contacts.has_point[k] = static_cast<std::uint16_t>(bits(load(count) > k));
      if (contacts.has_point[k] == 0) continue;
      const floatv* field = two_points.field + 4 * (k % 2);
      const Vector3<floatv> position = {field[0], field[1], field[2]};
      ConstraintPoint<floatv>& p = c.point[k];
      p.arm_a = position - pose_a.position;
      p.arm_b = position - pose_b.position;
      p.normal = {effective_mass(c, p, c.normal), along_normal_and_tangent.field[k]};
      p.tangent = {effective_mass(c, p, c.tangent), along_normal_and_tangent.field[4 + k]};
      p.bitangent = {effective_mass(c, p, c.bitangent), along_bitangent.field[k]};
      const floatv approach = dot(relative_velocity(a, b, p), c.normal);
      p.separation = field[3];
      p.hardest = 0.f;
      p.bounce = select(approach < -bounce_from, -restitution * approach, 0.f);
    }
  }
  for (int l = 0; l < lanes; ++l) contacts.a.index[l] *= records_of_body, contacts.b.index[l] *= records_of_body;
}

// Applies an impulse in the lanes that have the point.
LOCKSTEP_INLINE void apply_where(maskv has_point, const ContactConstraint<floatv>& c, const ConstraintPoint<floatv>& p,
                                 const Vector3<floatv>& impulse, Velocity<floatv>& a, Velocity<floatv>& b) {
  if (all(has_point)) return apply(c, p, impulse, a, b);
  const Velocity<floatv> old_a = a, old_b = b;
  apply(c, p, impulse, a, b);
  const auto keep = [&](Vector3<floatv>& v, const Vector3<floatv>& old) {
    v = {select(has_point, v.x, old.x), select(has_point, v.y, old.y), select(has_point, v.z, old.z)};
  };
  keep(a.linear, old_a.linear), keep(a.angular, old_a.angular), keep(b.linear, old_b.linear), keep(b.angular, old_b.angular);
}

// The impulses of the last step, all at once.
void warm_start(const Contacts& contacts, Array<BodyState>& bodies) {
  const ContactConstraint<floatv>& c = contacts.constraint;
  Velocity<floatv> a = load_velocities(bodies, contacts.a), b = load_velocities(bodies, contacts.b);
  for (int k = 0; k < most_points && contacts.has_point[k] != 0; ++k) {
    const ConstraintPoint<floatv>& p = c.point[k];
    apply_where(lanes_of(contacts.has_point[k]), c, p,
                p.normal.impulse * c.normal + p.tangent.impulse * c.tangent + p.bitangent.impulse * c.bitangent, a, b);
  }
  write(a, contacts.a, lanes_of(contacts.a_moves), bodies);
  write(b, contacts.b, lanes_of(contacts.b_moves), bodies);
}

// Friction holds, as far as the normal impulses so far let it.
LOCKSTEP_INLINE void hold(Contacts& contacts, Velocity<floatv>& a, Velocity<floatv>& b) {
  ContactConstraint<floatv>& c = contacts.constraint;
  for (int k = 0; k < most_points && contacts.has_point[k] != 0; ++k) {
    ConstraintPoint<floatv>& p = c.point[k];
    const maskv has_point = lanes_of(contacts.has_point[k]);
    const floatv most = c.friction * p.normal.impulse;
    const auto slide = [&](Row<floatv>& row, const Vector3<floatv>& direction) {
      const floatv change = friction_step(row, dot(relative_velocity(a, b, p), direction), most);
      row.impulse += change;
      apply_where(has_point, c, p, change * direction, a, b);
    };
    slide(p.tangent, c.tangent);
    slide(p.bitangent, c.bitangent);
  }
}

// Points keep apart.
LOCKSTEP_INLINE void press(Contacts& contacts, const Sweep<Real>& sweep, const Array<BodyState>& bodies, Velocity<floatv>& a,
                           Velocity<floatv>& b) {
  ContactConstraint<floatv>& c = contacts.constraint;
  const Velocity<floatv> moved_a = load_moved(bodies, contacts.a), moved_b = load_moved(bodies, contacts.b);
  const Softness<floatv> soft = {sweep.soft.rate, sweep.soft.mass, sweep.soft.impulse};
  for (int k = 0; k < most_points && contacts.has_point[k] != 0; ++k) {
    ConstraintPoint<floatv>& p = c.point[k];
    const floatv separation = p.separation + dot(relative_velocity(moved_a, moved_b, p), c.normal);
    const floatv parting = dot(relative_velocity(a, b, p), c.normal);
    const floatv change = normal_step<floatv>(p.normal, parting, separation, sweep.per_step, soft, sweep.most_push);
    p.normal.impulse += change;
    p.hardest = max(p.hardest, p.normal.impulse);
    apply_where(lanes_of(contacts.has_point[k]), c, p, change * c.normal, a, b);
  }
}

void push(Contacts& contacts, const Sweep<Real>& sweep, Array<BodyState>& bodies) {
  Velocity<floatv> a = load_velocities(bodies, contacts.a), b = load_velocities(bodies, contacts.b);
  press(contacts, sweep, bodies, a, b);
  write(a, contacts.a, lanes_of(contacts.a_moves), bodies);
  write(b, contacts.b, lanes_of(contacts.b_moves), bodies);
}

void rest(Contacts& contacts, const Sweep<Real>& sweep, Array<BodyState>& bodies) {
  Velocity<floatv> a = load_velocities(bodies, contacts.a), b = load_velocities(bodies, contacts.b);
  hold(contacts, a, b);
  press(contacts, sweep, bodies, a, b);
  write(a, contacts.a, lanes_of(contacts.a_moves), bodies);
  write(b, contacts.b, lanes_of(contacts.b_moves), bodies);
}

// Points that came fast, and were hit, leave again. What that takes is no start for the next step, and is not kept.
void bounce(const Contacts& contacts, Array<BodyState>& bodies) {
  const ContactConstraint<floatv>& c = contacts.constraint;
  Velocity<floatv> a = load_velocities(bodies, contacts.a), b = load_velocities(bodies, contacts.b);
  maskv any_point = first_lanes(0);
  for (int k = 0; k < most_points && contacts.has_point[k] != 0; ++k) {
    const ConstraintPoint<floatv>& p = c.point[k];
    const maskv bounces = lanes_of(contacts.has_point[k]) & (p.bounce > 0.f) & (p.hardest > 0.f);
    if (none(bounces)) continue;
    any_point |= bounces;
    const floatv change = bounce_step(p.normal, dot(relative_velocity(a, b, p), c.normal), p.bounce);
    apply_where(bounces, c, p, change * c.normal, a, b);
  }
  if (none(any_point)) return;
  write(a, contacts.a, lanes_of(contacts.a_moves) & any_point, bodies);
  write(b, contacts.b, lanes_of(contacts.b_moves) & any_point, bodies);
}

// Impulses of points that are not there are written, too, and hold nothing.
void keep_impulses(const Contacts& contacts, std::span<Impulses<Real>> impulses) {
  floatv row[3 * most_points];
  for (int k = 0; k < most_points; ++k) {
    const ConstraintPoint<floatv>& p = contacts.constraint.point[k];
    row[k] = p.normal.impulse, row[most_points + k] = p.tangent.impulse, row[2 * most_points + k] = p.bitangent.impulse;
  }
  for (int k = 0; k < most_points; ++k)
    for (std::uint32_t set = contacts.has_point[k]; set != 0; set &= set - 1) {
      const int l = std::countr_zero(set);
      Impulses<Real>& to = impulses[contacts.index.index[l]];
      const auto lane = [&](const floatv& v) { return reinterpret_cast<const Real*>(&v)[l]; };
      to.normal[k] = lane(row[k]), to.tangent[k] = lane(row[most_points + k]), to.bitangent[k] = lane(row[2 * most_points + k]);
    }
}

// Vectors of contacts, begin .. end - 1, between two barriers: of one batch, or of several small ones in order, which one thread takes.
struct Stage {
  int begin, end;
  bool small;
};

constexpr int small_batch = 4;  // vectors: less than what a barrier costs

// Contacts in the order in which they are put into vectors, the vectors, and stages.
struct Plan {
  std::vector<std::int32_t> order;                      // manifolds, batch after batch
  std::vector<std::span<const std::int32_t>> contacts;  // [vector]: part of `order`
  std::vector<Stage> stages;
};

// Within a batch contacts with as many points stand together, so that few lanes wait for others' points; whatever the order in a batch, the
// bits are the same.
Plan make_plan(const Batches& batches, std::span<const Manifold<Real>> manifolds) {
  Plan plan;
  plan.order.resize(batches.order.size());
  for (int k = 0; k < batches.count(); ++k) {
    const int batch_begin = batches.begin[k], batch_end = batches.begin[k + 1];
    int next[most_points + 2] = {};  // [points fewer than most]: where the next of them goes
    for (int i = batch_begin; i < batch_end; ++i) ++next[most_points - manifolds[batches.order[i]].count + 1];
    next[0] = batch_begin;
    for (int fewer = 0; fewer < most_points; ++fewer) next[fewer + 1] += next[fewer];
    for (int i = batch_begin; i < batch_end; ++i) {
      const std::int32_t contact = batches.order[i];
      plan.order[next[most_points - manifolds[contact].count]++] = contact;
    }

    const int begin = static_cast<int>(plan.contacts.size());
    for (int first = batch_begin; first < batch_end; first += lanes)
      plan.contacts.push_back({plan.order.data() + first, static_cast<std::size_t>(std::min(lanes, batch_end - first))});
    const int end = static_cast<int>(plan.contacts.size());
    const bool small = end - begin < small_batch;
    if (small && !plan.stages.empty() && plan.stages.back().small)
      plan.stages.back().end = end;
    else
      plan.stages.push_back({begin, end, small});
  }
  return plan;
}

}  // namespace

void solve_contacts_batches(const SolverSettings& settings, std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                            const Batches& batches, Bodies<Real>& bodies, std::span<Impulses<Real>> impulses, Array<Motion<Real>>& moving) {
  const Substep<Real> part = substep_of<Real>(settings);
  const Plan plan = make_plan(batches, manifolds);
  const int vectors = static_cast<int>(plan.contacts.size());
  const std::unique_ptr<Contacts[]> contacts(new Contacts[vectors]);  // uninitialised
  Array<BodyState> states(bodies.count);
  Array<Motion<Real>> before = bodies.motion;
  moving.assign(bodies.motion.size(), {});
#pragma omp parallel
  {
    // In a stage vectors share no body that moves, or are one thread's in order; the barrier at its end lets the next one see what it
    // wrote.
    const auto for_each_contact = [&](const auto& action) {
      for (const Stage& stage : plan.stages) {
        if (stage.small) {
#pragma omp single
          for (int i = stage.begin; i < stage.end; ++i) action(contacts[i]);
        } else {
#pragma omp for schedule(static)
          for (int i = stage.begin; i < stage.end; ++i) action(contacts[i]);
        }
      }
    };
    // Here and below every body and every vector is one thread's; velocities are read alone.
#pragma omp for schedule(static)
    for (int i = 0; i < bodies.count; ++i) states[i] = {bodies.motion[i], {}};
#pragma omp for schedule(static)
    for (int i = 0; i < vectors; ++i)
      make_contacts(manifolds, plan.contacts[i], static_cast<Real>(settings.bounce_from), body, bodies, impulses, contacts[i]);
    for (int substep = 0; substep < settings.substeps; ++substep) {
#pragma omp for schedule(static)
      for (int i = 0; i < bodies.count; ++i)
        if (bodies.inverse_mass[i].w > 0) begin_substep(part.gained, before[i], states[i].motion);
      if (substep == 0) for_each_contact([&](Contacts& c) { warm_start(c, states); });
      for (int sweep = 0; sweep < settings.pushing; ++sweep) for_each_contact([&](Contacts& c) { push(c, part.pushing, states); });
#pragma omp for schedule(static)
      for (int i = 0; i < bodies.count; ++i) {
        if (!(bodies.inverse_mass[i].w > 0)) continue;
        auto& [motion, moved] = states[i];
        moved.velocity = moved.velocity + part.h * motion.velocity;
        moved.angular_velocity = moved.angular_velocity + part.h * motion.angular_velocity;
      }
      for (int sweep = 0; sweep < settings.resting; ++sweep) for_each_contact([&](Contacts& c) { rest(c, part.resting, states); });
    }
    for_each_contact([&](const Contacts& c) { bounce(c, states); });
    const Real per_step = static_cast<Real>(1 / settings.time_step);
#pragma omp for schedule(static)
    for (int i = 0; i < bodies.count; ++i) {
      const auto& [motion, moved] = states[i];
      bodies.motion[i] = motion;
      moving[i].velocity = per_step * moved.velocity;
      moving[i].angular_velocity = per_step * moved.angular_velocity;
    }
    // A manifold is in one vector.
#pragma omp for schedule(static)
    for (int i = 0; i < vectors; ++i) keep_impulses(contacts[i], impulses);
  }
}

void solve_contacts_original(const SolverSettings& settings, std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                             Bodies<Real>& bodies, std::span<Impulses<Real>> impulses, Array<Motion<Real>>& moving) {
  std::vector<std::int32_t> a, b;
  for (const Manifold<Real>& m : manifolds) a.push_back(body[m.a]), b.push_back(body[m.b]);
  std::vector<char> movable(bodies.count);
  for (int i = 0; i < bodies.count; ++i) movable[i] = bodies.inverse_mass[i].w > 0;
  solve_contacts_batches(settings, manifolds, body, make_levels(a, b, movable), bodies, impulses, moving);
}

}  // namespace lockstep::rigid::openmp
