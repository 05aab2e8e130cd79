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
// The guess that a solve begins with is multiplied together with the velocities. What is left of the right-hand side is
// solved for from 0, to a tolerance of the whole.
//
// Held vertices are filtered: their rows and columns are left out, and their velocities act by the right-hand side.
//
// The contract stands in common/production_cloth/damping_solve.h.
#include "common/production_cloth/damping_solve.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/linear/conjugate_gradients.h"
#include "common/linear/dot.h"
#include "common/linear/update.h"
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

// A vector that D is multiplied by, and what comes of it.
struct Product {
  std::span<const Real> v;
  std::span<Real> pulls;  // -D v
  std::span<Real> rates;  // [place]: of folding triangles, about their sides
};
template <std::size_t count>
using Products = std::array<Product, count>;

template <std::size_t count>
void add_links(const Elements<Real>& elements, const State<Real>& state, const Products<count>& products) {
  for (int k = 0; k < elements.links; ++k) {
    const int from = elements.from[k], to = elements.to[k];
    for (const Product& product : products) {
      const Vector3<Real> d = record(product.v, to) - record(product.v, from);
      Vector3<Real> part = {0, 0, 0};
      if (elements.has_bending) part = (elements.bend_damping * elements.bending[k]) * d;
      if (elements.has_springs && k < elements.edges)
        part = part + damping_of_spring({state.along[3 * k], state.along[3 * k + 1], state.along[3 * k + 2]}, d);
      add(product.pulls, from, part), add(product.pulls, to, -part);
    }
  }
}

template <std::size_t count>
void add_membranes(const Elements<Real>& elements, const State<Real>& state, const Products<count>& products) {
  for (int t = 0; t < elements.membranes; ++t) {
    const auto corner = [&](int c) { return elements.membrane_corner.at(t, c); };
    const auto field = [&](const Blocked<Real>& array, int k) { return array.at(t, k); };
    const auto column = [&](int k) {
      return Vector3<Real>{field(state.deformation, k), field(state.deformation, k + 1),
                           field(state.deformation, k + 2)};
    };
    const Membrane<Real> membrane = membrane_of<Real>(elements, field);
    const Columns<Real> f = {column(0), column(3)};
    for (const Product& product : products) {
      const auto v = [&](int c) { return record(product.v, corner(c)); };
      const Parts<Real, 3> parts = damping_of_membrane<Real>(elements, membrane, f, v(0), v(1), v(2));
      for (int c = 0; c < 3; ++c) add(product.pulls, corner(c), parts.of[c]);
    }
  }
}

template <std::size_t count>
void set_rates(const Elements<Real>& elements, const State<Real>& state, const Products<count>& products) {
  for (int t = 0; t < elements.facets; ++t) {
    const Facet<Real>& facet = state.facets[t];
    for (const Product& product : products) {
      const auto v = [&](int c) { return record(product.v, elements.facet_corner[elements.place_of(t, c)]); };
      const Sides<Real> rate = rates_of_facet(facet.normal, facet.at, v(0), v(1), v(2));
      for (int c = 0; c < 3; ++c) product.rates[elements.place_of(t, c)] = rate.of[c];
    }
  }
}

template <std::size_t count>
void add_hinges(const Elements<Real>& elements, const State<Real>& state, const Products<count>& products) {
  for (int t = 0; t < elements.facets; ++t) {
    const Facet<Real>& facet = state.facets[t];
    for (const Product& product : products) {
      const auto torque = [&](int c) {
        const int side = elements.place_of(t, c);
        return state.resistance[side] * (product.rates[side] + product.rates[elements.beside[side]]);
      };
      const Sides<Real> push = pushes_of_facet(facet.at, {torque(0), torque(1), torque(2)});
      for (int c = 0; c < 3; ++c)
        add(product.pulls, elements.facet_corner[elements.place_of(t, c)], push.of[c] * facet.normal);
    }
  }
}

// Vectors are multiplied together: an element is loaded once for all of them.
template <std::size_t count>
void damp(const Elements<Real>& elements, const State<Real>& state, const Products<count>& products) {
  for (const Product& product : products) std::ranges::fill(product.pulls, Real(0));
  add_links(elements, state, products);
  add_membranes(elements, state, products);
  set_rates(elements, state, products);
  add_hinges(elements, state, products);
}

}  // namespace

DampingMemory<Real> make_damping_memory(const Elements<Real>& elements) {
  const Array<Real> none(numbers_of_records(elements.vertices)), sides(elements.last_place());
  return {.b = none, .x = none, .guess = none, .rates = {sides, sides}, .pulls = {none, none}};
}

linear::Solution damping_solve(const Elements<Real>& elements, const State<Real>& state, const Array<Real>& mass,
                               const Array<Real>& inverse_mass, Real half_step, const Vectors<Real>& force,
                               const linear::Stop& stop, Vectors<Real>& velocity, Changes<Real>& changes,
                               DampingMemory<Real>& memory) {
  using linear::serial::dot;
  const Vector3<Real> none = {0, 0, 0};
  const std::span<Real> b = memory.b, x = memory.x, guess = memory.guess;
  const auto product = [&](int k, std::span<const Real> v) { return Product{v, memory.pulls[k], memory.rates[k]}; };
  const auto row = [&](int i, const Vector3<Real>& p, const Vector3<Real>& pulls) {
    return select(inverse_mass[i] > 0, mass[i] * p - half_step * pulls, none);
  };
  const auto multiply = [&](std::span<const Real> p, std::span<Real> q) {
    damp<1>(elements, state, {product(0, p)});
    for (int i = 0; i < elements.vertices; ++i) set(q, i, row(i, record(p, i), record(memory.pulls[0], i)));
    return dot(p, q);
  };
  const auto precondition = [&](std::span<const Real> r, std::span<Real> z) {
    for (int i = 0; i < elements.vertices; ++i) set(z, i, inverse_mass[i] * record(r, i));
    return dot(r, z);
  };

  for (int i = 0; i < elements.vertices; ++i) set(x, i, load(velocity, i));
  const bool is_guessed = has_guess(changes);
  if (is_guessed) {
    for (std::size_t k = 0; k < guess.size(); ++k)
      guess[k] = changes.weight[0] * changes.last[k] + changes.weight[1] * changes.before[k];
    damp<2>(elements, state, {product(0, x), product(1, guess)});
  } else {
    damp<1>(elements, state, {product(0, x)});
  }
  for (int i = 0; i < elements.vertices; ++i) {
    const Vector3<Real> rest = half_step * (load(force, i) + record(memory.pulls[0], i));
    set(b, i, select(inverse_mass[i] > 0, rest, none));
  }

  // As far along the guess as along a direction; the rest is solved for.
  Real along = 0;
  double left = 1;  // |rest| / |b|
  if (is_guessed) {
    const std::span<Real> q = memory.pulls[1];  // A times the guess
    for (int i = 0; i < elements.vertices; ++i) set(q, i, row(i, record(guess, i), record(q, i)));
    const double norm_of_b = std::sqrt(dot(b, b)), gq = dot(guess, q);
    along = gq > 0 ? static_cast<Real>(dot(guess, b) / gq) : 0;
    const double norm_of_rest = std::sqrt(linear::serial::descend(along, q, b));
    left = norm_of_b > 0 ? norm_of_rest / norm_of_b : 0;
  }

  const linear::System<Real> system = {multiply, precondition, nullptr, nullptr};
  linear::Solution solution =
      linear::serial::conjugate_gradients(system, b, x, {stop.tolerance / left, stop.iterations});
  solution.recursive_residual *= left;

  if (is_guessed) linear::serial::axpy(along, guess, x);
  for (int i = 0; i < elements.vertices; ++i) {
    const Vector3<Real> v = load(velocity, i);
    store(velocity, i, select(inverse_mass[i] > 0, v + record(x, i), v));
  }
  const std::span<const Real> y = changes.last, z = changes.before;
  const double xx = dot(x, x), xy = dot(x, y), xz = dot(x, z), yy = dot(y, y), yz = dot(y, z), zz = dot(z, z);
  std::ranges::copy(x, changes.before.begin());
  keep_change(changes, xx, xy, xz, yy, yz, zz);
  return solution;
}

}  // namespace lockstep::production_cloth::serial
