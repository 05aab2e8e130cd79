// Elements of a cloth in colours: of one kind and colour, no two have a vertex in common, so that all may add to their
// vertices at once. First fit, in the order of the elements (common/batches.h says what that means for two vertices).
//
// Elements share sixty-four colours at most; one that finds no room in them is a colour of its own.
#pragma once

#include "common/batches.h"
#include "common/production_cloth/elastic.h"

namespace lockstep::production_cloth {

struct Colours {
  Batches links, triangles;  // of membranes and facets
};

template <class Real>
Colours make_colours(const Elements<Real>& elements);

extern template Colours make_colours(const Elements<float>& elements);
extern template Colours make_colours(const Elements<double>& elements);

}  // namespace lockstep::production_cloth
