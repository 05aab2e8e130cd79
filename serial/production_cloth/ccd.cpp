// Continuous collision detection, a pair at a time: four tests that dismiss pairs, from the cheapest to the dearest,
// and then the search for the impact, in double.
//
// The contract stands in common/production_cloth/ccd.h, the tests in ccd_filters.h, the search in ccd_impact.h.
#include "common/production_cloth/ccd.h"

#include "common/production_cloth/ccd_impact.h"
#include "common/real.h"

namespace lockstep::production_cloth::serial {
namespace {

using namespace meeting;
using Number = Real;
using Vertices = std::array<std::int32_t, 4>;

struct Found {
  Vertices corner;
  Impact<double> impact;
};

Corners<Number> load_corners(const Vectors<Real>& start, const Vectors<Real>& end, const Vertices& corner) {
  Corners<Number> x;
  for (int i = 0; i < 4; ++i) x.start[i] = load(start, corner[i]), x.end[i] = load(end, corner[i]);
  return x;
}

Corners<double> to_double(const Corners<Number>& x) {
  Corners<double> wide;
  for (int i = 0; i < 4; ++i) {
    wide.start[i] = {x.start[i].x, x.start[i].y, x.start[i].z};
    wide.end[i] = {x.end[i].x, x.end[i].y, x.end[i].z};
  }
  return wide;
}

// Whether the tests leave the pair.
template <Kind kind>
bool may_meet(const Corners<Number>& x) {
  if (apart_along_axes<kind>(x)) return false;
  const Spans<Number> spans = spans_of(x);
  return !(apart_midway<kind>(spans) || never_in_plane(cubic_of(spans)) || apart_in_quarters<kind>(spans));
}

template <Kind kind>
void find(const Array<ElementPair>& pairs, const auto& corners_of, const Vectors<Real>& start, const Vectors<Real>& end,
          std::vector<Found>& found) {
  for (const ElementPair& pair : pairs) {
    const Vertices corner = corners_of(pair);
    const Corners<Number> x = load_corners(start, end, corner);
    Impact<double> impact;
    if (may_meet<kind>(x) && find_impact<kind>(to_double(x), impact)) found.push_back({corner, impact});
  }
}

}  // namespace

void ccd(const Topology& topology, const ElementPairs& pairs, const Vectors<Real>& start, const Vectors<Real>& end,
         Contacts<Real>& impacts) {
  std::vector<Found> found;
  find<Kind::point_triangle>(
      pairs.point_triangle, [&](const ElementPair& p) { return corners_of_point_triangle(topology, p); }, start, end,
      found);
  find<Kind::edge_edge>(
      pairs.edge_edge, [&](const ElementPair& p) { return corners_of_edge_edge(topology, p); }, start, end, found);
  impacts.resize(found.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    const auto& [corner, impact] = found[k];
    const double normal[4] = {impact.normal.x, impact.normal.y, impact.normal.z, impact.time};
    for (int i = 0; i < 4; ++i) {
      impacts.corner[4 * k + i] = corner[i];
      impacts.weight[4 * k + i] = static_cast<Real>(impact.weight[i]);
      impacts.normal[4 * k + i] = static_cast<Real>(normal[i]);
    }
  }
}

}  // namespace lockstep::production_cloth::serial
