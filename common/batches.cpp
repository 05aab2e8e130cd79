// Every object keeps the set of batches that touch it, one bit a batch, so that the earliest batch free of both objects of a
// constraint is the lowest zero of the union. The sets grow by a word when all batches so far are taken.
#include "common/batches.h"

#include <bit>

namespace lockstep {

Batches make_batches(std::span<const std::int32_t> a, std::span<const std::int32_t> b, std::span<const char> movable) {
  const std::size_t objects = movable.size(), constraints = a.size();
  std::vector<std::vector<std::uint64_t>> taken;  // [word][object]: batches 64 word .. 64 word + 63
  std::vector<std::int32_t> batch_of(constraints), size;
  for (std::size_t k = 0; k < constraints; ++k) {
    std::size_t word = 0;
    const auto in_use = [&] { return (movable[a[k]] ? taken[word][a[k]] : 0) | (movable[b[k]] ? taken[word][b[k]] : 0); };
    while (word < taken.size() && ~in_use() == 0) ++word;
    if (word == taken.size()) taken.emplace_back(objects, 0);
    const int bit = std::countr_one(in_use());
    taken[word][a[k]] |= std::uint64_t(1) << bit;
    taken[word][b[k]] |= std::uint64_t(1) << bit;
    batch_of[k] = static_cast<std::int32_t>(64 * word + bit);
    if (batch_of[k] == static_cast<std::int32_t>(size.size())) size.push_back(0);
    ++size[batch_of[k]];
  }

  Batches batches;
  batches.begin.assign(1, 0);
  for (const std::int32_t n : size) batches.begin.push_back(batches.begin.back() + n);
  std::vector<std::int32_t> next(batches.begin.begin(), batches.begin.end() - 1);
  batches.order.resize(constraints);
  for (std::size_t k = 0; k < constraints; ++k) batches.order[next[batch_of[k]]++] = static_cast<std::int32_t>(k);
  return batches;
}

}  // namespace lockstep
