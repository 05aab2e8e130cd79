// Sixteen pairs of hulls in lanes: which hulls they are, where they are, and their vertices.
#pragma once

#include "common/rigid/convexes.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {

// The hulls of sixteen colliders, and where in the library their vertices and faces begin.
struct HullLanes {
  Indices hull, first_vertex, first_face;
};
// One by one: a gather takes as many accesses, and lanes would only be taken apart again.
inline HullLanes load_hulls(const Placed<float>& placed, const Indices& colliders) {
  HullLanes result;
  for (int l = 0; l < lanes; ++l) {
    const int hull = placed.colliders.hull[colliders.index[l]];
    result.hull.index[l] = hull;
    result.first_vertex.index[l] = placed.hulls.first_vertex[hull];
    result.first_face.index[l] = placed.hulls.first_face[hull];
  }
  return result;
}

// Vertices of sixteen hulls, by their numbers within them.
inline Vector3<floatv> load_vertices(const Placed<float>& placed, const HullLanes& of, intv number) {
  return vector_of(load_quad(placed.hulls.vertex, indices_of(load(of.first_vertex.index) + number)));
}

LOCKSTEP_INLINE Cores<floatv> load_cores(const Placed<float>& placed, const PairLanes& pairs) {
  const auto& [colliders, hulls, pose] = placed;
  const Pose<floatv> a = load_pose(pose, pairs.a), b = load_pose(pose, pairs.b);
  return make_cores(vector_of(load_quad(colliders.size, pairs.a)), vector_of(load_quad(colliders.size, pairs.b)),
                    a.position, b.position, a.orientation, b.orientation);
}

LOCKSTEP_INLINE floatv load_reach(const Placed<float>& placed, const Cores<floatv>& cores, const HullLanes& a,
                                  const HullLanes& b) {
  const Hulls<float>& hulls = placed.hulls;
  return reach_of(cores, load_quad(hulls.centre, a.hull), load_quad(hulls.half, a.hull),  //
                  load_quad(hulls.centre, b.hull), load_quad(hulls.half, b.hull));
}

}  // namespace lockstep::rigid::openmp
