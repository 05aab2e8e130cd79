// The rigid bodies' kernels, as the verifier and the benchmark see them.
//
// Every kernel is looked at in the state that a scene has after the steps it says (`settle`), as the step before left it: the same bodies
// in, the same pairs, contacts, impulses and velocities out, bit for bit. What an alternative costs is asked in rows of their own
// (`batches_for_original`); whole runs in verify/rigid_run.cpp.
#include <omp.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>

#include "common/rigid/batches.h"
#include "common/rigid/box_pair.h"
#include "common/rigid/broad_phase.h"
#include "common/rigid/contact_solver.h"
#include "common/rigid/integrate.h"
#include "common/rigid/match_contacts.h"
#include "common/rigid/narrow_phase.h"
#include "common/rigid/route.h"
#include "common/rigid/scene.h"
#include "common/rigid/step.h"
#include "openmp/rigid/full_blocks.h"
#include "verify/compare.h"
#include "verify/domain.h"
#include "verify/kernel.h"
#include "verify/rigid_run.h"

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

Words words_of(const Bodies<float>& bodies) {
  Words words{{}, record_name("body", 13)};
  for (int i = 0; i < bodies.count; ++i) {
    const Pose<float>& pose = bodies.pose[i];
    const Quaternion<float>& q = pose.orientation;
    words.add(pose.position), words.add(q.x), words.add(q.y), words.add(q.z), words.add(q.w);
    words.add(bodies.motion[i].velocity), words.add(bodies.motion[i].angular_velocity);
  }
  return words;
}

Words words_of(std::span<const Motion<float>> motions) {
  Words words{{}, record_name("motion", 6)};
  for (const Motion<float>& motion : motions) words.add(motion.velocity), words.add(motion.angular_velocity);
  return words;
}

Words words_of(std::span<const Impulses<float>> impulses, std::span<const Manifold<float>> manifolds) {
  Words words{{}, record_name("manifold", 3 * most_points)};
  for (std::size_t i = 0; i < manifolds.size(); ++i)
    for (int k = 0; k < most_points; ++k) {
      const bool there = k < manifolds[i].count;
      for (const float* row : {impulses[i].normal, impulses[i].tangent, impulses[i].bitangent}) words.add(there ? row[k] : 0.f);
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

const Pairs to_forget = {{0, 0}};

Array<Impulses<float>> unwritten_impulses(std::size_t n) {
  Impulses<float> unwritten;
  for (float* row : {unwritten.normal, unwritten.tangent, unwritten.bitangent, unwritten.unused}) std::fill_n(row, most_points, -1.f);
  return Array<Impulses<float>>(n, unwritten);
}

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

// A scene, and what the last of its settling steps left. Settling takes longer than most kernels, which come one after another with the
// same few scenes; states are large, so few are kept.
constexpr std::size_t inputs_kept = 4;
struct Inputs {
  Scene scene;
  World<float> world;      // settled
  StepMemory<float> last;  // of the step before
  StepMemory<float> now;   // of the step to come, by serial code: what each phase finds
  StepSettings settings;

  Placed<float> placed() const {
    return {world.colliders, world.hulls, {now.placed.data(), static_cast<std::size_t>(world.colliders.count)}};
  }
  std::span<const std::int32_t> group() const { return {world.colliders.group.data(), static_cast<std::size_t>(world.colliders.count)}; }
  std::span<const std::int32_t> body() const { return {world.colliders.body.data(), static_cast<std::size_t>(world.colliders.count)}; }
};
using Shared = std::shared_ptr<const Inputs>;

Shared inputs(const std::string& path) {
  static std::vector<std::pair<std::string, Shared>> known;  // the last used last
  const auto found = std::ranges::find(known, path, &std::pair<std::string, Shared>::first);
  if (found != known.end()) {
    std::rotate(found, found + 1, known.end());
    return known.back().second;
  }
  if (known.size() == inputs_kept) known.erase(known.begin());
  auto in = std::make_shared<Inputs>();
  in->scene = load_scene(path);
  in->settings = settings_of(in->scene);
  in->world = in->scene.world;
  for (int step = 0; step < in->scene.settle; ++step) openmp::step_batches(in->settings, in->world, in->last);
  in->now = in->last;
  World<float> after = in->world;
  serial::step_batches(in->settings, after, in->now);
  return known.emplace_back(path, in).second;
}

constexpr double bytes_of_box = 24, bytes_of_pose = 32, bytes_of_manifold = sizeof(Manifold<float>);

Case place_case(const std::string& path) {
  struct State {
    Array<Pose<float>> placed;
    Bounds<float> bounds;
  };
  const Shared in = inputs(path);
  const auto with = [in](PlaceColliders<float>* place) {
    return [in, place](State& s) { place(in->world, static_cast<float>(in->settings.margin / 2), s.placed, s.bounds); };
  };
  const double n = in->world.colliders.count;
  return bitwise_case<State>({in->last.placed, in->last.bounds}, with(serial::place_colliders), with(openmp::place_colliders),
                             [in](const State& s) {
                               Words words{{}, record_name("collider", 13)};
                               for (int i = 0; i < in->world.colliders.count; ++i) {
                                 const Quaternion<float>& q = s.placed[i].orientation;
                                 words.add(s.placed[i].position), words.add(q.x), words.add(q.y), words.add(q.z), words.add(q.w);
                                 for (const Vectors<float>* corner : {&s.bounds.low, &s.bounds.high})
                                   words.add(corner->x[i]), words.add(corner->y[i]), words.add(corner->z[i]);
                               }
                               return words;
                             },
                             {n, "colliders", n * (3 * bytes_of_pose + bytes_of_box), n * 120});
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

Case match_case(const std::string& path) {
  using State = Array<Impulses<float>>;
  const Shared in = inputs(path);
  const auto with = [in](MatchContacts<float>* match) {
    return [in, match](State& impulses) { match(in->last.manifolds, in->last.impulses, in->now.manifolds, impulses); };
  };
  const double n = static_cast<double>(in->now.manifolds.size());
  return bitwise_case<State>(unwritten_impulses(in->now.manifolds.size()), with(serial::match_contacts), with(openmp::match_contacts),
                             [in](const State& impulses) { return words_of(impulses, in->now.manifolds); },
                             {n, "contacts", n * 2 * (bytes_of_manifold + sizeof(Impulses<float>)), 0});
}

// What the solver is given.
struct Solved {
  Bodies<float> bodies;
  Array<Impulses<float>> impulses;
  Array<Motion<float>> moving;
};

Solved solver_start(const Inputs& in) {
  Solved start{in.world.bodies, Array<Impulses<float>>(in.now.manifolds.size()), in.last.moving};
  serial::match_contacts(in.last.manifolds, in.last.impulses, in.now.manifolds, start.impulses);
  return start;
}

double rows_of(const Inputs& in) {
  double points = 0;
  for (const Manifold<float>& m : in.now.manifolds) points += m.count;
  const SolverSettings& solver = in.settings.solver;
  return points * solver.substeps * (solver.pushing + 3 * solver.resting);
}

std::vector<int> sizes_of(const Batches& batches) {
  std::vector<int> sizes(batches.count());
  for (int k = 0; k < batches.count(); ++k) sizes[k] = batches.begin[k + 1] - batches.begin[k];
  return sizes;
}

Case solver_case(const std::string& path, bool reordered) {
  const Shared in = inputs(path);
  const auto original = [in](SolveOriginal<float>* solve) {
    return [in, solve](Solved& s) { solve(in->settings.solver, in->now.manifolds, in->body(), s.bodies, s.impulses, s.moving); };
  };
  const auto batched = [in](SolveBatches<float>* solve) {
    return [in, solve](Solved& s) {
      solve(in->settings.solver, in->now.manifolds, in->body(), in->now.batches, s.bodies, s.impulses, s.moving);
    };
  };
  using Change = std::function<void(Solved&)>;
  const Change serial = reordered ? Change(batched(serial::solve_contacts_batches)) : Change(original(serial::solve_contacts_original));
  const Change openmp = reordered ? Change(batched(openmp::solve_contacts_batches)) : Change(original(openmp::solve_contacts_original));
  const double rows = rows_of(*in), contacts = static_cast<double>(in->now.manifolds.size());
  Case run = bitwise_case<Solved>(solver_start(*in), serial, openmp,
                                  [in](const Solved& s) {
                                    const std::span moving(s.moving.data(), s.bodies.count);
                                    return both(words_of(s.bodies), both(words_of(s.impulses, in->now.manifolds), words_of(moving)));
                                  },
                                  {rows, "rows", contacts * (bytes_of_manifold + 2 * sizeof(Impulses<float>)), rows * 75,
                                   reordered ? lanes_in_use(sizes_of(in->now.batches)) : 0});
  if (reordered) {
    const auto s = std::make_shared<Solved>(solver_start(*in));
    run.best_serial = [s, start = solver_start(*in), solve = original(serial::solve_contacts_original)] { solve(*s); };
  }
  return run;
}

Case batches_case(const std::string& path, ReorderContacts<float>* openmp) {
  const Shared in = inputs(path);
  const auto with = [in](ReorderContacts<float>* reorder) {
    return [in, reorder](Batches& batches) { batches = reorder(in->now.manifolds, in->body(), in->world.bodies); };
  };
  const double n = static_cast<double>(in->now.manifolds.size());
  return bitwise_case<Batches>({}, with(serial::reorder_contacts), with(openmp),
                               [](const Batches& batches) {
                                 Words words{{}, record_name("entry", 1)};
                                 for (const std::int32_t k : batches.order) words.add(k);
                                 for (const std::int32_t k : batches.begin) words.add(k);
                                 return words;
                               },
                               {n, "contacts", n * 20, 0});
}

Case advance_case(const std::string& path) {
  const Shared in = inputs(path);
  const auto with = [in](Integrate<float>* integrate) {
    return [in, integrate](Bodies<float>& bodies) { integrate(in->now.moving, static_cast<float>(in->settings.solver.time_step), bodies); };
  };
  const double n = in->world.bodies.count;
  return bitwise_case<Bodies<float>>(in->world.bodies, with(serial::integrate), with(openmp::integrate),
                                     [](const Bodies<float>& bodies) { return words_of(bodies); },
                                     {n, "bodies", n * 6 * bytes_of_pose, n * 350});
}

Case step_case(const std::string& path, Step<float>* serial, Step<float>* openmp) {
  struct State {
    World<float> world;
    StepMemory<float> memory;
  };
  const Shared in = inputs(path);
  const auto with = [in](Step<float>* step) { return [in, step](State& s) { step(in->settings, s.world, s.memory); }; };
  const double n = in->world.bodies.count;
  return bitwise_case<State>({in->world, in->last}, with(serial), with(openmp),
                             [](const State& s) { return both(words_of(s.world.bodies), words_of(s.memory.impulses, s.memory.manifolds)); },
                             {n, "bodies", n * 6 * bytes_of_pose, 75 * rows_of(*in)});
}

// The same contacts solved in another order: how many sweeps leave no more of the residual than ten of the original order do.
Case convergence_case(const std::string& path) {
  struct State {
    Shared in;
    Solved start;
    World<float> before;
    double target = 0, left = 0;
    int sweeps = 0;
  };
  auto s = std::make_shared<State>(State{inputs(path), {}, {}, 0, 0, 0});
  s->start = solver_start(*s->in);
  s->before = s->in->world;
  s->before.bodies = s->start.bodies;
  for (Impulses<float>& impulses : s->start.impulses) impulses = {};  // from nothing: a warm start has little left to find
  constexpr int original_sweeps = 10, most_sweeps = 10 * original_sweeps;
  const auto residual_after = [s](int sweeps, bool reordered, bool in_parallel) {
    Solved solved = s->start;
    SolverSettings settings = s->in->settings.solver;
    settings.substeps = 1, settings.pushing = 0, settings.resting = sweeps;
    const auto& [manifolds, batches] = std::tie(s->in->now.manifolds, s->in->now.batches);
    if (!reordered)
      serial::solve_contacts_original(settings, manifolds, s->in->body(), solved.bodies, solved.impulses, solved.moving);
    else if (in_parallel)
      openmp::solve_contacts_batches(settings, manifolds, s->in->body(), batches, solved.bodies, solved.impulses, solved.moving);
    else
      serial::solve_contacts_batches(settings, manifolds, s->in->body(), batches, solved.bodies, solved.impulses, solved.moving);
    return residual(settings, manifolds, s->in->body(), s->before, solved.impulses);
  };
  s->target = residual_after(original_sweeps, false, false);
  for (s->sweeps = 1; s->sweeps < most_sweeps && residual_after(s->sweeps, true, true) > s->target; ++s->sweeps) {
  }
  const double n = static_cast<double>(s->in->now.manifolds.size());
  return {
      .reset = [] {},
      .serial = [residual_after] { residual_after(original_sweeps, false, false); },
      .best_serial = nullptr,
      .openmp = [s, residual_after] { s->left = residual_after(s->sweeps, true, true); },
      .judge =
          [s] {
            char text[120];
            std::snprintf(text, sizeof text, "%d sweeps in batches for %d in the original order: %.2f times", s->sweeps, original_sweeps,
                          double(s->sweeps) / original_sweeps);
            return Judgement{
                .verdict = Verdict::converged, .passed = s->left <= s->target, .error = s->left, .bound = s->target, .worst_at = text};
          },
      .hash = [s] { return std::bit_cast<std::uint64_t>(s->left); },
      .work = {n, "contacts", n * bytes_of_manifold, 0},
  };
}

// A whole run from the scene's start. Steps have the serial bits, so the run cannot leave the serial one; what is asked besides is that
// every number is finite, that momentum changes by what gravity and static bodies give, and no more than rounding allows, and that the
// energy is as near to the serial run's as the serial run is to itself after a change of one ulp.
Case run_case(const std::string& path, Step<float>* serial, Step<float>* openmp) {
  struct State {
    Scene scene;
    int steps;
    RigidRun expected, found;
    std::vector<double> energy_forgotten;  // J, [step]
  };
  constexpr double body_steps = 3e5;  // how long a run is: long enough for bodies to meet, short enough to wait for
  auto s = std::make_shared<State>(State{load_scene(path), 0, {}, {}, {}});
  s->steps = std::clamp(static_cast<int>(body_steps / s->scene.world.bodies.count), 5, 200);
  s->expected = run_rigid(s->scene, serial, s->steps);
  s->energy_forgotten = energy_forgotten(s->scene, serial, s->expected);
  const double n = static_cast<double>(s->scene.world.bodies.count) * s->steps;
  return {
      .reset = [] {},
      .serial = [s, serial] { run_rigid(s->scene, serial, s->steps); },
      .best_serial = nullptr,
      .openmp = [s, openmp] { s->found = run_rigid(s->scene, openmp, s->steps); },
      .judge =
          [s] {
            Judgement judgement{.verdict = Verdict::physical, .bound = 1, .worst_at = ""};
            for (std::size_t f = 0; f < s->found.frames.size(); ++f) {
              const RigidRun::Frame& frame = s->found.frames[f];
              const std::string at = " after step " + std::to_string(f + 1);
              const auto fail = [&](const std::string& what) {
                if (judgement.passed) judgement.worst_at = what + at;
                judgement.passed = false;
              };
              if (!std::ranges::all_of(frame.state, [](float x) { return std::isfinite(x); })) fail("a number is not finite");
              if (!std::ranges::equal(frame.state, s->expected.frames[f].state)) fail("another state than the serial run's");
              if (!(frame.momentum_error <= 1)) fail("momentum is off by more than rounding");
              const double energies = std::abs(frame.energy - s->expected.frames[f].energy), forgotten = s->energy_forgotten[f];
              if (!(energies <= forgotten)) fail("energy is farther from the serial run's than that is from itself");
              if (judgement.passed && frame.momentum_error >= judgement.error) {
                char text[160];
                std::snprintf(text, sizeof text, "momentum%s; deepest %.2g mm; energy %.6g J, off by %.2g of %.2g", at.c_str(),
                              1e3 * frame.deepest, frame.energy, energies, forgotten);
                judgement.error = frame.momentum_error, judgement.worst_at = text;
              }
            }
            return judgement;
          },
      .hash = [s] { return hash_bytes(std::span<const float>(s->found.frames.back().state)); },
      .work = {n, "body-steps", n * 6 * bytes_of_pose, 0},
  };
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
  const Scenes many = {"castle", "boxes_100k"}, of_boxes = {"box_pit_4000", "pyramid_24"}, of_hulls = {"hull_pit_2000", "hull_soup"};
  const Scenes settled = {"pyramid_24", "box_pit_4000", "hull_pit_2000"},
               and_castle = {"pyramid_24", "box_pit_4000", "hull_pit_2000", "castle_hit"};

  add("rigid/place_colliders", "", all, more, many, place_case);
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
  add("rigid/match_contacts", "", all, more, settled, match_case);
  add("rigid/batches", "", all, more, settled, [](const std::string& path) { return batches_case(path, openmp::reorder_contacts); });
  add("rigid/batches", "parallel", all, more, settled,
      [](const std::string& path) { return batches_case(path, openmp::reorder_contacts_parallel); });
  add("rigid/contact_solver", "original", all, more, settled, [](const std::string& path) { return solver_case(path, false); });
  add("rigid/contact_solver", "batches", all, more, and_castle, [](const std::string& path) { return solver_case(path, true); });
  add("rigid/contact_solver", "batches_for_original", {"four_bodies", "castle"}, {"pyramid_24", "box_pit_4000", "hull_pit_2000"}, {},
      convergence_case);
  add("rigid/integrate", "", all, more, many, advance_case);
  add("rigid/step", "original", all, more, settled,
      [](const std::string& path) { return step_case(path, serial::step_original, openmp::step_original); });
  add("rigid/step", "batches", all, more, and_castle,
      [](const std::string& path) { return step_case(path, serial::step_batches, openmp::step_batches); });
  add("rigid/step", "batches_run", {"four_bodies", "degenerate", "assorted", "soup_10", "castle_hit"}, more, {},
      [](const std::string& path) { return run_case(path, serial::step_batches, openmp::step_batches); });
  return kernels;
}

}  // namespace lockstep::verify
