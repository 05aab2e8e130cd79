// The rows and benchmarks of the tree of boxes, which is built, fitted and descended: bitwise with the serial twins.
#include "common/rigid/broad_phase.h"
#include "verify/rigid/found_pairs.h"

namespace lockstep::verify::rigid_bvh {
namespace {

using namespace rigid;
using namespace rigid_inputs;

struct Grown {
  Tree<float> tree;
};
template <Same<Grown> S, class F>
void for_each_array(S& s, const F& f) {
  const int boxes = s.tree.first.empty() ? 0 : s.tree.first.back();
  f("order", s.tree.order, s.tree.order.size()), f("first", s.tree.first, s.tree.first.size());
  f("boxes.low", s.tree.boxes.low, boxes), f("boxes.high", s.tree.boxes.high, boxes);
}

Case tree_case(const std::string& path, Tree<float> start, spatial::BuildTree<float>* serial,
               spatial::BuildTree<float>* openmp) {
  const auto in = inputs(path);
  const auto with = [in](spatial::BuildTree<float>* make) {
    return [in, make](Grown& s) { make(in->now.bounds, s.tree); };
  };
  const double n = in->now.bounds.count;
  return make_case<Grown>({
      .start = std::make_shared<const Grown>(Grown{std::move(start)}),
      .serial = with(serial),
      .best_serial = nullptr,
      .openmp = with(openmp),
      .compare = nullptr,
      .work = {n, "boxes", n * bytes_of_box, n * 12},
  });
}

Case build_case(const std::string& path) {
  return tree_case(path, inputs(path)->last.tree, serial::bvh_build, openmp::bvh_build);
}

// Starts from a tree in the order of the step before, whose boxes are empty.
Case refit_case(const std::string& path) {
  const auto in = inputs(path);
  Tree<float> start;
  serial::bvh_build(in->last.bounds.count > 0 ? in->last.bounds : in->now.bounds, start);
  for (int i = 0; i < start.boxes.count; ++i) start.boxes.set(i, {{0, 0, 0}, {0, 0, 0}});
  return tree_case(path, std::move(start), serial::bvh_refit, openmp::bvh_refit);
}

Case tree_pairs_case(const std::string& path) {
  const auto in = inputs(path);
  const auto tree = std::make_shared<Tree<float>>();
  serial::bvh_build(in->now.bounds, *tree);
  const auto with = [&](BvhPairs<float>* find) {
    return [in, tree, find](Pairs& pairs) { find(*tree, in->now.bounds, in->group(), pairs); };
  };
  return pairs_case(*in, with(serial::bvh_pairs), with(openmp::bvh_pairs));
}

const Register bvh{{.name = "rigid/bvh",
                    .place = 3,
                    .serial_forms = {"build", "refit", "pairs"},
                    .forms = {{.name = "build", .make = build_case, .scenes = scenes_of_all(of_many_bodies)},
                              {.name = "refit", .make = refit_case, .scenes = scenes_of_all(of_many_bodies)},
                              {.name = "pairs", .make = tree_pairs_case, .scenes = scenes_of_all(of_many_bodies)}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_bvh
