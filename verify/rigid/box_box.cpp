// The rows and benchmarks of boxes against boxes: bitwise with the serial twin.
#include <array>

#include "common/rigid/box_pair.h"
#include "verify/rigid/narrow_inputs.h"

namespace lockstep::verify::rigid_box_box {
namespace {

using namespace rigid;
using namespace rigid_inputs;

// How full the lanes are when box_box tests faces' axes (all pairs) and edges' axes (at least those that touch), and
// makes contacts of faces and of edges. Pairs wait in queues until there are sixteen.
double lane_use(std::span<const Manifold<float>> manifolds) {
  double faces = 0, edges = 0;
  for (const Manifold<float>& m : manifolds)
    if (m.count > 0) ++(m.feature[0] < first_edge_feature ? faces : edges);
  return lanes_in_use(std::array{double(manifolds.size()), faces + edges, faces, edges});
}

Case box_box_case(const std::string& path) {
  return collide_case(path, first_of_box_box, first_of_convexes, serial::box_box, openmp::box_box, 600, lane_use);
}

const Register box_box{{.name = "rigid/box_box",
                        .place = 8,
                        .forms = {{.make = box_box_case,
                                   .scenes = some_scenes({"four_bodies", "degenerate", "assorted", "soup_10", "castle"},
                                                         of_boxes, {"box_pit_4000", "pyramid_15"})}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_box_box
