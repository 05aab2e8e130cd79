// The inputs and outputs of the narrow phase's kernels, for the verifier and the benchmark.
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/rigid/narrow_phase.h"
#include "common/rigid/route.h"
#include "verify/rigid/inputs.h"
#include "verify/twin.h"

namespace lockstep::rigid {

template <Is<SeparatingAxis> A, class F>
void for_each_field(A& axis, const F& f) {
  f("normal.x", axis.normal.x), f("normal.y", axis.normal.y), f("normal.z", axis.normal.z);
  f("separation", axis.separation);
  f("middle.x", axis.middle.x), f("middle.y", axis.middle.y), f("middle.z", axis.middle.z);
  f("cosine_a", axis.cosine_a), f("cosine_b", axis.cosine_b), f("face_a", axis.face_a), f("face_b", axis.face_b);
}

}  // namespace lockstep::rigid

namespace lockstep::verify::rigid_inputs {

using SharedPairs = std::shared_ptr<const rigid::Pairs>;

// The pairs of bins `from` .. `to` - 1 (common/rigid/route.h), sorted by bin, as the narrow phase hands them to a
// kernel.
inline SharedPairs pairs_of_bins(const Inputs& in, int from, int to) {
  rigid::Pairs pairs;
  for (int bin = from; bin < to; ++bin)
    for (const rigid::Pair& pair : in.now.pairs)
      if (rigid::bin_of_pair(in.world.colliders, pair) == bin) pairs.push_back(pair);
  return std::make_shared<const rigid::Pairs>(std::move(pairs));
}
inline SharedPairs convex_pairs(const Inputs& in) { return pairs_of_bins(in, rigid::first_of_convexes, rigid::bins); }

// A kernel's output, one record per pair. It is padded, because kernels write whole vectors.
template <class Record>
struct PerPair {
  std::size_t count;
  Array<Record> record;

  std::span<Record> span() { return {record.data(), count}; }
};
template <class P, class F>
requires requires(P p) { p.record; }
void for_each_array(P& p, const F& f) { f("pair", p.record, p.count); }
template <class Record>
std::shared_ptr<const PerPair<Record>> poisoned(std::size_t count) {
  PerPair<Record> result{count, Array<Record>(padded(count))};
  poison(result);
  return std::make_shared<const PerPair<Record>>(std::move(result));
}
using Manifolds = PerPair<rigid::Manifold<float>>;

// A kernel whose input is pairs of its bins and a margin.
inline Case collide_case(const std::string& path, int from, int to, rigid::Collide<float>* serial,
                         rigid::Collide<float>* openmp, double flops,
                         double (*lane_use)(std::span<const rigid::Manifold<float>>) = nullptr) {
  const auto in = inputs(path);
  const SharedPairs pairs = pairs_of_bins(*in, from, to);
  const auto with = [=](rigid::Collide<float>* collide) {
    return [=](Manifolds& m) { collide(in->placed(), *pairs, in->margin(), m.span()); };
  };
  const double n = static_cast<double>(pairs->size());
  Work work = {n, "pairs", n * (2 * bytes_of_pose + bytes_of_manifold), n * flops};
  if (lane_use) {
    Manifolds there{pairs->size(), Array<rigid::Manifold<float>>(padded(pairs->size()))};
    with(serial)(there);
    work.lane_use = lane_use(there.span());
  }
  return make_case<Manifolds>({
      .start = poisoned<rigid::Manifold<float>>(pairs->size()),
      .serial = with(serial),
      .best_serial = nullptr,
      .openmp = with(openmp),
      .compare = nullptr,
      .work = work,
  });
}

// GJK's results for pairs. It starts from the simplices of the step before, or from none.
struct Distances {
  std::vector<rigid::Simplex> simplex;
  PerPair<rigid::Closest<float>> closest;
};
template <Same<Distances> D, class F>
void for_each_array(D& d, const F& f) {
  f("simplex", d.simplex, d.simplex.size()), f("closest", d.closest.record, d.closest.count);
}
inline Distances not_yet_known(const Inputs& in, const rigid::Pairs& pairs, bool warm) {
  Distances result{std::vector<rigid::Simplex>(pairs.size(), rigid::Simplex{}),
                   *poisoned<rigid::Closest<float>>(pairs.size())};
  const auto& [known, simplex] = in.last.narrow_phase;
  for (std::size_t k = 0; warm && k < pairs.size(); ++k) {
    const auto at = std::ranges::lower_bound(known, pairs[k]);
    if (at != known.end() && *at == pairs[k]) result.simplex[k] = simplex[at - known.begin()];
  }
  return result;
}
inline Distances serial_distances(const Inputs& in, const rigid::Pairs& pairs, bool warm) {
  Distances result = not_yet_known(in, pairs, warm);
  rigid::serial::gjk(in.placed(), pairs, result.simplex, result.closest.span());
  return result;
}

// Scenes with hulls, and the scenes of a kernel that not all scenes suit.
inline Scenes some_scenes(std::vector<std::string> verify, std::vector<std::string> bench,
                          std::vector<std::string> tsan) {
  Scenes scenes = scenes_of_all(std::move(bench), std::move(tsan));
  scenes.verify = std::move(verify);
  return scenes;
}
inline Scenes hull_scenes() {
  return some_scenes({"degenerate", "soup_10", "mesh_and_hulls"}, of_hulls, {"hull_pit_2000"});
}

}  // namespace lockstep::verify::rigid_inputs
