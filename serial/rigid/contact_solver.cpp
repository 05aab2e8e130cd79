// Contacts, solved: impulses such that bodies do not move into one another, and friction holds or slows them.
//
// Every point of contact is three conditions on two bodies' velocities: one along the normal (no approach, no pull) and two along tangents
// (no sliding, as far as friction reaches). All of them at once are a linear complementarity problem. Projected Gauss-Seidel solves one at
// a time, as if the others were done, and goes round: what one impulse upsets at its bodies' other contacts, their turn repairs. A stack
// needs about as many rounds as it is high; but it stands still from step to step, so each step begins with the impulses of the last one.
//
// A step is taken in several small ones, with few sweeps each. Bodies that penetrate are pushed apart softly; as that speed is not their
// own, a rigid sweep follows that takes it back.
//
// The order of contacts matters: Gauss-Seidel uses what it has just found. `original` takes them as they come, `batches` as a parallel
// machine can: the same algorithm in another order.
//
// Source: [LRB08] "Rigid Body Simulation"; [ITJ07] Figures 2 to 5. The contract stands in common/rigid/contact_solver.h.
#include "common/rigid/contact_solver.h"

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/contact_row.h"

namespace lockstep::rigid::serial {
namespace {

struct Contact {
  std::int32_t a, b, count;  // bodies; points
  ContactConstraint<Real> constraint;
};

Velocity<Real> velocity_of(const Motion<Real>& motion) { return {motion.velocity, motion.angular_velocity}; }

Movability<Real> movability_of(const Bodies<Real>& bodies, int i) {
  const Quad<Real>& inverse = bodies.inverse_mass[i];
  return {inverse.w, turned(matrix_of(bodies.pose[i].orientation), inverse.x, inverse.y, inverse.z)};
}

Contact make_contact(const Manifold<Real>& m, Real bounce_from, std::span<const std::int32_t> body, const Bodies<Real>& bodies,
                     const Impulses<Real>& impulses) {
  Contact contact{body[m.a], body[m.b], m.count, {}};
  const auto [a, b] = std::pair(contact.a, contact.b);
  ContactConstraint<Real>& c = contact.constraint;
  c.normal = m.normal;
  make_tangents(c.normal, c.tangent, c.bitangent);
  c.friction = sqrt(bodies.friction[a] * bodies.friction[b]);
  c.a = movability_of(bodies, a), c.b = movability_of(bodies, b);
  const Real restitution = max(bodies.restitution[a], bodies.restitution[b]);
  for (int k = 0; k < m.count; ++k) {
    ConstraintPoint<Real>& p = c.point[k];
    p.arm_a = m.point[k].position - bodies.pose[a].position;
    p.arm_b = m.point[k].position - bodies.pose[b].position;
    p.normal = {effective_mass(c, p, c.normal), impulses.normal[k]};
    p.tangent = {effective_mass(c, p, c.tangent), impulses.tangent[k]};
    p.bitangent = {effective_mass(c, p, c.bitangent), impulses.bitangent[k]};
    const Real approach = dot(relative_velocity(velocity_of(bodies.motion[a]), velocity_of(bodies.motion[b]), p), c.normal);
    p.separation = m.point[k].separation;
    p.hardest = 0;
    p.bounce = select(approach < -bounce_from, -restitution * approach, Real(0));
  }
  return contact;
}

void write(const Velocity<Real>& v, const Bodies<Real>& bodies, int i, Array<Motion<Real>>& motion) {
  if (bodies.inverse_mass[i].w == 0) return;
  motion[i].velocity = v.linear;
  motion[i].angular_velocity = v.angular;
}

// The impulses of the last step, all at once.
void warm_start(const Contact& contact, Bodies<Real>& bodies) {
  const ContactConstraint<Real>& c = contact.constraint;
  Velocity<Real> a = velocity_of(bodies.motion[contact.a]), b = velocity_of(bodies.motion[contact.b]);
  for (int k = 0; k < contact.count; ++k) {
    const ConstraintPoint<Real>& p = c.point[k];
    apply(c, p, p.normal.impulse * c.normal + p.tangent.impulse * c.tangent + p.bitangent.impulse * c.bitangent, a, b);
  }
  write(a, bodies, contact.a, bodies.motion);
  write(b, bodies, contact.b, bodies.motion);
}

// Friction holds, as far as the normal impulses so far let it.
void hold(Contact& contact, Velocity<Real>& a, Velocity<Real>& b) {
  ContactConstraint<Real>& c = contact.constraint;
  for (int k = 0; k < contact.count; ++k) {
    ConstraintPoint<Real>& p = c.point[k];
    const Real most = c.friction * p.normal.impulse;
    const auto slide = [&](Row<Real>& row, const Vector3<Real>& direction) {
      const Real change = friction_step(row, dot(relative_velocity(a, b, p), direction), most);
      row.impulse += change;
      apply(c, p, change * direction, a, b);
    };
    slide(p.tangent, c.tangent);
    slide(p.bitangent, c.bitangent);
  }
}

// Points keep apart. `moved` is how far bodies have come since the step began.
void press(Contact& contact, const Sweep<Real>& sweep, const Array<Motion<Real>>& moved, Velocity<Real>& a, Velocity<Real>& b) {
  ContactConstraint<Real>& c = contact.constraint;
  const Velocity<Real> moved_a = velocity_of(moved[contact.a]), moved_b = velocity_of(moved[contact.b]);
  for (int k = 0; k < contact.count; ++k) {
    ConstraintPoint<Real>& p = c.point[k];
    const Real separation = p.separation + dot(relative_velocity(moved_a, moved_b, p), c.normal);
    const Real parting = dot(relative_velocity(a, b, p), c.normal);
    const Real change = normal_step(p.normal, parting, separation, sweep.per_step, sweep.soft, sweep.most_push);
    p.normal.impulse += change;
    p.hardest = max(p.hardest, p.normal.impulse);
    apply(c, p, change * c.normal, a, b);
  }
}

void push(Contact& contact, const Sweep<Real>& sweep, const Array<Motion<Real>>& moved, Bodies<Real>& bodies) {
  Velocity<Real> a = velocity_of(bodies.motion[contact.a]), b = velocity_of(bodies.motion[contact.b]);
  press(contact, sweep, moved, a, b);
  write(a, bodies, contact.a, bodies.motion);
  write(b, bodies, contact.b, bodies.motion);
}

void rest(Contact& contact, const Sweep<Real>& sweep, const Array<Motion<Real>>& moved, Bodies<Real>& bodies) {
  Velocity<Real> a = velocity_of(bodies.motion[contact.a]), b = velocity_of(bodies.motion[contact.b]);
  hold(contact, a, b);
  press(contact, sweep, moved, a, b);
  write(a, bodies, contact.a, bodies.motion);
  write(b, bodies, contact.b, bodies.motion);
}

// Points that came fast, and were hit, leave again. What that takes is no start for the next step, and is not kept.
void bounce(const Contact& contact, Bodies<Real>& bodies) {
  const ContactConstraint<Real>& c = contact.constraint;
  Velocity<Real> a = velocity_of(bodies.motion[contact.a]), b = velocity_of(bodies.motion[contact.b]);
  bool any = false;
  for (int k = 0; k < contact.count; ++k) {
    const ConstraintPoint<Real>& p = c.point[k];
    if (!(p.bounce > 0 && p.hardest > 0)) continue;
    any = true;
    const Real change = bounce_step(p.normal, dot(relative_velocity(a, b, p), c.normal), p.bounce);
    apply(c, p, change * c.normal, a, b);
  }
  if (!any) return;
  write(a, bodies, contact.a, bodies.motion);
  write(b, bodies, contact.b, bodies.motion);
}

void solve_in_order(const SolverSettings& settings, std::vector<Contact>& contacts, Bodies<Real>& bodies, Array<Motion<Real>>& moving) {
  const Substep<Real> part = substep_of<Real>(settings);
  Array<Motion<Real>>& moved = moving;
  moved.assign(bodies.motion.size(), {});
  Array<Motion<Real>> before = bodies.motion;
  for (int substep = 0; substep < settings.substeps; ++substep) {
    for (int i = 0; i < bodies.count; ++i)
      if (bodies.inverse_mass[i].w > 0) begin_substep(part.gained, before[i], bodies.motion[i]);
    if (substep == 0)
      for (const Contact& contact : contacts) warm_start(contact, bodies);
    for (int sweep = 0; sweep < settings.pushing; ++sweep)
      for (Contact& contact : contacts) push(contact, part.pushing, moved, bodies);
    for (int i = 0; i < bodies.count; ++i) {
      if (!(bodies.inverse_mass[i].w > 0)) continue;
      moved[i].velocity = moved[i].velocity + part.h * bodies.motion[i].velocity;
      moved[i].angular_velocity = moved[i].angular_velocity + part.h * bodies.motion[i].angular_velocity;
    }
    for (int sweep = 0; sweep < settings.resting; ++sweep)
      for (Contact& contact : contacts) rest(contact, part.resting, moved, bodies);
  }
  for (const Contact& contact : contacts) bounce(contact, bodies);
  const Real per_step = static_cast<Real>(1 / settings.time_step);
  for (int i = 0; i < bodies.count; ++i) {
    moving[i].velocity = per_step * moved[i].velocity;
    moving[i].angular_velocity = per_step * moved[i].angular_velocity;
  }
}

void keep_impulses(const Contact& contact, Impulses<Real>& impulses) {
  for (int k = 0; k < contact.count; ++k) {
    const ConstraintPoint<Real>& p = contact.constraint.point[k];
    impulses.normal[k] = p.normal.impulse;
    impulses.tangent[k] = p.tangent.impulse;
    impulses.bitangent[k] = p.bitangent.impulse;
  }
}

}  // namespace

void solve_contacts_original(const SolverSettings& settings, std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                             Bodies<Real>& bodies, std::span<Impulses<Real>> impulses, Array<Motion<Real>>& moving) {
  std::vector<Contact> contacts;
  contacts.reserve(manifolds.size());
  for (std::size_t k = 0; k < manifolds.size(); ++k)
    contacts.push_back(make_contact(manifolds[k], static_cast<Real>(settings.bounce_from), body, bodies, impulses[k]));
  solve_in_order(settings, contacts, bodies, moving);
  for (std::size_t k = 0; k < manifolds.size(); ++k) keep_impulses(contacts[k], impulses[k]);
}

void solve_contacts_batches(const SolverSettings& settings, std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                            const Batches& batches, Bodies<Real>& bodies, std::span<Impulses<Real>> impulses, Array<Motion<Real>>& moving) {
  std::vector<Contact> contacts;
  contacts.reserve(manifolds.size());
  for (const std::int32_t k : batches.order)
    contacts.push_back(make_contact(manifolds[k], static_cast<Real>(settings.bounce_from), body, bodies, impulses[k]));
  solve_in_order(settings, contacts, bodies, moving);
  for (std::size_t i = 0; i < contacts.size(); ++i) keep_impulses(contacts[i], impulses[batches.order[i]]);
}

}  // namespace lockstep::rigid::serial
