// Contacts answered one after another, or all at once: the loops that repulsions and impulses share.
//
// The orders and Jacobi's damping stand in common/production_cloth/repulsions.h, a contact's formulas in respond.h.
#pragma once

#include "common/production_cloth/contact_batches.h"
#include "common/production_cloth/respond.h"

namespace lockstep::production_cloth::serial {

template <class Real>
Touching<Real> read_contact(const Contacts<Real>& contacts, std::size_t k, const Array<Real>& inverse_mass,
                            const Vectors<Real>& velocity) {
  Touching<Real> c;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::int32_t v = contacts.corner[4 * k + i];
    c.weight[i] = contacts.weight[4 * k + i], c.velocity[i] = load(velocity, v), c.inverse_mass[i] = inverse_mass[v];
  }
  const Real* const normal = &contacts.normal[4 * k];
  c.normal = {normal[0], normal[1], normal[2]}, c.distance = normal[3];
  return c;
}

template <class Real, class GainOf>
void respond_to(const Contacts<Real>& contacts, std::size_t k, const GainOf& gain_of, Real friction,
                const Array<Real>& inverse_mass, Vectors<Real>& velocity) {
  const Touching<Real> c = read_contact(contacts, k, inverse_mass, velocity);
  const Vector3<Real> impulse = respond(c, gain_of, friction).impulse;
  for (std::size_t i = 0; i < 4; ++i)
    store(velocity, contacts.corner[4 * k + i], c.velocity[i] + (c.weight[i] * c.inverse_mass[i]) * impulse);
}

template <class Real, class GainOf>
void respond_in_order(const Contacts<Real>& contacts, const GainOf& gain_of, Real friction,
                      const Array<Real>& inverse_mass, Vectors<Real>& velocity) {
  for (std::size_t k = 0; k < contacts.count; ++k) respond_to(contacts, k, gain_of, friction, inverse_mass, velocity);
}

template <class Real, class GainOf>
void respond_in_batches(const Contacts<Real>& contacts, const GainOf& gain_of, Real friction,
                        const Array<Real>& inverse_mass, Vectors<Real>& velocity) {
  const Batches batches = make_contact_batches(contacts, inverse_mass);
  for (const std::int32_t k : batches.order) respond_to(contacts, k, gain_of, friction, inverse_mass, velocity);
}

// How much impulses change velocities: a vertex adds up its own in the order of contacts.
template <class Real>
void add_up(const Contacts<Real>& contacts, const std::vector<Response<Real>>& response,
            const Array<Real>& inverse_mass, Vectors<Real>& change) {
  for (std::size_t v = 0; v < inverse_mass.size(); ++v) store(change, v, Vector3<Real>{0, 0, 0});
  for (std::size_t s = 0; s < 4 * contacts.count; ++s) {
    const std::int32_t v = contacts.corner[s];
    store(change, v, load(change, v) + contacts.weight[s] * response[s / 4].impulse);
  }
  for (std::size_t v = 0; v < inverse_mass.size(); ++v) store(change, v, inverse_mass[v] * load(change, v));
}

template <class Real, class GainOf>
void respond_at_once(const Contacts<Real>& contacts, const GainOf& gain_of, Real friction,
                     const Array<Real>& inverse_mass, Vectors<Real>& velocity) {
  std::vector<Response<Real>> response(contacts.count);
  Vectors<Real> change;
  change.resize(inverse_mass.size());
  for (std::size_t k = 0; k < contacts.count; ++k)
    response[k] = respond(read_contact(contacts, k, inverse_mass, velocity), gain_of, friction);
  add_up(contacts, response, inverse_mass, change);
  for (std::size_t k = 0; k < contacts.count; ++k) {
    const Touching<Real> c = read_contact(contacts, k, inverse_mass, change);
    const Real kept = share_kept(response[k].gain, dot(c.normal, weighted(c.weight, c.velocity)));
    response[k].impulse = kept * response[k].impulse;
  }
  add_up(contacts, response, inverse_mass, change);
  for (std::size_t v = 0; v < inverse_mass.size(); ++v) store(velocity, v, load(velocity, v) + load(change, v));
}

}  // namespace lockstep::production_cloth::serial
