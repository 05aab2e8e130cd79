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
// Threads take contiguous shares of the pairs, count, learn from the counts of the shares before theirs where to write,
// and write: the order is the serial one however many shares there are. Kernels are parallel themselves and run one
// after another.
//
// The contract stands in common/rigid/narrow_phase.h.
#include "common/rigid/narrow_phase.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>
#include <utility>

#include "common/real.h"
#include "common/rigid/route.h"
#include "openmp/failure.h"
#include "openmp/share.h"

namespace lockstep::rigid::openmp {
namespace {

using namespace lockstep::openmp;

int bin_of_pair(const Colliders<Real>& colliders, const Pair& pair) {
  return bin_of(static_cast<Kind>(colliders.kind[pair.a]), static_cast<Kind>(colliders.kind[pair.b]));
}

// One thread's, in cache lines of its own.
struct alignas(array_alignment) Counts {
  std::array<int, bins + 1> of = {};
};

// Not filled with zeros first: kernels write every element.
template <class Element>
struct Unwritten {
  std::unique_ptr<Element[]> memory;
  std::span<Element> span;
  explicit Unwritten(std::size_t n) : memory(std::make_unique_for_overwrite<Element[]>(n)), span(memory.get(), n) {}
};

// Of each pair, its simplex of the last step.
std::vector<Simplex> matching_simplices(std::span<const Pair> pairs, const NarrowPhaseState& last) {
  std::vector<Simplex> simplex(pairs.size());
#pragma omp parallel
  {
    // A thread writes its own share, and begins in the other list where its share does.
    const Share mine = my_share(static_cast<int>(pairs.size()));
    std::size_t other = 0;
    if (mine.begin < mine.end)
      other = std::lower_bound(last.pairs.begin(), last.pairs.end(), pairs[mine.begin]) - last.pairs.begin();
    for (int k = mine.begin; k < mine.end; ++k) {
      while (other < last.pairs.size() && last.pairs[other] < pairs[k]) ++other;
      if (other < last.pairs.size() && last.pairs[other] == pairs[k]) simplex[k] = last.simplex[other];
    }
  }
  return simplex;
}

}  // namespace

void narrow_phase(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin, NarrowPhaseState& state,
                  Array<Manifold<Real>>& manifolds) {
  const int count = static_cast<int>(pairs.size());
  std::array<int, bins + 1> first = {};
  Pairs sorted(pairs.size());
  std::vector<int> place(pairs.size());
  std::vector<Counts> counts(omp_get_max_threads());
#pragma omp parallel
  {
    // A thread counts its own share, and writes where no other does: in each bin, behind the shares before its own.
    const Share mine = my_share(count);
    std::array<int, bins + 1>& next = counts[omp_get_thread_num()].of;
    for (int k = mine.begin; k < mine.end; ++k) ++next[bin_of_pair(placed.colliders, pairs[k])];
#pragma omp barrier
      // One thread turns counts into places, and the others wait at the barrier that ends `single`.
#pragma omp single
    for (int bin = 0, sum = 0; bin < bins; ++bin) {
      for (Counts& each : counts) sum += std::exchange(each.of[bin], sum);
      first[bin + 1] = sum;
    }
    for (int k = mine.begin; k < mine.end; ++k) {
      place[k] = next[bin_of_pair(placed.colliders, pairs[k])]++;
      sorted[place[k]] = pairs[k];
    }
  }

  const Unwritten<Manifold<Real>> of_pairs(pairs.size());
  const std::span<Manifold<Real>> found = of_pairs.span;
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
  const Unwritten<Closest<Real>> closest(convex_pairs.size());
  const Unwritten<SeparatingAxis<Real>> axes(convex_pairs.size());
  gjk(placed, convex_pairs, simplex, closest.span);
  convex_axes(placed, convex_pairs, simplex, closest.span, margin, axes.span);
  convex_clip(placed, convex_pairs, axes.span, margin, part(found, first_of_convexes, bins));
  state.pairs.assign(convex_pairs.begin(), convex_pairs.end());
  state.simplex = std::move(simplex);

  Failure failure;
#pragma omp parallel
  {
    // As above: a thread's manifolds stand behind those of the shares before its own.
    const Share mine = my_share(count);
    int& next = counts[omp_get_thread_num()].of[0];
    next = 0;
    for (int k = mine.begin; k < mine.end; ++k) next += found[place[k]].count > 0;
#pragma omp barrier
      // One thread allocates, and the others wait at the barrier that ends `single`. If that fails, no thread writes.
#pragma omp single
    failure.guard([&] {
      int sum = 0;
      for (int thread = 0; thread < omp_get_num_threads(); ++thread) sum += std::exchange(counts[thread].of[0], sum);
      manifolds.resize(sum);
    });
    if (!failure.happened())
      for (int k = mine.begin; k < mine.end; ++k)
        if (found[place[k]].count > 0) manifolds[next++] = found[place[k]];
  }
  failure.rethrow();
}

}  // namespace lockstep::rigid::openmp
