// The kernels of rigid bodies whose cases have no file of their own yet. Every kernel is looked at in the state that a scene has after
// the steps it says (verify/rigid/inputs.h).
#include <algorithm>
#include <bit>
#include <memory>

#include "common/rigid/broad_phase.h"
#include "common/rigid/scene.h"
#include "common/rigid/step.h"
#include "verify/compare.h"
#include "verify/domain.h"
#include "verify/kernel.h"
#include "verify/rigid/inputs.h"

namespace lockstep::verify {
namespace {

using namespace rigid;

// --- What a kernel leaves, as words to compare

struct Words {
  std::vector<std::uint32_t> word;
  ElementName name;

  void add(float x) { word.push_back(std::bit_cast<std::uint32_t>(x)); }
  void add(std::int32_t x) { word.push_back(static_cast<std::uint32_t>(x)); }
  void add(const Vector3<float>& v) { add(v.x), add(v.y), add(v.z); }
};

// Words come in records of equal length.
ElementName record_name(std::string what, std::size_t words_each) {
  return [=](std::size_t i) { return what + " " + std::to_string(i / words_each) + ", word " + std::to_string(i % words_each); };
}

Words words_of(const Pairs& pairs) {
  Words words{{}, record_name("pair", 2)};
  for (const Pair& pair : pairs) words.add(pair.a), words.add(pair.b);
  return words;
}

// The words of both; names are those of the first, then those of the second.
Words both(Words first, const Words& second) {
  const std::size_t of_first = first.word.size();
  first.word.insert(first.word.end(), second.word.begin(), second.word.end());
  first.name = [=, name = first.name, other = second.name](std::size_t i) { return i < of_first ? name(i) : other(i - of_first); };
  return first;
}

using namespace rigid_inputs;
using Shared = std::shared_ptr<const Inputs>;

const Pairs to_forget = {{0, 0}};

// --- Cases

// A kernel that turns `State` into another, as serial and openmp do it.
template <class State>
Case bitwise_case(State start, std::function<void(State&)> serial, std::function<void(State&)> openmp,
                  std::function<Words(const State&)> words, Work work) {
  struct Both {
    State start, serial, openmp;
    Words expected;
  };
  auto s = std::make_shared<Both>(Both{start, start, start, {}});
  serial(s->serial);
  s->expected = words(s->serial);
  return {
      .reset = [s] { s->serial = s->start, s->openmp = s->start; },
      .serial = [s, serial] { serial(s->serial); },
      .best_serial = nullptr,
      .openmp = [s, openmp] { openmp(s->openmp); },
      .judge =
          [s, words] {
            Judgement judgement{.verdict = Verdict::bitwise, .worst_at = ""};
            const Words found = words(s->openmp);
            if (found.word.size() != s->expected.word.size()) {
              judgement.passed = false;
              judgement.worst_at =
                  "words: openmp " + std::to_string(found.word.size()) + ", serial " + std::to_string(s->expected.word.size());
              return judgement;
            }
            same_bits(judgement, std::span<const std::uint32_t>(found.word), std::span<const std::uint32_t>(s->expected.word),
                      s->expected.name);
            return judgement;
          },
      .hash = [s, words] { return hash_bytes(std::span<const std::uint32_t>(words(s->openmp).word)); },
      .work = std::move(work),
  };
}

// A broad phase without a state, or with one that is as the step before left it.
Case pairs_case(const std::string& path, std::function<void(const Inputs&, Pairs&)> serial,
                std::function<void(const Inputs&, Pairs&)> openmp) {
  const Shared in = inputs(path);
  const auto with = [in](std::function<void(const Inputs&, Pairs&)> find) { return [in, find](Pairs& pairs) { find(*in, pairs); }; };
  const double n = in->now.bounds.count, found = static_cast<double>(in->now.bounded.size());
  return bitwise_case<Pairs>(to_forget, with(serial), with(openmp), [](const Pairs& pairs) { return words_of(pairs); },
                             {n, "boxes", n * bytes_of_box + found * sizeof(Pair), found * 6});
}

// How many boxes each meets along the axis that sweep and prune takes: its candidates, tested sixteen at once.
std::vector<int> candidates_of_sweep(const Bounds<float>& bounds, int axis) {
  const auto along = [axis](const Vectors<float>& v) { return axis == 0 ? v.x.data() : axis == 1 ? v.y.data() : v.z.data(); };
  std::vector<float> low;
  for (int i = 0; i < bounds.count; ++i)
    if (bounds.bounded(i)) low.push_back(along(bounds.low)[i]);
  std::ranges::sort(low);
  std::vector<int> candidates;
  for (int i = 0; i < bounds.count; ++i)
    if (bounds.bounded(i))
      candidates.push_back(
          static_cast<int>(std::ranges::upper_bound(low, along(bounds.high)[i]) - std::ranges::upper_bound(low, along(bounds.low)[i])));
  return candidates;
}

// The order of the boxes and the axis are part of the answer.
Case sweep_case(const std::string& path, SweepAndPrune<float>* serial, SweepAndPrune<float>* openmp) {
  struct State {
    SweepOrder order;
    Pairs pairs;
  };
  const Shared in = inputs(path);
  const auto with = [in](SweepAndPrune<float>* find) {
    return [in, find](State& s) { find(in->now.bounds, in->group(), s.order, s.pairs); };
  };
  State start, answer;
  start.order.order.assign(1, 0), start.pairs = to_forget;
  with(serial)(answer);
  const double n = in->now.bounds.count, found = static_cast<double>(in->now.bounded.size());
  return bitwise_case<State>(start, with(serial), with(openmp),
                             [](const State& s) {
                               Words order{{}, record_name("place in the order", 1)};
                               for (const std::int32_t collider : s.order.order) order.add(collider);
                               order.add(s.order.axis);
                               return both(words_of(s.pairs), order);
                             },
                             {n, "boxes", n * bytes_of_box + found * sizeof(Pair), found * 6,
                              lanes_in_use(candidates_of_sweep(in->now.bounds, answer.order.axis))});
}

Case tree_case(const std::string& path, bool refit, spatial::BuildTree<float>* serial_change, spatial::BuildTree<float>* openmp_change) {
  const Shared in = inputs(path);
  const auto with = [in](spatial::BuildTree<float>* change) { return [in, change](Tree<float>& tree) { change(in->now.bounds, tree); }; };
  Tree<float> start = in->last.tree;
  if (refit) {
    serial::bvh_build(in->last.bounds.count > 0 ? in->last.bounds : in->now.bounds, start);
    for (int i = 0; i < start.boxes.count; ++i) start.boxes.set(i, {{0, 0, 0}, {0, 0, 0}});
  }
  const double n = in->now.bounds.count;
  return bitwise_case<Tree<float>>(start, with(serial_change), with(openmp_change),
                                   [](const Tree<float>& tree) {
                                     Words words{{}, record_name("tree", 1)};
                                     for (const std::int32_t collider : tree.order) words.add(collider);
                                     for (int i = 0; i < (tree.first.empty() ? 0 : tree.first.back()); ++i)
                                       for (const Vectors<float>* corner : {&tree.boxes.low, &tree.boxes.high})
                                         words.add(corner->x[i]), words.add(corner->y[i]), words.add(corner->z[i]);
                                     return words;
                                   },
                                   {n, "boxes", n * bytes_of_box, n * 12});
}

}  // namespace

std::vector<Kernel> rigid_kernels() {
  using Scenes = std::vector<std::string>;
  const auto scenes = [](Scenes names) {
    for (std::string& name : names) name = "scenes/rigid/" + name + ".toml";
    return names;
  };
  const auto takes = [](const std::string& path) { return domain_of_scene(path).name == "rigid"; };
  std::vector<Kernel> kernels;
  const auto add = [&](const char* name, const char* form, Scenes some, Scenes more, Scenes bench, auto make) {
    kernels.push_back({name, form, false, scenes(some), scenes(more), scenes(bench), takes, make});
  };
  const Scenes all = {"four_bodies", "degenerate", "assorted", "soup_10", "mesh_and_hulls", "rounds_20000", "castle"};
  const Scenes more = {"soup_1",     "soup_50", "hull_soup",  "box_pit_4000", "hull_pit_2000",
                       "pyramid_24", "wall",    "castle_hit", "dominoes_1000"};
  const Scenes many = of_many_bodies;

  add("rigid/sweep_and_prune", "batch", all, more, many,
      [](const std::string& path) { return sweep_case(path, serial::sweep_and_prune_batch, openmp::sweep_and_prune_batch); });
  add("rigid/bvh", "build", all, more, many,
      [](const std::string& path) { return tree_case(path, false, serial::bvh_build, openmp::bvh_build); });
  add("rigid/bvh", "refit", all, more, many,
      [](const std::string& path) { return tree_case(path, true, serial::bvh_refit, openmp::bvh_refit); });
  add("rigid/bvh", "pairs", all, more, many, [](const std::string& path) {
    const auto descend = [tree = std::make_shared<Tree<float>>()](BvhPairs<float>* find) {
      return [tree, find](const Inputs& in, Pairs& pairs) {
        if (tree->order.empty()) serial::bvh_build(in.now.bounds, *tree);
        find(*tree, in.now.bounds, in.group(), pairs);
      };
    };
    return pairs_case(path, descend(serial::bvh_pairs), descend(openmp::bvh_pairs));
  });
  add("rigid/grid", "", all, more, many, [](const std::string& path) {
    const auto hash = [](GridPairs<float>* find) {
      return [find](const Inputs& in, Pairs& pairs) { find(in.now.bounds, in.group(), pairs); };
    };
    return pairs_case(path, hash(serial::grid), hash(openmp::grid));
  });
  return kernels;
}

}  // namespace lockstep::verify
