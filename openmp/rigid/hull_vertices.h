// The vertices of sixteen hulls side by side, a hull a lane: so the support mapping of sixteen hulls is one loop over
// whole vectors, with one compare and one select a vertex.
#pragma once

#include <algorithm>

#include "common/real.h"
#include "common/rigid/world.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {

// Where a hull has fewer vertices than another, its first one is repeated.
struct Vertices {
  intv first;  // in the library
  int count;   // of the hull that has most
  Vector3<floatv> position[most_hull_vertices];
};

// The support mapping: the vertex farthest along a direction; the first of equals.
LOCKSTEP_INLINE intv support(const Vertices& vertices, const Vector3<floatv>& direction) {
  intv farthest = 0;
  floatv most = dot(direction, vertices.position[0]);
  for (int k = 1; k < vertices.count; ++k) {
    const floatv along = dot(direction, vertices.position[k]);
    where(along > most, farthest) = k;
    most = max(along, most);
  }
  return farthest;
}

// A load takes four vertices of one hull, sixteen numbers. Sixteen such rows are transposed from a row a hull to a row
// a coordinate.
LOCKSTEP_INLINE void load_vertices(const Hulls<Real>& hulls, const Indices& hull, Vertices& vertices) {
  Indices begin, vertices_of;
  int least = most_hull_vertices;
  vertices.count = 0;
  for (int l = 0; l < lanes; ++l) {
    const int n = hulls.vertices(hull.index[l]);
    begin.index[l] = hulls.first_vertex[hull.index[l]], vertices_of.index[l] = n;
    vertices.count = std::max(vertices.count, n), least = std::min(least, n);
  }
  vertices.first = load(begin.index);
  const intv count = load(vertices_of.index);
  for (int k = 0; k < vertices.count; k += 4) {
    floatv row[lanes];
    if (k < least)
      for (int l = 0; l < lanes; ++l) row[l] = load(&hulls.vertex[begin.index[l] + k].x);
    else
      for (int l = 0; l < lanes; ++l)
        row[l] = load(&hulls.vertex[begin.index[l] + (k < vertices_of.index[l] ? k : 0)].x);
    transpose(row);
    for (int m = 0; m < 4; ++m) {
      const Vector3<floatv> v = {row[4 * m], row[4 * m + 1], row[4 * m + 2]};
      vertices.position[k + m] = k + m == 0 ? v : select(count > k + m, v, vertices.position[0]);
    }
  }
}

}  // namespace lockstep::rigid::openmp
