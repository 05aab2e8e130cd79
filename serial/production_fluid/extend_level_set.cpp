// Carries the level set on into obstacles, from the cells at their surface inwards.
//
// The contract stands in common/production_fluid/extend_level_set.h.
#include "common/production_fluid/extend_level_set.h"

#include "common/real.h"

namespace lockstep::production_fluid::serial {

void extend_level_set(const Extension<Real>& extension, Field<Real>& phi) {
  const auto& [first, cell, neighbour, share] = extension;
  for (int k = 0; k < first.back(); ++k) {
    const Real around[] = {phi.value[neighbour[0][k]], phi.value[neighbour[1][k]], phi.value[neighbour[2][k]]};
    phi.value[cell[k]] = mean_of_neighbours(around, {share[0][k], share[1][k], share[2][k]});
  }
}

}  // namespace lockstep::production_fluid::serial
