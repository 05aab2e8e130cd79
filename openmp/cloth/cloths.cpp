// One step of each of several cloths.
//
// A thread takes a cloth whole, and the next one when it is done, so that large and small ones may stand in any order.
// In it, the parallel regions of a step have one thread, and its barriers cost nothing. Fewer cloths than threads leave
// threads idle.
//
// The contract stands in common/cloth/cloths.h.
#include "common/cloth/cloths.h"

#include "common/cloth/step.h"
#include "common/real.h"
#include "openmp/failure.h"

namespace lockstep::cloth::openmp {

void step_cloths(std::span<Cloth<Real>> cloths) {
  const int count = static_cast<int>(cloths.size());
  lockstep::openmp::Failure failure;  // a step asks for memory
  // Cloths share nothing that is written, and each is one thread's.
#pragma omp parallel for schedule(dynamic, 1)
  for (int k = 0; k < count; ++k)
    failure.guard([&] {
      if (cloths[k].sheet.rows > 0)
        step_chains(cloths[k]);
      else
        step_batches(cloths[k]);
    });
  failure.rethrow();
}

}  // namespace lockstep::cloth::openmp
