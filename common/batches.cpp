// Each object keeps the set of batches that touch it, one bit per batch in words of 64. The earliest batch free of both
// objects of a constraint is the lowest zero in the union of their sets. Few objects are in more than 64 batches. So
// the first words stand in an array of the objects. Later words are kept only if they hold a batch and are not full. A
// dense array of all words would take n^2 / 8 bytes where one object is in n constraints.
#include "common/batches.h"

#include <algorithm>
#include <bit>
#include <numeric>
#include <unordered_map>

namespace lockstep {

namespace {

constexpr std::uint64_t full_word = ~std::uint64_t(0);
constexpr std::uint64_t bit_of(int batch) { return std::uint64_t(1) << batch % 64; }

// The sets of batches from 64 on.
class LaterBatches {
 public:
  // Every word from 1 up to this one is full.
  int first_free_word(std::int32_t object) const {
    const auto found = first_free_word_.find(object);
    return found == first_free_word_.end() ? 1 : found->second;
  }

  // Only for words from first_free_word(object) on.
  std::uint64_t word(std::int32_t object, int word) const {
    const auto found = words_.find(key(object, word));
    return found == words_.end() ? 0 : found->second;
  }

  void add(std::int32_t object, int batch) {
    words_[key(object, batch / 64)] |= bit_of(batch);
    for (int w = first_free_word(object); word(object, w) == full_word; ++w) {
      words_.erase(key(object, w));
      first_free_word_[object] = w + 1;
    }
  }

 private:
  static std::uint64_t key(std::int32_t object, int word) { return std::uint64_t(object) << 32 | std::uint32_t(word); }

  std::unordered_map<std::int32_t, int> first_free_word_;
  std::unordered_map<std::uint64_t, std::uint64_t> words_;
};

// What the choice knows of an object.
struct Object {
  std::uint64_t first = 0;  // batches 0 .. 63, one bit each: those with a constraint of the object
  std::uint32_t next = 0;   // of folded levels: the turn after that of its last constraint
  bool movable = false;     // whether it conflicts: nothing is ever written to an object that does not move
};

// Each constraint joins batch choice(object, other, taken), of those in 0 .. 63 that are not taken at either of its
// objects, or the earliest batch after these if all are.
template <class Choice>
int choose(std::span<const std::int32_t> a, std::span<const std::int32_t> b, std::span<const char> movable,
           std::span<std::int32_t> batch_of, Choice choice) {
  std::vector<Object> objects(movable.size());
  for (std::size_t i = 0; i < movable.size(); ++i) objects[i].movable = movable[i];
  LaterBatches later;
  const auto join_later = [&](std::int32_t i, std::int32_t j) {
    int word = std::max(movable[i] ? later.first_free_word(i) : 1, movable[j] ? later.first_free_word(j) : 1);
    const auto taken = [&] { return (movable[i] ? later.word(i, word) : 0) | (movable[j] ? later.word(j, word) : 0); };
    while (taken() == full_word) ++word;
    const int batch = 64 * word + std::countr_one(taken());
    if (movable[i]) later.add(i, batch);
    if (movable[j]) later.add(j, batch);
    return batch;
  };

  int batches = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    Object &i = objects[a[k]], &j = objects[b[k]];
    const std::uint64_t taken = (i.movable ? i.first : 0) | (j.movable ? j.first : 0);
    if (taken != full_word) {
      batch_of[k] = choice(i, j, taken);
      i.first |= bit_of(batch_of[k]);
      j.first |= bit_of(batch_of[k]);
    } else {
      batch_of[k] = join_later(a[k], b[k]);
    }
    batches = std::max(batches, batch_of[k] + 1);
  }
  return batches;
}

}  // namespace

int choose_batches(std::span<const std::int32_t> a, std::span<const std::int32_t> b, std::span<const char> movable,
                   std::span<std::int32_t> batch_of) {
  return choose(a, b, movable, batch_of,
                [](const Object&, const Object&, std::uint64_t taken) { return std::countr_one(taken); });
}

int choose_folded_levels(std::span<const std::int32_t> a, std::span<const std::int32_t> b,
                         std::span<const char> movable, std::span<std::int32_t> batch_of) {
  constexpr std::uint64_t ring = bit_of(ring_batches) - 1;
  return choose(a, b, movable, batch_of, [](Object& i, Object& j, std::uint64_t taken) {
    if ((taken & ring) == ring) return std::countr_one(taken);
    const std::uint32_t from = std::max(i.movable ? i.next : 0, j.movable ? j.next : 0);
    // The ring twice in a row, so that the turns that are taken from here on are a run of ones.
    const std::uint64_t twice = (taken & ring) << ring_batches | (taken & ring);
    const std::uint32_t turn = from + std::countr_one(twice >> from % ring_batches);
    i.next = j.next = turn + 1;
    return static_cast<int>(turn % ring_batches);
  });
}

Batches in_batches(std::span<const std::int32_t> batch_of, int count) {
  Batches batches;
  batches.begin.assign(count + 1, 0);
  for (const std::int32_t batch : batch_of) ++batches.begin[batch + 1];
  std::partial_sum(batches.begin.begin(), batches.begin.end(), batches.begin.begin());
  std::vector<std::int32_t> next(batches.begin.begin(), batches.begin.end() - 1);
  batches.order.resize(batch_of.size());
  for (std::size_t k = 0; k < batch_of.size(); ++k) batches.order[next[batch_of[k]]++] = static_cast<std::int32_t>(k);
  return batches;
}

Batches make_batches(std::span<const std::int32_t> a, std::span<const std::int32_t> b, std::span<const char> movable) {
  std::vector<std::int32_t> batch_of(a.size());
  const int count = choose_batches(a, b, movable, batch_of);
  return in_batches(batch_of, count);
}

Batches make_folded_levels(std::span<const std::int32_t> a, std::span<const std::int32_t> b,
                           std::span<const char> movable) {
  std::vector<std::int32_t> batch_of(a.size());
  const int count = choose_folded_levels(a, b, movable, batch_of);
  return in_batches(batch_of, count);
}

Batches make_levels(std::span<const std::int32_t> a, std::span<const std::int32_t> b, std::span<const char> movable) {
  std::vector<std::int32_t> batch_of(a.size());
  std::vector<std::int32_t> next(movable.size(), 0);  // [object]: the first batch that its next constraint may be in
  int batches = 0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    batch_of[k] = std::max(movable[a[k]] ? next[a[k]] : 0, movable[b[k]] ? next[b[k]] : 0);
    next[a[k]] = next[b[k]] = batch_of[k] + 1;
    batches = std::max(batches, batch_of[k] + 1);
  }
  return in_batches(batch_of, batches);
}

}  // namespace lockstep
