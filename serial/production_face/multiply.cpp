// The stiffness matrix times a vector of the nodes: without the matrix, and by its nodes and edges.
//
// Matrix-free: what displacements of its corners do to a tetrahedron's forces is computed from its strain, again for
// each product. Nothing is assembled; a tetrahedron costs about 290 operations in place of 45 that its share of the
// matrix does.
//
// By edges: the matrix is symmetric, so that half of it tells all. Each edge's block gives to both of its nodes, which
// saves half of what block rows read, but edges in parallel would write to the same nodes.
//
// The contract stands in common/production_face/multiply.h.
#include "common/production_face/multiply.h"

#include <algorithm>

#include "common/real.h"

namespace lockstep::production_face::serial {
namespace {

Moved<Real> moved_corners(const Body<Real>& body, std::span<const Real> x, int tetrahedron) {
  Vector3<Real> corner[4];
  for (int a = 0; a < 4; ++a) corner[a] = at_node(x, body.corner.at(tetrahedron, a));
  return {{corner[1] - corner[0], corner[2] - corner[0], corner[3] - corner[0]}};
}

Parts<Real> product_of(const Body<Real>& body, const Strained<Real>& strained, std::span<const Real> x,
                       int tetrahedron) {
  const auto field = [&](const Blocked<Real>& array, int k) { return array.at(tetrahedron, k); };
  const auto e = strained_element<Real>(body, strained, field);
  const Moved<Real> moved = moved_corners(body, x, tetrahedron);
  Parts<Real> part;
  set_flesh_product(e, moved, part);
  const int block = tetrahedron / lanes, lane = tetrahedron % lanes;
  for (int slot = body.first_fibre[block]; slot < body.first_fibre[block + 1]; ++slot) {
    const auto in_slot = [&](const Blocked<Real>& array, int k) { return array.at(slot * lanes + lane, k); };
    add_fibre_product(e, strained_fibre<Real>(body, strained, in_slot), moved, part);
  }
  set_first_corner(part);
  return part;
}

}  // namespace

void multiply_matrix_free(const Body<Real>& body, const Strained<Real>& strained, std::span<const Real> x,
                          std::span<Real> y) {
  std::ranges::fill(y, Real(0));
  for (int tetrahedron = 0; tetrahedron < body.tetrahedra; ++tetrahedron) {
    const Parts<Real> part = product_of(body, strained, x, tetrahedron);
    for (int a = 0; a < 4; ++a) add_to_node(y, body.corner.at(tetrahedron, a), part.of[a]);
  }
  clear_nodes(y, body.held);
}

void multiply_edges(const Edges<Real>& edges, std::span<const Real> x, std::span<Real> y) {
  for (int n = 0; n < edges.nodes; ++n) {
    const Real* const k = &edges.at_node[6 * static_cast<std::size_t>(n)];
    const Real* const at = &x[3 * static_cast<std::size_t>(n)];
    Real* const to = &y[3 * static_cast<std::size_t>(n)];
    to[0] = k[0] * at[0] + k[1] * at[1] + k[2] * at[2];
    to[1] = k[1] * at[0] + k[3] * at[1] + k[4] * at[2];
    to[2] = k[2] * at[0] + k[4] * at[1] + k[5] * at[2];
  }
  for (std::size_t e = 0; e < edges.first.size(); ++e) {
    const Real* const k = &edges.between[9 * e];
    const Vector3<Real> first = at_node(x, edges.first[e]), last = at_node(x, edges.last[e]);
    const Vector3<Real> row[3] = {{k[0], k[1], k[2]}, {k[3], k[4], k[5]}, {k[6], k[7], k[8]}};
    add_to_node(y, edges.first[e], {dot(row[0], last), dot(row[1], last), dot(row[2], last)});
    add_to_node(y, edges.last[e], first.x * row[0] + first.y * row[1] + first.z * row[2]);
  }
  clear_nodes(y, edges.held);
}

}  // namespace lockstep::production_face::serial
