// The stiffness matrix of a strained body, K = -df/du: how the forces of its nodes fall as displacements grow.
//
//   K_ij = sum over the tetrahedra with nodes i and j of their K_ac (element_stiffness.h),   K_ii = -sum over j of K_ij
//
// in N/m. K is symmetric to the bit. Where `strained` has been made definite, x^T K x >= 0 but for rounding. Rows of
// held nodes are empty; columns are not.
//
// In:  body; strained, what update_state makes of it; pattern, made from the body.
// Out: k, all values; the caller has made it with the pattern's blocks (make_block_rows, linear::slice). openmp's
//      `shares` (make_shares) is scratch.
// Source: [ITJ07] "Production Face"; Teran, Sifakis, Irving and Fedkiw, Robust quasistatic finite elements and flesh
//         simulation, SCA 2005.
#pragma once

#include "common/linear/matrix.h"
#include "common/linear/sliced.h"
#include "common/production_face/body.h"
#include "common/production_face/element_stiffness.h"
#include "common/production_face/pattern.h"

namespace lockstep::production_face {

namespace serial {
void assemble(const Body<float>& body, const Strained<float>& strained, const Pattern& pattern,
              linear::BlockRows<float>& k);
void assemble(const Body<double>& body, const Strained<double>& strained, const Pattern& pattern,
              linear::BlockRows<double>& k);
}  // namespace serial

// Room for the shares: share s is the nine numbers from 9 s on. Lanes load sixteen, so there is room behind the last.
template <class Real>
Array<Real> make_shares(const Body<Real>& body) {
  return Array<Real>(9 * pairs * static_cast<std::size_t>(body.padded_tetrahedra()) + lanes);
}

namespace openmp {
void assemble(const Body<float>& body, const Strained<float>& strained, const Pattern& pattern, Array<float>& shares,
              linear::SlicedBlockRows& k);
}  // namespace openmp

}  // namespace lockstep::production_face
