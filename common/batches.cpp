// Every object keeps the set of batches that touch it, one bit a batch, so that the earliest batch free of both objects of a
// constraint is the lowest zero of the union. The sets grow by a word when all batches so far are taken.
#include "common/batches.h"

#include <algorithm>
#include <bit>
#include <numeric>

namespace lockstep {

namespace {

// Constraints put in the order of their batches, 0 .. batches - 1.
Batches in_batches(const std::vector<std::int32_t>& batch_of, int count) {
  Batches batches;
  batches.begin.assign(count + 1, 0);
  for (const std::int32_t batch : batch_of) ++batches.begin[batch + 1];
  std::partial_sum(batches.begin.begin(), batches.begin.end(), batches.begin.begin());
  std::vector<std::int32_t> next(batches.begin.begin(), batches.begin.end() - 1);
  batches.order.resize(batch_of.size());
  for (std::size_t k = 0; k < batch_of.size(); ++k) batches.order[next[batch_of[k]]++] = static_cast<std::int32_t>(k);
  return batches;
}

}  // namespace

Batches make_batches(std::span<const std::int32_t> a, std::span<const std::int32_t> b, std::span<const char> movable) {
  const std::size_t objects = movable.size(), constraints = a.size();
  std::vector<std::vector<std::uint64_t>> taken;  // [word][object]: batches 64 word .. 64 word + 63
  std::vector<std::int32_t> batch_of(constraints);
  int batches = 0;
  for (std::size_t k = 0; k < constraints; ++k) {
    std::size_t word = 0;
    const auto in_use = [&] { return (movable[a[k]] ? taken[word][a[k]] : 0) | (movable[b[k]] ? taken[word][b[k]] : 0); };
    while (word < taken.size() && ~in_use() == 0) ++word;
    if (word == taken.size()) taken.emplace_back(objects, 0);
    const int bit = std::countr_one(in_use());
    taken[word][a[k]] |= std::uint64_t(1) << bit;
    taken[word][b[k]] |= std::uint64_t(1) << bit;
    batch_of[k] = static_cast<std::int32_t>(64 * word + bit);
    batches = std::max(batches, batch_of[k] + 1);
  }
  return in_batches(batch_of, batches);
}

Batches make_levels(std::span<const std::int32_t> a, std::span<const std::int32_t> b, std::span<const char> movable) {
  std::vector<std::int32_t> batch_of(a.size()), next(movable.size(), 0);  // [object]: the first batch that its next constraint may be in
  int batches = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    batch_of[k] = std::max(movable[a[k]] ? next[a[k]] : 0, movable[b[k]] ? next[b[k]] : 0);
    next[a[k]] = next[b[k]] = batch_of[k] + 1;
    batches = std::max(batches, batch_of[k] + 1);
  }
  return in_batches(batch_of, batches);
}

}  // namespace lockstep
