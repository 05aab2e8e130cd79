// Pairs of elements, as the verifier and the benchmark see them: bitwise with the serial twin.
#include "common/production_cloth/pairs.h"

#include <algorithm>

#include "common/production_cloth/bvh.h"
#include "verify/production_cloth/crumpled.h"
#include "verify/production_cloth/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_cloth_pairs {
namespace {

using namespace production_cloth;
using namespace production_cloth_inputs;

constexpr ElementPair poison = {-1, -1};

// As in a simulation, the next pairs take the room of the last ones, which poison fills here.
void restore(ElementPairs& now, const ElementPairs&) {
  std::ranges::fill(now.point_triangle, poison);
  std::ranges::fill(now.edge_edge, poison);
}

// Boxes are read, and pairs written, once; of a pair 6 comparisons.
Case make(const std::string& path) {
  const auto in = crumpled(path);
  const auto boxes = std::make_shared<SearchBoxes<float>>();
  production_cloth::serial::refit(in->search, in->start, in->end, in->margin, *boxes);
  ElementPairs found;
  production_cloth::serial::find_pairs(in->search, *boxes, found);
  const double pairs = static_cast<double>(found.point_triangle.size() + found.edge_edge.size());
  const double bytes =
      24. * (boxes->vertices.count + boxes->edges.count + boxes->triangles.count) + sizeof(ElementPair) * pairs;
  return make_case<ElementPairs>({
      .start = std::make_shared<const ElementPairs>(ElementPairs{{poison}, {poison}}),  // which must be emptied first
      .serial = [=](ElementPairs& p) { production_cloth::serial::find_pairs(in->search, *boxes, p); },
      .best_serial = nullptr,
      .openmp = [=](ElementPairs& p) { production_cloth::openmp::find_pairs(in->search, *boxes, p); },
      .compare = nullptr,
      .work = {pairs, "pairs", bytes, 6 * pairs},
      .restore = restore,
  });
}

const Register pairs{{.name = "production_cloth/pairs", .place = 4, .forms = {{.make = make, .scenes = all_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_cloth_pairs
