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
// contact is refreshed, sixteen pairs at a time. The other pairs are fresh: the kernels find their contacts, which are
// kept for the next step.
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
#include <vector>

#include "common/real.h"
#include "common/rigid/route.h"
#include "openmp/failure.h"
#include "openmp/share.h"

namespace lockstep::rigid::openmp {
namespace {

using namespace lockstep::openmp;

// Calls known(k, other) for every pair k that is pair `other` of the last step. known writes what belongs to pair k.
template <class Known>
void match(std::span<const Pair> pairs, std::span<const Pair> last, const Known& known) {
#pragma omp parallel
  {
    // A thread has its own share of the pairs, and begins in the other list where its share does.
    const Share mine = my_share(static_cast<int>(pairs.size()));
    std::size_t other = 0;
    if (mine.begin < mine.end) other = std::ranges::lower_bound(last, pairs[mine.begin]) - last.begin();
    for (int k = mine.begin; k < mine.end; ++k) {
      while (other < last.size() && last[other] < pairs[k]) ++other;
      if (other < last.size() && last[other] == pairs[k]) known(k, other);
    }
  }
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

SortedPairs sort_by_kinds(const Placed<Real>& placed, std::span<const Pair> pairs) {
  SortedPairs sorted = {Pairs(pairs.size()), std::vector<int>(pairs.size()), {}};
  std::vector<Counts> counts(omp_get_max_threads());
#pragma omp parallel
  {
    // A thread counts its own share, and writes where no other does: in each bin, behind the shares before its own.
    const Share mine = my_share(static_cast<int>(pairs.size()));
    std::array<int, bins + 1>& next = counts[omp_get_thread_num()].of;
    for (int k = mine.begin; k < mine.end; ++k) ++next[bin_of_pair(placed.colliders, pairs[k])];
#pragma omp barrier
      // One thread turns counts into places, and the others wait at the barrier that ends `single`.
#pragma omp single
    for (int bin = 0, sum = 0; bin < bins; ++bin) {
      for (Counts& each : counts) sum += std::exchange(each.of[bin], sum);
      sorted.first[bin + 1] = sum;
    }
    for (int k = mine.begin; k < mine.end; ++k) {
      sorted.place[k] = next[bin_of_pair(placed.colliders, pairs[k])]++;
      sorted.pairs[sorted.place[k]] = pairs[k];
    }
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
  const Unwritten<Closest<Real>> closest(pairs.size());
  const Unwritten<SeparatingAxis<Real>> axes(pairs.size());
  gjk(placed, pairs, simplex, closest.span);
  convex_axes(placed, pairs, simplex, closest.span, margin, axes.span);
  convex_clip(placed, pairs, axes.span, margin, found);
  state.pairs.assign(pairs.begin(), pairs.end());
  state.simplex = std::move(simplex);
}

// Calls put(k, j) for the j-th k < n that is wanted, in any order, after resize(number of those).
template <class Wanted, class Resize, class Put>
void compact(int n, const Wanted& wanted, const Resize& resize, const Put& put) {
  std::vector<Counts> counts(omp_get_max_threads());
  Failure failure;
#pragma omp parallel
  {
    // What a thread puts stands behind that of the shares before its own.
    const Share mine = my_share(n);
    int& next = counts[omp_get_thread_num()].of[0];
    for (int k = mine.begin; k < mine.end; ++k) next += wanted(k);
#pragma omp barrier
      // One thread allocates, and the others wait at the barrier that ends `single`. If that fails, no thread writes.
#pragma omp single
    failure.guard([&] {
      int sum = 0;
      for (Counts& each : counts) sum += std::exchange(each.of[0], sum);
      resize(sum);
    });
    if (!failure.happened())
      for (int k = mine.begin; k < mine.end; ++k)
        if (wanted(k)) put(k, next++);
  }
  failure.rethrow();
}

// Those that have points, in the order of the pairs before they were sorted.
void collect(std::span<const int> place, std::span<const Manifold<Real>> found, Array<Manifold<Real>>& manifolds) {
  compact(
      static_cast<int>(place.size()), [&](int k) { return found[place[k]].count > 0; },
      [&](int number) { manifolds.resize(number); }, [&](int k, int j) { manifolds[j] = found[place[k]]; });
}

}  // namespace

void narrow_phase(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin, NarrowPhaseState& state,
                  Array<Manifold<Real>>& manifolds) {
  const SortedPairs sorted = sort_by_kinds(placed, pairs);
  const Unwritten<Manifold<Real>> found(pairs.size());
  collide_simple(placed, sorted, margin, found.span);
  const int simple = sorted.first[first_of_convexes];
  collide_convexes(placed, std::span(sorted.pairs).subspan(simple), margin, state, found.span.subspan(simple));
  collect(sorted.place, found.span, manifolds);
}

void narrow_phase_kept(const Placed<Real>& placed, std::span<const Pair> pairs, Real margin, NarrowPhaseState& state,
                       KeptContacts<Real>& kept, Array<Manifold<Real>>& manifolds) {
  const SortedPairs sorted = sort_by_kinds(placed, pairs);
  const Unwritten<Manifold<Real>> found(pairs.size());
  collide_simple(placed, sorted, margin, found.span);

  const int simple = sorted.first[first_of_convexes];
  const std::span<const Pair> convexes = std::span(sorted.pairs).subspan(simple);
  const std::span<Manifold<Real>> of_convexes = found.span.subspan(simple);
  std::vector<std::int32_t> of_last(convexes.size(), -1);
  match(convexes, kept.pairs, [&](std::size_t k, std::size_t other) { of_last[k] = other; });
  kept.next.resize(convexes.size());
  refresh_contacts(placed, convexes, kept.contact, static_cast<Real>(kept_share) * margin, of_last, of_convexes,
                   kept.next);

  std::vector<std::int32_t> fresh;
  Pairs fresh_pairs;
  compact(
      static_cast<int>(convexes.size()), [&](int k) { return of_last[k] < 0; },
      [&](int number) { fresh.resize(number), fresh_pairs.resize(number); },
      [&](int k, int j) { fresh[j] = k, fresh_pairs[j] = convexes[k]; });
  const Unwritten<Manifold<Real>> of_fresh(fresh.size());
  collide_convexes(placed, fresh_pairs, margin, state, of_fresh.span);
  // Each fresh pair has one thread, which writes the pair's manifold.
#pragma omp parallel for schedule(static)
  for (std::size_t j = 0; j < fresh.size(); ++j) of_convexes[fresh[j]] = of_fresh.span[j];
  keep_contacts(placed, fresh_pairs, fresh, of_convexes, kept.next);
  kept.pairs.assign(convexes.begin(), convexes.end());
  kept.contact.swap(kept.next);
  collect(sorted.place, found.span, manifolds);
}

}  // namespace lockstep::rigid::openmp
