// Contract: the product of a body's stiffness matrix (assemble.h) and a vector of its nodes, y = K x.
//
//   matrix_free  tetrahedron by tetrahedron (element_product.h), without K: a node sums the parts of its tetrahedra in
//                their order, from 0. The tetrahedra that fill up the last block give none.
//   edges        by nodes and edges (edges.h), as PARSEC's facesim does: serial alone. All nodes' own blocks first,
//                then the edges in their order, each to both of its nodes.
//   block_rows   linear's product of the assembled matrix (common/linear/multiply.h).
//
// At held nodes, whose rows of K are empty, y is 0.
//
// In:  body; strained, what update_state makes of it; edges, made from its matrix; waves, made from the
//      body; x, 3 a node (parts.h).
// Out: y, 3 a node; x and y do not overlap. openmp's `parts` (make_parts) is scratch.
// Source: [ITJ07] "Production Face"; Teran, Sifakis, Irving and Fedkiw, Robust quasistatic finite elements and flesh
//         simulation, SCA 2005.
#pragma once

#include <span>

#include "common/production_face/edges.h"
#include "common/production_face/element_product.h"
#include "common/production_face/waves.h"

namespace lockstep::production_face {

namespace serial {
void multiply_matrix_free(const Body<float>& body, const Strained<float>& strained, std::span<const float> x,
                          std::span<float> y);
void multiply_matrix_free(const Body<double>& body, const Strained<double>& strained, std::span<const double> x,
                          std::span<double> y);
void multiply_edges(const Edges<float>& edges, std::span<const float> x, std::span<float> y);
void multiply_edges(const Edges<double>& edges, std::span<const double> x, std::span<double> y);
}  // namespace serial

namespace openmp {
void multiply_matrix_free(const Body<float>& body, const Strained<float>& strained, std::span<const float> x,
                          const Waves& waves, Array<float>& parts, std::span<float> y);
}  // namespace openmp

}  // namespace lockstep::production_face
