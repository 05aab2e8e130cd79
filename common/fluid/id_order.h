// The order in which files hold the particles.
#pragma once

#include <vector>

#include "common/fluid/particles.h"

namespace lockstep::fluid {

// place[id] is the index of the particle with that id. Walking it visits the particles in the order of the input,
// whatever cells they have been sorted into since. Ids must be 0 .. count - 1 in some order.
template <class Real>
std::vector<int> id_order(const Particles<Real>& particles) {
  std::vector<int> place(particles.count);
  for (int i = 0; i < particles.count; ++i) place[particles.id[i]] = i;
  return place;
}

}  // namespace lockstep::fluid
