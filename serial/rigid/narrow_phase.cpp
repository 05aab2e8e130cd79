// The narrow phase: gives every pair to the kernel for its kinds, and collects the manifolds in the order of the pairs.
//
// A stable counting sort puts pairs into bins by kinds, so that a kernel has its pairs side by side, and pairs with the
// same formula together: sixteen pairs in lanes take the same one ([LRB08] Figure 10 shows the cost where they do not).
// Each pair keeps the place of its manifold; at the end the manifolds that have points are collected in the order of
// the pairs.
//
// Warm start: GJK starts a pair from its last step's simplex. The pairs of both steps are sorted, and matched as in a
// merge; a new pair starts cold.
//
// The contract stands in common/rigid/narrow_phase.h.
#include "common/rigid/narrow_phase.h"

#include <array>
#include <cstddef>
#include <utility>

#include "common/real.h"
#include "common/rigid/route.h"

namespace lockstep::rigid::serial {
namespace {

int bin_of_pair(const Colliders<Real>& colliders, const Pair& pair) {
  return bin_of(static_cast<Kind>(colliders.kind[pair.a]), static_cast<Kind>(colliders.kind[pair.b]));
}

// Of each pair, its simplex of the last step.
std::vector<Simplex> matching_simplices(std::span<const Pair> pairs, const NarrowPhaseState& last) {
  std::vector<Simplex> simplex(pairs.size());
  std::size_t other = 0;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    while (other < last.pairs.size() && last.pairs[other] < pairs[k]) ++other;
    if (other < last.pairs.size() && last.pairs[other] == pairs[k]) simplex[k] = last.simplex[other];
  }
  return simplex;
}

}  // namespace

void narrow_phase(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin, NarrowPhaseState& state,
                  Array<Manifold<Real>>& manifolds) {
  std::array<int, bins + 1> first = {};
  for (const Pair& pair : pairs) ++first[bin_of_pair(placed.colliders, pair) + 1];
  for (int bin = 0; bin < bins; ++bin) first[bin + 1] += first[bin];

  Pairs sorted(pairs.size());
  std::vector<int> place(pairs.size());
  std::array<int, bins + 1> next = first;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    place[k] = next[bin_of_pair(placed.colliders, pairs[k])]++;
    sorted[place[k]] = pairs[k];
  }

  std::vector<Manifold<Real>> found(pairs.size());
  const auto part = [&](auto& of, int from, int to) {
    return std::span(of).subspan(first[from], first[to] - first[from]);
  };
  const auto run = [&](Collide<Real>& kernel, int from, int to) {
    kernel(placed, part(sorted, from, to), margin, part(found, from, to));
  };
  run(spheres, first_of_spheres, first_of_planes);
  run(planes, first_of_planes, first_of_box_box);
  run(box_box, first_of_box_box, first_of_convexes);
  const std::span<const Pair> convex_pairs = part(sorted, first_of_convexes, bins);
  std::vector<Simplex> simplex = matching_simplices(convex_pairs, state);
  std::vector<Closest<Real>> closest(convex_pairs.size());
  std::vector<SeparatingAxis<Real>> axes(convex_pairs.size());
  gjk(placed, convex_pairs, simplex, closest);
  convex_axes(placed, convex_pairs, simplex, closest, margin, axes);
  convex_clip(placed, convex_pairs, axes, margin, part(found, first_of_convexes, bins));
  state.pairs.assign(convex_pairs.begin(), convex_pairs.end());
  state.simplex = std::move(simplex);

  manifolds.clear();
  for (const int k : place)
    if (found[k].count > 0) manifolds.push_back(found[k]);
}

}  // namespace lockstep::rigid::serial
