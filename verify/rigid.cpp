// The kernels of rigid bodies whose cases have no file of their own yet. Every kernel is looked at in the state that a scene has after
// the steps it says (verify/rigid/inputs.h).
#include <omp.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>

#include "common/rigid/box_pair.h"
#include "common/rigid/broad_phase.h"
#include "common/rigid/narrow_phase.h"
#include "common/rigid/route.h"
#include "common/rigid/scene.h"
#include "common/rigid/step.h"
#include "openmp/rigid/full_blocks.h"
#include "verify/compare.h"
#include "verify/domain.h"
#include "verify/kernel.h"
#include "verify/rigid/inputs.h"
#include "verify/rigid/run.h"

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

// Points that are not there hold nothing, and count as zero.
Words words_of(std::span<const Manifold<float>> manifolds) {
  Words words{{}, record_name("manifold", 6 + 5 * most_points)};
  for (const Manifold<float>& m : manifolds) {
    const bool any = m.count > 0;
    words.add(m.count), words.add(any ? m.a : 0), words.add(any ? m.b : 0), words.add(any ? m.normal : Vector3<float>{0, 0, 0});
    for (int k = 0; k < most_points; ++k) {
      const bool there = k < m.count;
      const ContactPoint<float> point = there ? m.point[k] : ContactPoint<float>{{0, 0, 0}, 0};
      words.add(point.position), words.add(point.separation), words.add(there ? m.feature[k] : 0);
    }
  }
  return words;
}

// Corners that are not there count as zero.
Words words_of(std::span<const Simplex> simplices) {
  Words words{{}, record_name("simplex", 5)};
  for (const Simplex& simplex : simplices) {
    words.add(simplex.count);
    for (int k = 0; k < 4; ++k) words.add(k < simplex.count ? std::int32_t{simplex.a[k]} << 8 | simplex.b[k] : 0);
  }
  return words;
}

Words words_of(std::span<const Closest<float>> closest) {
  Words words{{}, record_name("pair", 8)};
  for (const Closest<float>& c : closest) words.add(c.on_a), words.add(c.on_b), words.add(c.distance), words.add(c.iterations);
  return words;
}

Words words_of(std::span<const SeparatingAxis<float>> axes) {
  Words words{{}, record_name("axis", 11)};
  for (const SeparatingAxis<float>& axis : axes) {
    words.add(axis.normal), words.add(axis.separation), words.add(axis.middle);
    words.add(axis.cosine_a), words.add(axis.cosine_b), words.add(axis.face_a), words.add(axis.face_b);
  }
  return words;
}

// The words of both; names are those of the first, then those of the second.
Words both(Words first, const Words& second) {
  const std::size_t of_first = first.word.size();
  first.word.insert(first.word.end(), second.word.begin(), second.word.end());
  first.name = [=, name = first.name, other = second.name](std::size_t i) { return i < of_first ? name(i) : other(i - of_first); };
  return first;
}

// --- What results are written over: a kernel that leaves some of it as it was must not be right by luck.

Array<Manifold<float>> unwritten_manifolds(std::size_t n) {
  Manifold<float> unwritten = {};
  unwritten.count = most_points, unwritten.a = unwritten.b = -1;
  return Array<Manifold<float>>(padded(n), unwritten);
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

// Pairs for a kernel of the narrow phase, bins `from` .. `to` - 1 (common/rigid/route.h), like ones together, as it gets them.
struct KernelBins {
  int from, to;
};
constexpr KernelBins for_spheres = {first_of_spheres, first_of_planes}, for_planes = {first_of_planes, first_of_box_box},
                     for_box_box = {first_of_box_box, first_of_convexes}, for_convexes = {first_of_convexes, bins};

Pairs pairs_for(const Inputs& in, KernelBins kernel) {
  const auto kind = [&](std::int32_t collider) { return static_cast<Kind>(in.world.colliders.kind[collider]); };
  Pairs pairs;
  for (int bin = kernel.from; bin < kernel.to; ++bin)
    for (const Pair& pair : in.now.pairs)
      if (bin_of(kind(pair.a), kind(pair.b)) == bin) pairs.push_back(pair);
  return pairs;
}

// The lanes at work when box_box tests faces' axes (all pairs), edges' axes (those that touch, at the least), and makes contacts of faces
// and of edges: pairs wait in queues until there are sixteen.
double lane_use_of_boxes(std::span<const Manifold<float>> manifolds) {
  double faces = 0, edges = 0;
  for (const Manifold<float>& m : manifolds)
    if (m.count > 0) ++(m.feature[0] < first_edge_feature ? faces : edges);
  return lanes_in_use(std::array{double(manifolds.size()), faces + edges, faces, edges});
}

Case collide_case(const std::string& path, KernelBins kernel, Collide<float>* serial, Collide<float>* openmp, double flops) {
  using State = Array<Manifold<float>>;
  const Shared in = inputs(path);
  const auto pairs = std::make_shared<const Pairs>(pairs_for(*in, kernel));
  const auto with = [in, pairs](Collide<float>* collide) {
    return [in, pairs, collide](State& manifolds) {
      collide(in->placed(), *pairs, static_cast<float>(in->settings.margin), {manifolds.data(), pairs->size()});
    };
  };
  const double n = static_cast<double>(pairs->size());
  double lane_use = 0;
  if (openmp == openmp::box_box) {
    State there(padded(pairs->size()));
    with(serial)(there);
    lane_use = lane_use_of_boxes({there.data(), pairs->size()});
  }
  return bitwise_case<State>(unwritten_manifolds(pairs->size()), with(serial), with(openmp),
                             [pairs](const State& m) { return words_of(std::span(m.data(), pairs->size())); },
                             {n, "pairs", n * (2 * bytes_of_pose + bytes_of_manifold), n * flops, lane_use});
}

// The lanes at work in the looks of gjk, whose blocks end when few are left: replayed with as many looks as each pair took. The
// first look of a pair without a simplex goes without the loop.
double lane_use_of_looks(const Placed<float>& placed, std::span<const Pair> pairs, std::span<const Closest<float>> closest, bool warm) {
  double used = 0, there = 0;
  for (std::size_t first = 0; first < pairs.size(); first += openmp::chunk_size) {
    const int n = static_cast<int>(std::min<std::size_t>(openmp::chunk_size, pairs.size() - first));
    std::vector<int> left(n);
    for (int k = 0; k < n; ++k) left[k] = closest[first + k].iterations - !warm;
    openmp::in_full_blocks(
        n, [&](int k) { return openmp::size_key(placed, pairs[first + k]); },
        [&](std::span<std::int32_t> which, int enough) {
          const auto unfinished = [&] { return static_cast<int>(std::ranges::count_if(which, [&](int k) { return left[k] > 0; })); };
          for (int active = unfinished(); active > enough; active = unfinished()) {
            used += active, there += lanes;
            for (const int k : which) left[k] -= left[k] > 0;
          }
          std::stable_partition(which.begin(), which.end(), [&](int k) { return left[k] > 0; });
          return unfinished();
        });
  }
  return there > 0 ? used / there : 0;
}

std::shared_ptr<const Pairs> convex_pairs(const Inputs& in) { return std::make_shared<const Pairs>(pairs_for(in, for_convexes)); }

// Where GJK starts: from the simplices of the step before, or from nothing.
std::vector<Simplex> first_simplices(const Inputs& in, const Pairs& pairs, bool warm) {
  std::vector<Simplex> simplex(pairs.size(), Simplex{});
  for (std::size_t k = 0; warm && k < pairs.size(); ++k) {
    const Pairs& known = in.last.narrow_phase.pairs;
    const auto at = std::ranges::lower_bound(known, pairs[k]);
    if (at != known.end() && *at == pairs[k]) simplex[k] = in.last.narrow_phase.simplex[at - known.begin()];
  }
  return simplex;
}

// What GJK makes of pairs.
struct Distances {
  std::vector<Simplex> simplex;
  Array<Closest<float>> closest;
};
Distances serial_distances(const Inputs& in, const Pairs& pairs, bool warm) {
  Distances result = {first_simplices(in, pairs, warm), Array<Closest<float>>(padded(pairs.size()))};
  serial::gjk(in.placed(), pairs, result.simplex, {result.closest.data(), pairs.size()});
  return result;
}

Case gjk_case(const std::string& path, bool warm) {
  const Shared in = inputs(path);
  const auto pairs = convex_pairs(*in);
  const auto with = [=](Gjk<float>* gjk) {
    return [=](Distances& s) { gjk(in->placed(), *pairs, s.simplex, {s.closest.data(), pairs->size()}); };
  };
  Distances start = {first_simplices(*in, *pairs, warm), {}};
  start.closest.resize(padded(pairs->size()), {{0, 0, 0}, {0, 0, 0}, -1, -1});
  const double n = static_cast<double>(pairs->size());
  const double lane_use = lane_use_of_looks(in->placed(), *pairs, serial_distances(*in, *pairs, warm).closest, warm);
  return bitwise_case<Distances>(
      start, with(serial::gjk), with(openmp::gjk),
      [=](const Distances& s) {
        return both(words_of(std::span<const Closest<float>>(s.closest.data(), pairs->size())), words_of(s.simplex));
      },
      {n, "pairs", n * (2 * bytes_of_pose + sizeof(Closest<float>)), n * 2000, lane_use});
}

using Axes = Array<SeparatingAxis<float>>;

Case convex_axes_case(const std::string& path) {
  const Shared in = inputs(path);
  const auto pairs = convex_pairs(*in);
  const auto known = std::make_shared<const Distances>(serial_distances(*in, *pairs, true));
  const auto with = [=](ConvexAxes<float>* convex_axes) {
    return [=](Axes& axes) {
      convex_axes(in->placed(), *pairs, known->simplex, {known->closest.data(), pairs->size()}, static_cast<float>(in->settings.margin),
                  {axes.data(), pairs->size()});
    };
  };
  const double n = static_cast<double>(pairs->size());
  const SeparatingAxis<float> unwritten = {{-1, -1, -1}, -1, {-1, -1, -1}, -1, -1, -1, -1, {}};
  return bitwise_case<Axes>(
      Axes(padded(pairs->size()), unwritten), with(serial::convex_axes), with(openmp::convex_axes),
      [=](const Axes& axes) { return words_of(std::span<const SeparatingAxis<float>>(axes.data(), pairs->size())); },
      {n, "pairs", n * (2 * bytes_of_pose + sizeof(SeparatingAxis<float>)), n * 1500});
}

Case convex_clip_case(const std::string& path) {
  using State = Array<Manifold<float>>;
  const Shared in = inputs(path);
  const auto pairs = convex_pairs(*in);
  const Distances known = serial_distances(*in, *pairs, true);
  const auto axes = std::make_shared<Axes>(padded(pairs->size()));
  const float margin = static_cast<float>(in->settings.margin);
  serial::convex_axes(in->placed(), *pairs, known.simplex, {known.closest.data(), pairs->size()}, margin, {axes->data(), pairs->size()});
  const auto with = [=](ConvexClip<float>* convex_clip) {
    return [=](State& manifolds) {
      convex_clip(in->placed(), *pairs, {axes->data(), pairs->size()}, margin, {manifolds.data(), pairs->size()});
    };
  };
  const double n = static_cast<double>(pairs->size());
  return bitwise_case<State>(unwritten_manifolds(pairs->size()), with(serial::convex_clip), with(openmp::convex_clip),
                             [=](const State& m) { return words_of(std::span<const Manifold<float>>(m.data(), pairs->size())); },
                             {n, "pairs", n * (2 * bytes_of_pose + sizeof(SeparatingAxis<float>) + bytes_of_manifold), n * 500});
}

Case narrow_phase_case(const std::string& path) {
  struct State {
    NarrowPhaseState state;
    Array<Manifold<float>> manifolds;
  };
  const Shared in = inputs(path);
  const auto with = [in](NarrowPhase<float>* narrow_phase) {
    return [in, narrow_phase](State& s) {
      narrow_phase(in->placed(), in->now.pairs, static_cast<float>(in->settings.margin), s.state, s.manifolds);
    };
  };
  const double n = static_cast<double>(in->now.pairs.size());
  return bitwise_case<State>(
      {in->last.narrow_phase, in->last.manifolds}, with(serial::narrow_phase), with(openmp::narrow_phase),
      [](const State& s) { return both(words_of(s.manifolds), both(words_of(s.state.pairs), words_of(s.state.simplex))); },
      {n, "pairs", n * (2 * bytes_of_pose + bytes_of_manifold), n * 500});
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
  add("rigid/plane_pairs", "", all, more, many, [](const std::string& path) {
    const auto with = [](PlanePairs<float>* find) {
      return [find](const Inputs& in, Pairs& pairs) { find(in.world.colliders, in.placed().pose, in.now.bounds, pairs); };
    };
    return pairs_case(path, with(serial::plane_pairs), with(openmp::plane_pairs));
  });

  const auto add_collide = [&](const char* name, KernelBins kernel, Collide<float>* serial, Collide<float>* openmp, double flops,
                               Scenes some, Scenes bench) {
    add(name, "", some, more, bench, [=](const std::string& path) { return collide_case(path, kernel, serial, openmp, flops); });
  };
  add_collide("rigid/spheres", for_spheres, serial::spheres, openmp::spheres, 60, {"rounds_20000", "soup_10", "assorted", "degenerate"},
              {"rounds_20000"});
  add_collide("rigid/planes", for_planes, serial::planes, openmp::planes, 150, all, {"box_pit_4000"});
  add_collide("rigid/box_box", for_box_box, serial::box_box, openmp::box_box, 600,
              {"four_bodies", "degenerate", "assorted", "soup_10", "castle"}, of_boxes);
  for (const bool warm : {true, false})
    add("rigid/gjk", warm ? "warm" : "cold", {"degenerate", "soup_10", "mesh_and_hulls"}, more, of_hulls,
        [warm](const std::string& path) { return gjk_case(path, warm); });
  add("rigid/convex_axes", "", {"degenerate", "soup_10", "mesh_and_hulls"}, more, of_hulls, convex_axes_case);
  add("rigid/convex_clip", "", {"degenerate", "soup_10", "mesh_and_hulls"}, more, of_hulls, convex_clip_case);
  add("rigid/narrow_phase", "", all, more, settled, narrow_phase_case);
  return kernels;
}

}  // namespace lockstep::verify
