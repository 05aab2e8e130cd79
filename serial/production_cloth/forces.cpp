// The elastic forces of a cloth, element by element: each adds what it pulls with to its corners.
//
// Links come first, then membranes, then hinges. What damping needs of the shape is left in the state on the way.
//
// The contract stands in common/production_cloth/forces.h.
#include "common/production_cloth/forces.h"

#include <algorithm>

#include "common/real.h"

namespace lockstep::production_cloth::serial {
namespace {

void add(Vectors<Real>& force, int vertex, const Vector3<Real>& part) {
  store(force, vertex, load(force, vertex) + part);
}

void add_links(const Elements<Real>& elements, const Vectors<Real>& position, State<Real>& state,
               Vectors<Real>& force) {
  for (int k = 0; k < elements.links; ++k) {
    const int from = elements.from[k], to = elements.to[k];
    const Vector3<Real> d = load(position, to) - load(position, from);
    Vector3<Real> part = {0, 0, 0};
    if (elements.has_bending) part = elements.bending[k] * d;
    if (elements.has_springs && k < elements.edges) {
      const Pull<Real> pull =
          pull_of_spring(elements.rest_length[k], elements.spring[k], elements.root_of_damping[k], d);
      state.along[3 * k] = pull.along.x, state.along[3 * k + 1] = pull.along.y, state.along[3 * k + 2] = pull.along.z;
      part = part + pull.force;
    }
    add(force, from, part), add(force, to, -part);
  }
}

void set_facets(const Elements<Real>& elements, const Vectors<Real>& position, State<Real>& state) {
  for (int t = 0; t < elements.facets; ++t) {
    const auto x = [&](int c) { return load(position, elements.facet_corner[elements.place_of(t, c)]); };
    state.facets[t] = facet_of(x(0), x(1), x(2));
  }
}

void add_membranes(const Elements<Real>& elements, const Vectors<Real>& position, State<Real>& state,
                   Vectors<Real>& force) {
  for (int t = 0; t < elements.membranes; ++t) {
    const auto corner = [&](int c) { return elements.membrane_corner.at(t, c); };
    const Vector3<Real> x0 = load(position, corner(0)), x1 = load(position, corner(1)), x2 = load(position, corner(2));
    const Membrane<Real> m =
        membrane_of<Real>(elements, [&](const Blocked<Real>& array, int f) { return array.at(t, f); });
    const Columns<Real> f = deformation_of(m, x1 - x0, x2 - x0);
    const Real fields[] = {f.x.x, f.x.y, f.x.z, f.y.x, f.y.y, f.y.z};
    for (int k = 0; k < 6; ++k) state.deformation.at(t, k) = fields[k];
    const Parts<Real, 3> parts = parts_of_membrane(m, stress_of_membrane(elements, f));
    for (int c = 0; c < 3; ++c) add(force, corner(c), parts.of[c]);
  }
}

void add_hinges(const Elements<Real>& elements, const Vectors<Real>& position, State<Real>& state,
                Vectors<Real>& force) {
  for (int h = 0; h < elements.hinges; ++h) {
    const auto x = [&](int c) { return load(position, elements.hinge_corner.at(h, c)); };
    const Fold<Real> fold = fold_of(x(0), x(1), x(2), x(3));
    const Parts<Real, 4> parts = parts_of_hinge(elements.hinge_stiffness, elements.hinge.at(h, 0), fold);
    for (int c = 0; c < 4; ++c) add(force, elements.hinge_corner.at(h, c), parts.of[c]);
    const Real resistance = resistance_of_hinge(elements.hinge.at(h, 1), fold);
    for (int k = 0; k < 2; ++k) state.resistance[elements.hinge_side.at(h, k)] = resistance;
  }
}

}  // namespace

State<Real> make_state(const Elements<Real>& elements) {
  State<Real> state = make_state_of_blocks(elements);
  if (elements.has_springs) state.along.resize(3 * static_cast<std::size_t>(elements.edges));
  state.facets.resize(elements.facets);
  return state;
}

void forces(const Elements<Real>& elements, const Vectors<Real>& position, State<Real>& state, Vectors<Real>& force) {
  for (Array<Real>* component : {&force.x, &force.y, &force.z})
    std::fill_n(component->begin(), elements.vertices, Real(0));
  set_facets(elements, position, state);
  add_links(elements, position, state, force);
  add_membranes(elements, position, state, force);
  add_hinges(elements, position, state, force);
}

void forces_colours(const Elements<Real>& elements, const Colours& colours, const Vectors<Real>& position,
                    Vectors<Real>& force) {
  for (Array<Real>* component : {&force.x, &force.y, &force.z})
    std::fill_n(component->begin(), elements.vertices, Real(0));
  for (const int k : colours.links.order) {
    const int from = elements.from[k], to = elements.to[k];
    const Vector3<Real> d = load(position, to) - load(position, from);
    Vector3<Real> part = {0, 0, 0};
    if (elements.has_bending) part = elements.bending[k] * d;
    if (elements.has_springs && k < elements.edges)
      part = part + pull_of_spring(elements.rest_length[k], elements.spring[k], elements.root_of_damping[k], d).force;
    add(force, from, part), add(force, to, -part);
  }
  for (const int t : colours.membranes.order) {
    const auto x = [&](int c) { return load(position, elements.membrane_corner.at(t, c)); };
    const Membrane<Real> m =
        membrane_of<Real>(elements, [&](const Blocked<Real>& array, int f) { return array.at(t, f); });
    const Vector3<Real> x0 = x(0), x1 = x(1), x2 = x(2);
    const Parts<Real, 3> parts =
        parts_of_membrane(m, stress_of_membrane(elements, deformation_of(m, x1 - x0, x2 - x0)));
    for (int c = 0; c < 3; ++c) add(force, elements.membrane_corner.at(t, c), parts.of[c]);
  }
  for (const int h : colours.hinges.order) {
    const auto x = [&](int c) { return load(position, elements.hinge_corner.at(h, c)); };
    const Parts<Real, 4> parts =
        parts_of_hinge(elements.hinge_stiffness, elements.hinge.at(h, 0), fold_of(x(0), x(1), x(2), x(3)));
    for (int c = 0; c < 4; ++c) add(force, elements.hinge_corner.at(h, c), parts.of[c]);
  }
}

}  // namespace lockstep::production_cloth::serial
