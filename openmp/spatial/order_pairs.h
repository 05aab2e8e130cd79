// Puts the pairs of threads' lists in order, in parallel. In sequence: common/spatial/order_pairs.h.
//
// Two steps. The threads part the pairs by the highest bits of a, with one counting sort. A part, of some thousand
// pairs, then fits the first-level cache and is one thread's: a counting sort by the rest of a, and then the few pairs
// of each a by b. There, the place of a pair is how many b are less than its own, which lanes count sixteen at a time.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "common/array.h"
#include "common/counting_sort.h"
#include "common/simd.h"
#include "common/spatial/pairs.h"
#include "openmp/counting_sort.h"
#include "openmp/failure.h"
#include "openmp/spatial/pair_list.h"
#include "openmp/spatial/workspace.h"

namespace lockstep::spatial::openmp {

// Puts the n pairs of one a in order. Sixteen may be read from every element of b on.
inline void order_by_b(std::int32_t a, std::int32_t* b, int n, Pair* ordered) {
  if (n <= lanes) {
    const intv others = select(first_lanes(n), load(b), INT32_MAX);
    for (int i = 0; i < n; ++i) ordered[count(others < b[i])] = {a, b[i]};
  } else if (n <= 2 * lanes) {
    const intv others = load(b), more = select(first_lanes(n - lanes), load(b + lanes), INT32_MAX);
    for (int i = 0; i < n; ++i) ordered[count(others < b[i]) + count(more < b[i])] = {a, b[i]};
  } else {
    std::sort(b, b + n);
    for (int i = 0; i < n; ++i) ordered[i] = {a, b[i]};
  }
}

// Puts n pairs with first_a <= a < first_a + as in order. Scratch, grown as need be: begin, b.
inline void order_part(std::int32_t first_a, int as, const Pair* pairs, int n, std::vector<std::int32_t>& begin,
                       Array<std::int32_t>& b, Pair* ordered) {
  if (b.size() < padded(n)) b.resize(2 * padded(n));
  stable_counting_sort(
      as,
      [=](const auto& visit) {
        for (int k = 0; k < n; ++k) visit(pairs[k].b, pairs[k].a - first_a);
      },
      [&b](std::int32_t other, int place) { b[place] = other; }, begin);
  for (int a = 0; a < as; ++a)
    if (begin[a] < begin[a + 1]) order_by_b(first_a + a, &b[begin[a]], begin[a + 1] - begin[a], ordered + begin[a]);
}

// Calls visit(pair) for pairs begin .. end - 1 of all lists.
template <class Visit>
void for_each_pair(const std::vector<PairList>& lists, int begin, int end, const Visit& visit) {
  for (const PairList& list : lists) {
    for (int k = std::max(begin, 0); k < std::min(end, list.count); ++k) visit(Pair{list.a[k], list.b[k]});
    begin -= list.count, end -= list.count;
  }
}

// Out: all pairs of the lists, by a and then by b. Pairs are of elements 0 .. elements - 1. Throws InputError or
// std::bad_alloc if they do not fit the memory.
inline void order_pairs(int elements, const std::vector<PairList>& lists, Pairs& pairs) {
  constexpr int part_bits = 8, parts = 1 << part_bits;
  const int shift = std::max<int>(0, std::bit_width(static_cast<std::uint32_t>(elements)) - part_bits);
  require_pairs_fit(count_pairs(lists), static_cast<double>(pairs.capacity()));
  const int n = static_cast<int>(count_pairs(lists));
  pairs.resize(n);
  Array<Pair>& parted = workspace().order_pairs;
  grow(parted, n);
  std::array<std::int32_t, parts + 1> first;
  lockstep::openmp::CountingSort sort(parts);
  lockstep::openmp::Failure failure;

#pragma omp parallel
  {
    // Each thread moves its own share to where the sort tells it; the barrier stands between one thread's writing and
    // another's reading.
    const lockstep::openmp::Share mine = lockstep::openmp::my_share(n);
    sort(
        [&](const auto& visit) {
          for_each_pair(lists, mine.begin, mine.end, [&](const Pair& pair) { visit(pair, pair.a >> shift); });
        },
        [to = parted.data()](const Pair& pair, int place) { to[place] = pair; }, first.data());
#pragma omp barrier

    std::vector<std::int32_t> begin;
    Array<std::int32_t> b;
    // A part reads and writes its own pairs alone.
#pragma omp for schedule(dynamic)
    for (int part = 0; part < parts; ++part)
      if (const int size = first[part + 1] - first[part]; size > 0)
        failure.guard([&] {
          const int at = first[part];
          order_part(part << shift, 1 << shift, parted.data() + at, size, begin, b, pairs.data() + at);
        });
  }
  failure.rethrow();
}

}  // namespace lockstep::spatial::openmp
