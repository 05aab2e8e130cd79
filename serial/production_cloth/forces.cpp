// The elastic forces of a cloth, element by element: each adds what it pulls with to its corners.
//
// Links come first, then membranes, then hinges: each finds what it resists with, and a triangle then pushes its
// corners with that of its three sides. What damping needs of the shape is left in the state on the way.
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

void add_link(const Elements<Real>& elements, const Vectors<Real>& position, int k, State<Real>& state,
              Vectors<Real>& force) {
  const int from = elements.from[k], to = elements.to[k];
  const Vector3<Real> d = load(position, to) - load(position, from);
  Vector3<Real> part = {0, 0, 0};
  if (elements.has_bending) part = elements.bending[k] * d;
  if (elements.has_springs && k < elements.edges) {
    const Pull<Real> pull = pull_of_spring(elements.rest_length[k], elements.spring[k], elements.root_of_damping[k], d);
    state.along[3 * k] = pull.along.x, state.along[3 * k + 1] = pull.along.y, state.along[3 * k + 2] = pull.along.z;
    part = part + pull.force;
  }
  add(force, from, part), add(force, to, -part);
}

void add_membrane(const Elements<Real>& elements, const Vectors<Real>& position, int t, State<Real>& state,
                  Vectors<Real>& force) {
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

void set_facets(const Elements<Real>& elements, const Vectors<Real>& position, State<Real>& state) {
  for (int t = 0; t < elements.facets; ++t) {
    const auto x = [&](int c) { return load(position, elements.facet_corner[elements.place_of(t, c)]); };
    state.facets[t] = facet_of(x(0), x(1), x(2));
  }
}

void set_hinges(const Elements<Real>& elements, const Vectors<Real>& position, State<Real>& state) {
  for (int h = 0; h < elements.hinges; ++h) {
    const int side[] = {elements.hinge_side.at(h, 0), elements.hinge_side.at(h, 1)};
    const Facet<Real>&first = state.facets[elements.triangle_of(side[0])],
          &second = state.facets[elements.triangle_of(side[1])];
    const Vector3<Real> e =
        load(position, elements.hinge_corner.at(h, 3)) - load(position, elements.hinge_corner.at(h, 2));
    const Resistance<Real> hinge =
        resistance_of_hinge(elements.hinge_stiffness, elements.hinge.at(h, 0), elements.hinge.at(h, 1), first.normal,
                            first.size, second.normal, second.size, e);
    for (const int place : side) state.torque[place] = hinge.torque, state.resistance[place] = hinge.of_rate;
  }
}

void add_facet(const Elements<Real>& elements, const State<Real>& state, int t, Vectors<Real>& force) {
  const auto torque = [&](int c) { return state.torque[elements.place_of(t, c)]; };
  const Facet<Real>& facet = state.facets[t];
  const Sides<Real> push = pushes_of_facet(facet.at, {torque(0), torque(1), torque(2)});
  for (int c = 0; c < 3; ++c) add(force, elements.facet_corner[elements.place_of(t, c)], push.of[c] * facet.normal);
}

}  // namespace

State<Real> make_state(const Elements<Real>& elements) {
  State<Real> state = make_state_of_blocks(elements);
  if (elements.has_springs) state.along.resize(3 * static_cast<std::size_t>(elements.edges));
  state.facets.resize(elements.facets), state.torque.resize(state.resistance.size());
  return state;
}

void forces(const Elements<Real>& elements, const Vectors<Real>& position, State<Real>& state, Vectors<Real>& force) {
  for (Array<Real>* component : {&force.x, &force.y, &force.z})
    std::fill_n(component->begin(), elements.vertices, Real(0));
  set_facets(elements, position, state), set_hinges(elements, position, state);
  for (int k = 0; k < elements.links; ++k) add_link(elements, position, k, state, force);
  for (int t = 0; t < elements.membranes; ++t) add_membrane(elements, position, t, state, force);
  for (int t = 0; t < elements.facets; ++t) add_facet(elements, state, t, force);
}

void forces_colours(const Elements<Real>& elements, const Colours& colours, const Vectors<Real>& position,
                    State<Real>& state, Vectors<Real>& force) {
  for (Array<Real>* component : {&force.x, &force.y, &force.z})
    std::fill_n(component->begin(), elements.vertices, Real(0));
  set_facets(elements, position, state), set_hinges(elements, position, state);
  for (const int k : colours.links.order) add_link(elements, position, k, state, force);
  if (elements.membranes > 0)
    for (const int t : colours.triangles.order) add_membrane(elements, position, t, state, force);
  if (elements.facets > 0)
    for (const int t : colours.triangles.order) add_facet(elements, state, t, force);
}

}  // namespace lockstep::production_cloth::serial
