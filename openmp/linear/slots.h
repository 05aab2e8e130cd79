// One slot of a slice of rows (common/linear/sliced.h), as lanes see it.
#pragma once

#include "common/linear/sliced.h"
#include "common/simd.h"

namespace lockstep::linear::openmp {

struct Entries {
  maskv active;
  floatv value, at;  // a_ij and x_j; in inactive lanes any number
};

// Whether other threads write x meanwhile.
enum class X { constant, written };

// Inactive lanes of an x that is constant may load as well, which is faster (notes/linear.md, "Masks").
LOCKSTEP_INLINE Entries entries(const SlicedRows& a, const SlicedRows::Slot& slot, const float* x, X kind) {
  const maskv active = lanes_of(slot.mask);
  const auto run = [&] {
    return slot.inside && kind == X::constant ? load(x + slot.place) : load(x + slot.place, active);
  };
  return {active, slot.uniform ? floatv(a.value[slot.values]) : load(&a.value[slot.values]),
          slot.gathers ? gather(x, load(&a.column[slot.place]), active) : run()};
}

}  // namespace lockstep::linear::openmp
