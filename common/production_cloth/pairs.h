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

}  // namespace lockstep::production_cloth
