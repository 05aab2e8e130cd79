// Contract: the broad phase, three times. Each finds exactly the same pairs (common/rigid/pairs.h), in the same order.
//
//   sweep_and_prune_batch        sorts the lower ends of the boxes along the axis on which their centres have the
//                                greatest variance (the first of equals), and sweeps each box on to where the lower
//                                ends pass its upper end. The papers' algorithm; openmp sorts in parallel and sweeps
//                                each box on its own, sixteen candidates at once.
//   sweep_and_prune_incremental  the same from the order of the step before, mended by insertion: the best serial one
//                                where little moves.
//   bvh_build, bvh_refit         make a tree of boxes from nothing, or fit it to moved boxes (common/spatial/tree.h).
//   bvh_pairs                    descends a tree by pairs of nodes: every pair that overlaps gives rise to more.
//   grid                         a uniform grid, hashed. Its cells are as large as the largest of the boxes of like
//                                size; the few that are larger are kept apart and tested against all.
//
// In: bounds; group[collider] (common/rigid/world.h). A box is bounded if its low.x is not -infinity; lower ends of
// bounded boxes are finite, upper ends may be infinite, and no end is NaN. For bvh_pairs, tree has the boxes of
// `bounds`. Out: pairs, emptied first. In, out: the state that sweep and prune carries from step to step, owned by the
// caller; any state gives the same pairs. Errors: InputError if a step with so many pairs may not fit the memory
// (common/rigid/limits.h), std::bad_alloc. Source: [LRB08] Figure 5 and "Collision Detection" for sweep and prune;
// [ITJ07] on "computation that spawns more computation" for the tree.
#pragma once

#include "common/rigid/pairs.h"
#include "common/rigid/place_colliders.h"
#include "common/spatial/tree.h"

namespace lockstep::rigid {

using spatial::Tree;

// The colliders in the order of their lower ends along an axis.
struct SweepOrder {
  int axis = 0;
  std::vector<std::int32_t> order;
};

template <class Real>
using SweepAndPrune = void(const Bounds<Real>& bounds, std::span<const std::int32_t> group, SweepOrder& state,
                           Pairs& pairs);
template <class Real>
using BvhPairs = void(const Tree<Real>& tree, const Bounds<Real>& bounds, std::span<const std::int32_t> group,
                      Pairs& pairs);
template <class Real>
using GridPairs = void(const Bounds<Real>& bounds, std::span<const std::int32_t> group, Pairs& pairs);

// Contract: every plane with every collider of another group whose box reaches below it (or touches it), in the order
// of common/rigid/pairs.h. placed[collider] as place_colliders leaves it; a plane's local y axis is its normal.
template <class Real>
using PlanePairs = void(const Colliders<Real>& colliders, std::span<const Pose<Real>> placed,
                        const Bounds<Real>& bounds, Pairs& pairs);

namespace serial {
SweepAndPrune<float> sweep_and_prune_batch, sweep_and_prune_incremental;
SweepAndPrune<double> sweep_and_prune_batch, sweep_and_prune_incremental;
using spatial::serial::bvh_build, spatial::serial::bvh_refit;
BvhPairs<float> bvh_pairs;
BvhPairs<double> bvh_pairs;
GridPairs<float> grid;
GridPairs<double> grid;
PlanePairs<float> plane_pairs;
PlanePairs<double> plane_pairs;
}  // namespace serial

namespace openmp {
SweepAndPrune<float> sweep_and_prune_batch;
using spatial::openmp::bvh_build, spatial::openmp::bvh_refit;
BvhPairs<float> bvh_pairs;
GridPairs<float> grid;
PlanePairs<float> plane_pairs;
}  // namespace openmp

}  // namespace lockstep::rigid
