// Solves contacts: finds impulses that keep bodies apart, and friction that holds or slows them.
//
// Every contact point has three conditions on two bodies' velocities: one along the normal (no approach, no pull) and
// two along tangents (no sliding, within the friction cone). All together are a linear complementarity problem.
// Projected Gauss-Seidel solves one condition at a time as if all others held, and repeats. Later sweeps repair what
// one impulse upsets at the bodies' other contacts. A stack needs about as many sweeps as it is high. But a stack at
// rest is the same from step to step, so each step starts with the impulses of the last one (warm start).
//
// A step is divided into substeps of few sweeps each. The biased solve pushes penetrating bodies apart softly. The
// relaxation, a rigid sweep, then removes that bias velocity, which is not the bodies' own.
//
// The order of contacts matters, because Gauss-Seidel uses each result at once. `original` takes contacts in the order
// of manifolds, `batches` and `blocks` in orders that a parallel machine can follow. The algorithm is the same.
//
// Source: [LRB08] "Rigid Body Simulation"; [ITJ07] Figures 2 to 5. The contract stands in
// common/rigid/contact_solver.h, the formulas in common/rigid/contact_row.h.
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

ContactBody<Real> load_body(const Bodies<Real>& bodies, int i) {
  return {bodies.pose[i], velocity_of(bodies.motion[i]), bodies.inverse_mass[i], bodies.friction[i],
          bodies.restitution[i]};
}

Contact make_contact(const Manifold<Real>& m, Real bounce_from, std::span<const std::int32_t> body,
                     const Bodies<Real>& bodies, const Impulses<Real>& impulses) {
  Contact contact{body[m.a], body[m.b], m.count, {}};
  const ContactBody<Real> a = load_body(bodies, contact.a), b = load_body(bodies, contact.b);
  ContactConstraint<Real>& c = contact.constraint;
  make_constraint(m.normal, a, b, c);
  for (int k = 0; k < m.count; ++k) {
    const PointImpulse<Real> impulse = {impulses.normal[k], impulses.tangent[k], impulses.bitangent[k]};
    make_point(c, a, b, m.point[k], impulse, bounce_from, c.point[k]);
  }
  return contact;
}

struct Velocities {
  Velocity<Real> a, b;
};
Velocities load_velocities(const Contact& contact, const Array<Motion<Real>>& motion) {
  return {velocity_of(motion[contact.a]), velocity_of(motion[contact.b])};
}
void store_velocities(const Velocities& v, const Contact& contact, Bodies<Real>& bodies) {
  const auto store = [&](const Velocity<Real>& velocity, std::int32_t i) {
    if (bodies.inverse_mass[i].w == 0) return;
    bodies.motion[i].velocity = velocity.linear;
    bodies.motion[i].angular_velocity = velocity.angular;
  };
  store(v.a, contact.a);
  store(v.b, contact.b);
}

void warm_start(const Contact& contact, Bodies<Real>& bodies) {
  const ContactConstraint<Real>& c = contact.constraint;
  Velocities v = load_velocities(contact, bodies.motion);
  for (int k = 0; k < contact.count; ++k) warm_start_point(true, c, c.point[k], v.a, v.b);
  store_velocities(v, contact, bodies);
}

void solve_frictions(Contact& contact, Velocities& v) {
  ContactConstraint<Real>& c = contact.constraint;
  for (int k = 0; k < contact.count; ++k) solve_friction(true, c, c.point[k], v.a, v.b);
}

// movement[body]: how far the body has moved since the step began.
void solve_normals(Contact& contact, const Sweep<Real>& sweep, const Array<Motion<Real>>& movement, Velocities& v) {
  ContactConstraint<Real>& c = contact.constraint;
  const Velocities moved = load_velocities(contact, movement);
  for (int k = 0; k < contact.count; ++k) solve_normal(true, c, c.point[k], sweep, moved.a, moved.b, v.a, v.b);
}

void solve_biased(Contact& contact, const Sweep<Real>& sweep, const Array<Motion<Real>>& movement,
                  Bodies<Real>& bodies) {
  Velocities v = load_velocities(contact, bodies.motion);
  solve_normals(contact, sweep, movement, v);
  store_velocities(v, contact, bodies);
}

void relax(Contact& contact, const Sweep<Real>& sweep, const Array<Motion<Real>>& movement, Bodies<Real>& bodies) {
  Velocities v = load_velocities(contact, bodies.motion);
  solve_frictions(contact, v);
  solve_normals(contact, sweep, movement, v);
  store_velocities(v, contact, bodies);
}

void bounce(const Contact& contact, Bodies<Real>& bodies) {
  const ContactConstraint<Real>& c = contact.constraint;
  Velocities v = load_velocities(contact, bodies.motion);
  for (int k = 0; k < contact.count; ++k)
    if (has_bounce(c.point[k])) solve_bounce(true, c, c.point[k], v.a, v.b);
  store_velocities(v, contact, bodies);
}

void solve_in_order(const SolverSettings& settings, std::vector<Contact>& contacts, Bodies<Real>& bodies,
                    Array<Motion<Real>>& moving) {
  const Substep<Real> substep = substep_of<Real>(settings);
  const auto moves = [&](int i) { return bodies.inverse_mass[i].w > 0; };
  Array<Motion<Real>>& movement = moving;
  movement.assign(bodies.motion.size(), {});
  Array<Motion<Real>> before = bodies.motion;
  for (int part = 0; part < settings.substeps; ++part) {
    for (int i = 0; i < bodies.count; ++i)
      if (moves(i)) begin_substep(substep.gravity_dv, before[i], bodies.motion[i]);
    if (part == 0)
      for (const Contact& contact : contacts) warm_start(contact, bodies);
    for (int sweep = 0; sweep < settings.biased_sweeps; ++sweep)
      for (Contact& contact : contacts) solve_biased(contact, substep.biased, movement, bodies);
    for (int i = 0; i < bodies.count; ++i)
      if (moves(i)) move_on(substep.h, bodies.motion[i], movement[i]);
    for (int sweep = 0; sweep < settings.relax_sweeps; ++sweep)
      for (Contact& contact : contacts) relax(contact, substep.relax, movement, bodies);
  }
  for (const Contact& contact : contacts) bounce(contact, bodies);
  const Real per_step = static_cast<Real>(1 / settings.time_step);
  for (int i = 0; i < bodies.count; ++i) moving[i] = mean_motion(per_step, movement[i]);
}

void store_impulses(const Contact& contact, Impulses<Real>& impulses) {
  for (int k = 0; k < contact.count; ++k) {
    const ConstraintPoint<Real>& p = contact.constraint.point[k];
    impulses.normal[k] = p.normal.impulse;
    impulses.tangent[k] = p.tangent.impulse;
    impulses.bitangent[k] = p.bitangent.impulse;
  }
}

void solve_reordered(const SolverSettings& settings, std::span<const Manifold<Real>> manifolds,
                     std::span<const std::int32_t> body, std::span<const std::int32_t> order, Bodies<Real>& bodies,
                     std::span<Impulses<Real>> impulses, Array<Motion<Real>>& moving) {
  std::vector<Contact> contacts;
  contacts.reserve(manifolds.size());
  for (const std::int32_t k : order)
    contacts.push_back(make_contact(manifolds[k], static_cast<Real>(settings.bounce_from), body, bodies, impulses[k]));
  solve_in_order(settings, contacts, bodies, moving);
  for (std::size_t i = 0; i < contacts.size(); ++i) store_impulses(contacts[i], impulses[order[i]]);
}

}  // namespace

void contact_solver_original(const SolverSettings& settings, std::span<const Manifold<Real>> manifolds,
                             std::span<const std::int32_t> body, Bodies<Real>& bodies,
                             std::span<Impulses<Real>> impulses, Array<Motion<Real>>& moving) {
  std::vector<Contact> contacts;
  contacts.reserve(manifolds.size());
  for (std::size_t k = 0; k < manifolds.size(); ++k)
    contacts.push_back(make_contact(manifolds[k], static_cast<Real>(settings.bounce_from), body, bodies, impulses[k]));
  solve_in_order(settings, contacts, bodies, moving);
  for (std::size_t k = 0; k < manifolds.size(); ++k) store_impulses(contacts[k], impulses[k]);
}

void contact_solver_batches(const SolverSettings& settings, std::span<const Manifold<Real>> manifolds,
                            std::span<const std::int32_t> body, const Batches& batches, Bodies<Real>& bodies,
                            std::span<Impulses<Real>> impulses, Array<Motion<Real>>& moving) {
  solve_reordered(settings, manifolds, body, batches.order, bodies, impulses, moving);
}

void contact_solver_blocks(const SolverSettings& settings, std::span<const Manifold<Real>> manifolds,
                           std::span<const std::int32_t> body, const ContactBlocks& blocks, Bodies<Real>& bodies,
                           std::span<Impulses<Real>> impulses, Array<Motion<Real>>& moving) {
  solve_reordered(settings, manifolds, body, blocks.order, bodies, impulses, moving);
}

}  // namespace lockstep::rigid::serial
