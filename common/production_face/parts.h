// What tetrahedra give to their nodes, and vectors of the nodes.
//
// A vector of the nodes holds components x, y and z of node n at 3 n, 3 n + 1 and 3 n + 2, as the products of
// common/linear do.
#pragma once

#include <cstdint>
#include <span>

#include "common/production_face/body.h"

namespace lockstep::production_face {

// A vector for each corner of a tetrahedron.
template <class T>
struct Parts {
  Vector3<T> of[4];
};

// Forces and their derivatives balance: corner 0 has minus the sum of the others'.
template <class T>
inline void set_first_corner(Parts<T>& parts) {
  parts.of[0] = -(parts.of[1] + parts.of[2] + parts.of[3]);
}

template <class Real>
Vector3<Real> at_node(std::span<const Real> x, int node) {
  const Real* const at = &x[3 * static_cast<std::size_t>(node)];
  return {at[0], at[1], at[2]};
}

template <class Real>
void add_to_node(std::span<Real> y, int node, const Vector3<Real>& part) {
  Real* const at = &y[3 * static_cast<std::size_t>(node)];
  at[0] += part.x, at[1] += part.y, at[2] += part.z;
}

// 0 at nodes.
template <class Real>
void clear_nodes(std::span<Real> y, const Array<std::int32_t>& nodes) {
  for (const int node : nodes)
    for (int c = 0; c < 3; ++c) y[3 * static_cast<std::size_t>(node) + c] = 0;
}

}  // namespace lockstep::production_face
