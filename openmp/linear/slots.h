// One slot of a slice of rows (common/linear/sliced.h), as lanes see it.
#pragma once

#include "common/linear/sliced.h"
#include "common/simd.h"

namespace lockstep::linear::openmp {

struct Entries {
  maskv active;
  floatv value, at;  // a_ij and x_j; 0 in inactive lanes, but a uniform a_ij is in all lanes
};

LOCKSTEP_INLINE Entries entries(const SlicedRows& a, const SlicedRows::Slot& slot, const float* x) {
  const maskv active = lanes_of(slot.mask);
  return {active, slot.uniform ? floatv(a.value[slot.values]) : load(&a.value[slot.values]),
          slot.gathers ? gather(x, load(&a.column[slot.place]), active) : load(x + slot.place, active)};
}

}  // namespace lockstep::linear::openmp
