// Pairs of colliders, as all broad phases find them: every pair of bounded colliders whose boxes overlap or touch and
// whose groups differ, once, ordered by a and then by b. Colliders without bounds (planes) are left to plane_pairs.
#pragma once

#include "common/spatial/pairs.h"

namespace lockstep::rigid {

using spatial::make_pair;
using spatial::Pair;
using spatial::Pairs;

}  // namespace lockstep::rigid
