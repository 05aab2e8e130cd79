// The narrow phase: gives every pair to the kernel for its kinds, and collects the manifolds in the order of the pairs.
//
// A stable counting sort puts pairs into bins by kinds, so that a kernel has its pairs side by side, and pairs with the
// same formula together: sixteen pairs in lanes take the same one ([LRB08] Figure 10 shows the cost where they do not).
// Each pair keeps the place of its manifold; at the end the manifolds that have points are collected in the order of
// the pairs.
//
// Warm start: GJK starts a pair from its last step's simplex. The pairs of both steps are sorted, and matched as in a
// merge. A new pair starts cold, and so does one whose contact was kept in the last step.
//
// narrow_phase_kept looks for each pair with hulls among those of the last step. Where the two have hardly moved, their
// contact is refreshed. The other pairs are fresh: the kernels find their contacts, which are kept for the next step.
//
// The contract stands in common/rigid/narrow_phase.h.
#include "common/rigid/narrow_phase.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "common/real.h"
#include "common/rigid/route.h"

namespace lockstep::rigid::serial {
namespace {

// Calls known(k, other) for every pair k that is pair `other` of the last step.
template <class Known>
void match(std::span<const Pair> pairs, std::span<const Pair> last, const Known& known) {
  std::size_t other = 0;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    while (other < last.size() && last[other] < pairs[k]) ++other;
    if (other < last.size() && last[other] == pairs[k]) known(k, other);
  }
}

SortedPairs sort_by_kinds(const Placed<Real>& placed, std::span<const Pair> pairs) {
  SortedPairs sorted = {Pairs(pairs.size()), std::vector<int>(pairs.size()), {}};
  auto& [to, place, first] = sorted;
  for (const Pair& pair : pairs) ++first[bin_of_pair(placed.colliders, pair) + 1];
  for (int bin = 0; bin < bins; ++bin) first[bin + 1] += first[bin];
  std::array<int, bins + 1> next = first;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    place[k] = next[bin_of_pair(placed.colliders, pairs[k])]++;
    to[place[k]] = pairs[k];
  }
  return sorted;
}

// The manifolds of sorted pairs without hulls, each by the kernel for its kinds.
void collide_simple(const Placed<Real>& placed, const SortedPairs& sorted, Real margin,
                    std::span<Manifold<Real>> found) {
  const auto run = [&](Collide<Real>& kernel, int from, int to) {
    const int first = sorted.first[from], count = sorted.first[to] - first;
    kernel(placed, std::span(sorted.pairs).subspan(first, count), margin, found.subspan(first, count));
  };
  run(spheres, first_of_spheres, first_of_planes);
  run(planes, first_of_planes, first_of_box_box);
  run(box_box, first_of_box_box, first_of_convexes);
}

// The manifolds of pairs with hulls.
void collide_convexes(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin, NarrowPhaseState& state,
                      std::span<Manifold<Real>> found) {
  std::vector<Simplex> simplex(pairs.size());
  match(pairs, state.pairs, [&](std::size_t k, std::size_t other) { simplex[k] = state.simplex[other]; });
  std::vector<Closest<Real>> closest(pairs.size());
  std::vector<SeparatingAxis<Real>> axes(pairs.size());
  gjk(placed, pairs, simplex, closest);
  convex_axes(placed, pairs, simplex, closest, margin, axes);
  convex_clip(placed, pairs, axes, margin, found);
  state.pairs.assign(pairs.begin(), pairs.end());
  state.simplex = std::move(simplex);
}

// Those that have points, in the order of the pairs before they were sorted.
void collect(std::span<const int> place, std::span<const Manifold<Real>> found, Array<Manifold<Real>>& manifolds) {
  manifolds.clear();
  for (const int k : place)
    if (found[k].count > 0) manifolds.push_back(found[k]);
}

}  // namespace

void narrow_phase(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin, NarrowPhaseState& state,
                  Array<Manifold<Real>>& manifolds) {
  const SortedPairs sorted = sort_by_kinds(placed, pairs);
  std::vector<Manifold<Real>> found(pairs.size());
  collide_simple(placed, sorted, margin, found);
  const int simple = sorted.first[first_of_convexes];
  collide_convexes(placed, std::span(sorted.pairs).subspan(simple), margin, state, std::span(found).subspan(simple));
  collect(sorted.place, found, manifolds);
}

void narrow_phase_kept(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin, NarrowPhaseState& state,
                       KeptContacts<Real>& kept, Array<Manifold<Real>>& manifolds) {
  const SortedPairs sorted = sort_by_kinds(placed, pairs);
  std::vector<Manifold<Real>> found(pairs.size());
  collide_simple(placed, sorted, margin, found);

  const int simple = sorted.first[first_of_convexes];
  const std::span<const Pair> convexes = std::span(sorted.pairs).subspan(simple);
  const std::span<Manifold<Real>> of_convexes = std::span(found).subspan(simple);
  std::vector<std::int32_t> of_last(convexes.size(), -1);
  match(convexes, kept.pairs, [&](std::size_t k, std::size_t other) { of_last[k] = other; });
  kept.next.resize(convexes.size());
  refresh_contacts(placed, convexes, kept.contact, static_cast<Real>(kept_share) * margin, of_last, of_convexes,
                   kept.next);

  std::vector<std::int32_t> fresh;
  Pairs fresh_pairs;
  for (int k = 0; k < static_cast<int>(convexes.size()); ++k)
    if (of_last[k] < 0) fresh.push_back(k), fresh_pairs.push_back(convexes[k]);
  std::vector<Manifold<Real>> of_fresh(fresh.size());
  collide_convexes(placed, fresh_pairs, margin, state, of_fresh);
  for (std::size_t j = 0; j < fresh.size(); ++j) of_convexes[fresh[j]] = of_fresh[j];
  keep_contacts(placed, fresh_pairs, fresh, of_convexes, kept.next);
  kept.pairs.assign(convexes.begin(), convexes.end());
  kept.contact.swap(kept.next);
  collect(sorted.place, found, manifolds);
}

}  // namespace lockstep::rigid::serial
