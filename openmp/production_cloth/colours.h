// Loops over elements in colours.
#pragma once

#include <algorithm>

#include "common/batches.h"
#include "common/simd.h"

namespace lockstep::production_cloth::openmp {

// Calls add(elements of sixteen lanes, which lanes are meant) for all elements, colour after colour; lanes beyond a
// colour's last repeat it, whose vertices no other thread writes. A team calls it.
template <class Add>
void for_each_colour(const Batches& colours, const Add& add) {
  for (int colour = 0; colour < colours.count(); ++colour) {
    const int begin = colours.begin[colour], end = colours.begin[colour + 1];
    // Elements of a colour have no vertex in common. The barrier ends the colour.
#pragma omp for schedule(static)
    for (int k = begin; k < end; k += lanes) {
      std::int32_t element[lanes];
      for (int l = 0; l < lanes; ++l) element[l] = colours.order[std::min(k + l, end - 1)];
      add(element, first_lanes(end - k));
    }
  }
}

}  // namespace lockstep::production_cloth::openmp
