// Hulls by component: the x of all vertices, then the y, and so on, so that sixteen vertices or sixteen faces of one
// hull are loaded side by side. A hull is part of many pairs, and is transposed once.
#pragma once

#include <vector>

#include "common/real.h"
#include "common/rigid/convexes.h"
#include "openmp/rigid/lanes.h"

namespace lockstep::rigid::openmp {

// The hulls of all pairs. Elements beyond the last vertex or face repeat it.
struct HullComponents {
  std::vector<std::int32_t> begin;  // [hull]: where its components begin; -1 of what no pair has
  // Of a hull: x, y and z of its vertices, then x, y, z and w of its planes, each in whole vectors.
  Array<Real> component;
};

constexpr int whole(int count) { return (count + lanes - 1) / lanes * lanes; }

inline HullComponents components_of(const Placed<Real>& placed, std::span<const Pair> pairs) {
  const Hulls<Real>& hulls = placed.hulls;
  HullComponents result;
  result.begin.assign(hulls.count, -1);
  std::vector<std::int32_t> met;
  std::int32_t end = 0;
  for (const auto& [a, b] : pairs)
    for (const int collider : {a, b}) {
      const int hull = placed.colliders.hull[collider];
      if (result.begin[hull] >= 0) continue;
      result.begin[hull] = end;
      met.push_back(hull);
      end += 3 * whole(hulls.vertices(hull)) + 4 * whole(hulls.faces(hull));
    }
  result.component.resize(end);

  // Iterations are independent: a hull is in `met` once, and its components are its own.
#pragma omp parallel for schedule(static)
  for (const int hull : met) {
    Real* out = &result.component[result.begin[hull]];
    const auto transpose_quads = [&](const Array<Quad<Real>>& quads, int first, int count, int components) {
      for (int k = 0; k < count; k += lanes) {
        const auto [x, y, z, w] = load_quad(quads, indices_of(min(lane_index() + k, intv(count - 1)) + first));
        const floatv component[] = {x, y, z, w};
        for (int c = 0; c < components; ++c) store(out + c * whole(count) + k, component[c]);
      }
      out += components * whole(count);
    };
    transpose_quads(hulls.vertex, hulls.first_vertex[hull], hulls.vertices(hull), 3);
    transpose_quads(hulls.plane, hulls.first_face[hull], hulls.faces(hull), 4);
  }
  return result;
}

}  // namespace lockstep::rigid::openmp
