// Contract: the pairs of a cloth's elements whose boxes overlap: a vertex and a triangle, or two edges, without a
// common vertex. Boxes are closed: those that touch overlap.
//
// In:  search; boxes, which refit made for it (common/production_cloth/bvh.h).
// Out: pairs (common/production_cloth/elements.h), resized; each pair once, in the order of (a, b).
// Errors: InputError, or std::bad_alloc, if the pairs do not fit the memory; pairs are then unspecified.
//
// Source: [ITJ07] "Production Cloth" on the broad phase.
#pragma once

#include "common/production_cloth/elements.h"
#include "common/production_cloth/search.h"

namespace lockstep::production_cloth {

template <class Real>
using FindPairs = void(const Search& search, const SearchBoxes<Real>& boxes, ElementPairs& pairs);

namespace serial {
FindPairs<float> find_pairs;
FindPairs<double> find_pairs;
}  // namespace serial

namespace openmp {
FindPairs<float> find_pairs;
}  // namespace openmp

// --- Formulas; of a number or of lanes

// Whether a vertex is a corner of a triangle, or two edges have a common end; of lanes, a mask.
template <class A, class B>
inline auto is_corner(const A& vertex, const std::array<B, 3>& corner) {
  return (corner[0] == vertex) | (corner[1] == vertex) | (corner[2] == vertex);
}
template <class A, class B>
inline auto share_end(const std::array<A, 2>& a, const std::array<B, 2>& b) {
  return (b[0] == a[0]) | (b[0] == a[1]) | (b[1] == a[0]) | (b[1] == a[1]);
}

}  // namespace lockstep::production_cloth
