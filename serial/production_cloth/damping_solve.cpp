// The damping of a cloth, implicit, by conjugate gradients: one product with D an iteration.
//
// Damping resists the change of each element's shape, along the directions that `forces` has left. A product goes
// through the elements and adds to their corners what they resist with. Hinges are damped triangle by triangle: first
// how fast each triangle turns about its sides, then what its three corners get from that. This takes less than hinge
// by hinge: a hinge has four corners, and a cloth has three hinges to two triangles.
//
// At the time steps that explicit elastic forces allow, mass is most of the system. It is also the only part of the
// diagonal that is known without going through the elements: so it is the preconditioner.
//
// Held vertices are filtered: their rows and columns are left out, and their velocities act by the right-hand side.
//
// The contract stands in common/production_cloth/damping_solve.h.
#include "common/production_cloth/damping_solve.h"

#include <algorithm>

#include "common/linear/conjugate_gradients.h"
#include "common/linear/dot.h"
#include "common/real.h"

namespace lockstep::production_cloth::serial {
namespace {

Vector3<Real> record(std::span<const Real> x, int vertex) {
  const Real* const at = &x[4 * static_cast<std::size_t>(vertex)];
  return {at[0], at[1], at[2]};
}
void set(std::span<Real> x, int vertex, const Vector3<Real>& value) {
  Real* const at = &x[4 * static_cast<std::size_t>(vertex)];
  at[0] = value.x, at[1] = value.y, at[2] = value.z, at[3] = 0;
}
void add(std::span<Real> x, int vertex, const Vector3<Real>& part) {
  Real* const at = &x[4 * static_cast<std::size_t>(vertex)];
  at[0] += part.x, at[1] += part.y, at[2] += part.z;
}

void add_links(const Elements<Real>& elements, const State<Real>& state, std::span<const Real> v,
               std::span<Real> pulls) {
  for (int k = 0; k < elements.links; ++k) {
    const int from = elements.from[k], to = elements.to[k];
    const Vector3<Real> d = record(v, to) - record(v, from);
    Vector3<Real> part = {0, 0, 0};
    if (elements.has_bending) part = (elements.bend_damping * elements.bending[k]) * d;
    if (elements.has_springs && k < elements.edges)
      part = part + damping_of_spring({state.along[3 * k], state.along[3 * k + 1], state.along[3 * k + 2]}, d);
    add(pulls, from, part), add(pulls, to, -part);
  }
}

void add_membranes(const Elements<Real>& elements, const State<Real>& state, std::span<const Real> v,
                   std::span<Real> pulls) {
  for (int t = 0; t < elements.membranes; ++t) {
    const auto corner = [&](int c) { return elements.membrane_corner.at(t, c); };
    const auto field = [&](const Blocked<Real>& array, int k) { return array.at(t, k); };
    const auto column = [&](int k) {
      return Vector3<Real>{field(state.deformation, k), field(state.deformation, k + 1),
                           field(state.deformation, k + 2)};
    };
    const Parts<Real, 3> parts =
        damping_of_membrane<Real>(elements, membrane_of<Real>(elements, field), {column(0), column(3)},
                                  record(v, corner(0)), record(v, corner(1)), record(v, corner(2)));
    for (int c = 0; c < 3; ++c) add(pulls, corner(c), parts.of[c]);
  }
}

void set_rates(const Elements<Real>& elements, const State<Real>& state, std::span<const Real> v,
               std::span<Real> rates) {
  for (int t = 0; t < elements.facets; ++t) {
    const auto corner = [&](int c) { return record(v, elements.facet_corner[elements.place_of(t, c)]); };
    const Sides<Real> rate =
        rates_of_facet(state.facets[t].normal, state.facets[t].at, corner(0), corner(1), corner(2));
    for (int c = 0; c < 3; ++c) rates[elements.place_of(t, c)] = rate.of[c];
  }
}

void add_hinges(const Elements<Real>& elements, const State<Real>& state, std::span<const Real> rates,
                std::span<Real> pulls) {
  for (int t = 0; t < elements.facets; ++t) {
    const auto torque = [&](int c) {
      const int side = elements.place_of(t, c);
      return state.resistance[side] * (rates[side] + rates[elements.beside[side]]);
    };
    const Facet<Real>& facet = state.facets[t];
    const Sides<Real> push = pushes_of_facet(facet.at, {torque(0), torque(1), torque(2)});
    for (int c = 0; c < 3; ++c) add(pulls, elements.facet_corner[elements.place_of(t, c)], push.of[c] * facet.normal);
  }
}

// memory.pulls = -D v.
void damp(const Elements<Real>& elements, const State<Real>& state, std::span<const Real> v,
          DampingMemory<Real>& memory) {
  const std::span<Real> pulls = memory.pulls;
  std::ranges::fill(pulls, Real(0));
  add_links(elements, state, v, pulls);
  add_membranes(elements, state, v, pulls);
  set_rates(elements, state, v, memory.rates);
  add_hinges(elements, state, memory.rates, pulls);
}

}  // namespace

DampingMemory<Real> make_damping_memory(const Elements<Real>& elements) {
  const std::size_t n = 4 * static_cast<std::size_t>(elements.vertices);
  return {Array<Real>(n), Array<Real>(n), Array<Real>(elements.last_place()), Array<Real>(n)};
}

linear::Solution damping_solve(const Elements<Real>& elements, const State<Real>& state, const Array<Real>& mass,
                               const Array<Real>& inverse_mass, Real half_step, const Vectors<Real>& force,
                               const linear::Stop& stop, Vectors<Real>& velocity, DampingMemory<Real>& memory) {
  const Vector3<Real> none = {0, 0, 0};
  for (int i = 0; i < elements.vertices; ++i) set(memory.x, i, load(velocity, i));
  damp(elements, state, memory.x, memory);
  for (int i = 0; i < elements.vertices; ++i) {
    const Vector3<Real> rest = half_step * (load(force, i) + record(memory.pulls, i));
    set(memory.b, i, select(inverse_mass[i] > 0, rest, none));
  }

  const auto multiply = [&](std::span<const Real> p, std::span<Real> q) {
    damp(elements, state, p, memory);
    for (int i = 0; i < elements.vertices; ++i) {
      const Vector3<Real> row = mass[i] * record(p, i) - half_step * record(memory.pulls, i);
      set(q, i, select(inverse_mass[i] > 0, row, none));
    }
    return linear::serial::dot(p, q);
  };
  const auto precondition = [&](std::span<const Real> r, std::span<Real> z) {
    for (int i = 0; i < elements.vertices; ++i) set(z, i, inverse_mass[i] * record(r, i));
    return linear::serial::dot(r, z);
  };
  const linear::System<Real> system = {multiply, precondition, nullptr, nullptr};
  const linear::Solution solution = linear::serial::conjugate_gradients(system, memory.b, memory.x, stop);

  for (int i = 0; i < elements.vertices; ++i) {
    const Vector3<Real> v = load(velocity, i);
    store(velocity, i, select(inverse_mass[i] > 0, v + record(memory.x, i), v));
  }
  return solution;
}

}  // namespace lockstep::production_cloth::serial
