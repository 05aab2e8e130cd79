// Constraints reordered into batches without conflicts, by the first-fit greedy rule of the papers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace lockstep {

// The order of constraints: batch k holds constraints order[begin[k]] .. order[begin[k + 1] - 1], in their original
// order.
struct Batches {
  std::vector<std::int32_t> order;
  std::vector<std::int32_t> begin;  // [batch], and one more

  int count() const { return static_cast<int>(begin.size()) - 1; }
};

// First fit, a greedy edge colouring. Goes through the constraints once. Each joins the earliest batch in which no
// constraint so far touches one of its objects. Then all constraints of one batch may be solved at the same time.
// Constraint k touches objects a[k] and b[k], numbered 0 .. objects - 1. An object that nothing moves (movable[i] = 0)
// conflicts with nobody, because nothing is ever written to it.
//
// Objects in m constraints each end up in at most 2 m - 1 batches. Time: proportional to the constraints; a constraint
// beyond the first 64 batches passes over words of 64 that are full. Memory, besides the result: 16 bytes an object and
// 4 a constraint; some 100 bytes for each constraint beyond the first 64 batches.
//
// Source: [LRB08] "Algorithm restructuring", Figure 13; [ITJ07] on the same rule for contact constraints.
Batches make_batches(std::span<const std::int32_t> a, std::span<const std::int32_t> b, std::span<const char> movable);

// The same without reordering: a constraint joins the batch after the last one that holds an earlier constraint at
// either of its objects. Solving batch after batch then does what solving in the original order does, bit for bit.
Batches make_levels(std::span<const std::int32_t> a, std::span<const std::int32_t> b, std::span<const char> movable);

// Levels folded into a ring of `ring_batches` batches: as parallel as few batches, and nearly as good an order as the
// original one. A constraint's turn comes after those of the last constraints at either of its objects, as its level
// does; it joins batch turn % ring_batches. If one of its objects is in that batch already, it takes the next turn that
// is free for both; if no batch of the ring is, the earliest batch behind the ring. One sweep then carries an
// impulse along up to `ring_batches` constraints of a chain. In earliest batches those of a chain alternate between
// two.
//
// Objects in m constraints each end up in at most max(ring_batches, 2 m - 1) batches. Time and memory as make_batches.
inline constexpr int ring_batches = 8;
Batches make_folded_levels(std::span<const std::int32_t> a, std::span<const std::int32_t> b,
                           std::span<const char> movable);

// The two steps of make_batches and make_folded_levels. The choice: batch_of[k] is constraint k's batch; returns how
// many batches there are. The order: constraints put in the order of their batches, 0 .. count - 1.
int choose_batches(std::span<const std::int32_t> a, std::span<const std::int32_t> b, std::span<const char> movable,
                   std::span<std::int32_t> batch_of);
int choose_folded_levels(std::span<const std::int32_t> a, std::span<const std::int32_t> b,
                         std::span<const char> movable, std::span<std::int32_t> batch_of);
Batches in_batches(std::span<const std::int32_t> batch_of, int count);

}  // namespace lockstep
