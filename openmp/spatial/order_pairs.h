// Pairs, each once and in any order in the lists of threads, put in the order of common/spatial/pairs.h. In serial:
// common/spatial/order_pairs.h.
//
// Two steps. Threads part the pairs by the highest bits of a, as one pass of a radix sort; a part, of some thousand pairs, then fits the
// first-level cache and is one thread's, which parts it by the rest of a and sorts the few pairs of each a by b: each goes where the number
// of those less than it says, which lanes count sixteen at a time.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "common/array.h"
#include "common/spatial/pairs.h"
#include "common/simd.h"
#include "openmp/spatial/radix_sort.h"
#include "openmp/spatial/workspace.h"
#include "openmp/share.h"

namespace lockstep::spatial::openmp {

// Pairs of one a, in order. Sixteen may be read from every element of b on.
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

// Pairs of first_a <= a < first_a + as. Grown as need be: begin, b.
inline void order_part(std::int32_t first_a, int as, const Pair* pairs, int n, std::vector<std::int32_t>& begin, Array<std::int32_t>& b,
                       Pair* ordered) {
  begin.assign(as + 2, 0);
  if (b.size() < padded(n)) b.resize(2 * padded(n));
  for (int k = 0; k < n; ++k) ++begin[pairs[k].a - first_a + 2];
  for (int a = 0; a < as; ++a) begin[a + 2] += begin[a + 1];
  for (int k = 0; k < n; ++k) b[begin[pairs[k].a - first_a + 1]++] = pairs[k].b;
  for (int a = 0; a < as; ++a)
    if (begin[a] < begin[a + 1]) order_by_b(first_a + a, &b[begin[a]], begin[a + 1] - begin[a], ordered + begin[a]);
}

// Calls visit(a, b) for pairs begin .. end - 1 of all lists.
template <class Visit>
void for_each_pair(const std::vector<PairList>& lists, int begin, int end, const Visit& visit) {
  for (const PairList& list : lists) {
    for (int k = std::max(begin, 0); k < std::min(end, list.count); ++k) visit(list.a[k], list.b[k]);
    begin -= list.count, end -= list.count;
  }
}

inline void order_pairs(int colliders, const std::vector<PairList>& lists, Pairs& pairs) {
  constexpr int part_bits = 8, parts = 1 << part_bits;
  const int shift = std::max<int>(0, std::bit_width(static_cast<std::uint32_t>(colliders)) - part_bits);
  int n = 0;
  for (const PairList& list : lists) n += list.count;
  pairs.resize(n);
  Array<Pair>& parted = workspace().order_pairs;
  grow(parted, n);
  Counts<parts> counts(omp_get_max_threads());

#pragma omp parallel
  {
    // Each thread counts and moves its own share, and adds up all counts for itself; the barriers stand between one thread's writing and
    // another's reading.
    const lockstep::openmp::Share mine = lockstep::openmp::my_share(n);
    std::array<std::int32_t, parts> count = {};
    for_each_pair(lists, mine.begin, mine.end, [&](std::int32_t a, std::int32_t) { ++count[a >> shift]; });
    counts[omp_get_thread_num()] = count;
#pragma omp barrier
    const std::array<std::int32_t, parts> first = places(counts, 0);
    std::array<std::int32_t, parts> place = places(counts, omp_get_thread_num());
    for_each_pair(lists, mine.begin, mine.end, [&](std::int32_t a, std::int32_t b) { parted[place[a >> shift]++] = {a, b}; });
#pragma omp barrier

    std::vector<std::int32_t> begin;
    Array<std::int32_t> b;
    // A part reads and writes its own pairs alone.
#pragma omp for schedule(dynamic)
    for (int part = 0; part < parts; ++part) {
      const int size = (part + 1 < parts ? first[part + 1] : n) - first[part];
      if (size > 0) order_part(part << shift, 1 << shift, parted.data() + first[part], size, begin, b, pairs.data() + first[part]);
    }
  }
}

}  // namespace lockstep::spatial::openmp
