// One step of each of several cloths.
//
// The contract stands in common/cloth/cloths.h.
#include "common/cloth/cloths.h"

#include "common/cloth/step.h"
#include "common/real.h"

namespace lockstep::cloth::serial {

void step_cloths(std::span<Cloth<Real>> cloths) {
  for (Cloth<Real>& cloth : cloths)
    if (cloth.sheet.rows > 0)
      step_chains(cloth);
    else
      step_batches(cloth);
}

}  // namespace lockstep::cloth::serial
