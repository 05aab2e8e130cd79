// All lanes, in place of a mask: one text then serves the vectors inside an array, without masks, and those at its ends
// with them. With masks, even of all lanes, loops over arrays that come from memory are slower: `advance` of
// common/linear/update.h took .095 ms with them and takes .037 (notes/production_face.md; notes/linear.md, "Masks").
#pragma once

#include <cstddef>

#include "common/simd.h"

namespace lockstep::openmp {

struct Whole {};

LOCKSTEP_INLINE floatv load(const float* p, Whole) { return lockstep::load(p); }
LOCKSTEP_INLINE void store(float* p, floatv v, Whole) { lockstep::store(p, v); }

// What is loaded beyond the mask is not selected.
LOCKSTEP_INLINE Whole operator&(Whole, maskv) { return {}; }

// Calls of(mask) with the mask of the first `count` lanes; with Whole in its place where those are all.
template <class Of>
LOCKSTEP_INLINE void with_first_lanes(std::ptrdiff_t count, const Of& of) {
  if (count >= lanes)
    of(Whole());
  else
    of(first_lanes(static_cast<int>(count)));
}

}  // namespace lockstep::openmp
