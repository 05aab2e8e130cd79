// Boxes of the trees, as the verifier and the benchmark see them: bitwise with the serial twin.
#include "common/production_cloth/bvh.h"

#include "verify/production_cloth/crumpled.h"
#include "verify/production_cloth/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::production_cloth_bvh {
namespace {

using namespace production_cloth;
using namespace production_cloth_inputs;

// A vertex has six coordinates, an element two or three numbers of vertices; a box is six numbers. Of a vertex's box 24
// operations, of another 6 a part.
Case make(const std::string& path) {
  const auto in = crumpled(path);
  SearchBoxes<float> start;
  start.resize(in->search);
  const double vertices = in->search.vertices.elements, edges = in->search.edges.elements,
               triangles = in->search.triangles.elements, boxes = vertices + edges + triangles;
  return make_case<SearchBoxes<float>>({
      .start = std::make_shared<const SearchBoxes<float>>(std::move(start)),
      .serial =
          [=](SearchBoxes<float>& b) {
            production_cloth::serial::refit(in->search, in->start, in->end, in->margin, b);
          },
      .best_serial = nullptr,
      .openmp =
          [=](SearchBoxes<float>& b) {
            production_cloth::openmp::refit(in->search, in->start, in->end, in->margin, b);
          },
      .compare = nullptr,
      .work = {boxes, "boxes", 4. * (6 * vertices + 2 * edges + 3 * triangles + 6 * boxes),
               24 * vertices + 6 * edges + 12 * triangles + 6 * boxes},
  });
}

const Register bvh{{.name = "production_cloth/bvh", .place = 3, .forms = {{.make = make, .scenes = all_scenes()}}}};

}  // namespace
}  // namespace lockstep::verify::production_cloth_bvh
