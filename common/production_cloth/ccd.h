// Contract: continuous collision detection. Vertices move in a straight line, each at constant speed, from `start` to
// `end`; says which of the given pairs of elements meet on the way, when first, where, and along which normal.
//
// In:  topology; pairs, of any margin: a pair that does not meet costs little; start, end, m, finite.
// Out: impacts, as contacts.h says: those of pairs.point_triangle first, then those of pairs.edge_edge, each in the
//      order of the pairs; resized to how many there are. normal[4 k + 3]: the time, as a share of the step.
//
// No pair that meets is missed; what that rests on stands in ccd_filters.h and ccd_impact.h. A pair that comes nearer
// than 2^-26 of its extent counts as meeting. Extent: the greatest component of its vertices as seen from the first, at
// start and end.
//
// The normal is the triangle's, or that of the plane of both edges, at the impact. Where elements are degenerate, edges
// parallel, or all moves in the common plane, it is the direction in which nearest points stand a little earlier; where
// those cannot be told apart either, it is against the relative velocity.
//
// Source: Provot, Collision and self-collision handling in cloth model dedicated to design garments, 1997; Bridson,
//         Fedkiw and Anderson 2002, section 6; Bernstein's coefficients as a test: Tang, Tong, Wang and Manocha, Fast
//         and exact continuous collision detection with Bernstein sign classification, SIGGRAPH Asia 2014; pairs in
//         doubt: Mirtich, Impulse-based dynamic simulation of rigid body systems, 1996 (conservative advancement).
#pragma once

#include <cstdint>
#include <vector>

#include "common/production_cloth/contacts.h"
#include "common/production_cloth/elements.h"
#include "common/production_cloth/topology.h"

namespace lockstep::production_cloth {

template <class Real>
using Ccd = void(const Topology& topology, const ElementPairs& pairs, const Vectors<Real>& start,
                 const Vectors<Real>& end, Contacts<Real>& impacts);

namespace serial {
Ccd<float> ccd;
Ccd<double> ccd;
}  // namespace serial

namespace openmp {

// Room that is kept between calls, so that they need not allocate. What it holds means nothing to the caller.
struct CcdMemory {
  struct Found {
    std::int32_t corner[4];
    float weight[4], normal[4];
  };
  struct Part {  // the impacts of a chunk of pairs: [begin, end) of found[thread]
    int thread, begin, end;
  };
  Array<float> vertex;                    // [8 v]: start, end of vertex v
  std::vector<std::vector<Found>> found;  // [thread]
  std::vector<Part> part;                 // [chunk]
  std::vector<std::size_t> before;        // [chunk]: impacts of the chunks before
};

void ccd(const Topology& topology, const ElementPairs& pairs, const Vectors<float>& start, const Vectors<float>& end,
         CcdMemory& memory, Contacts<float>& impacts);

}  // namespace openmp
}  // namespace lockstep::production_cloth
