// Contract: cuts contacts into blocks of space, so that a thread solves a block's contacts without waiting for others.
//
// Blocks are made in rounds. In a round, the contacts that are left are put in the order of the Morton codes of their
// first body that moves, and cut into blocks of about as many each. A contact is in a block if all its bodies that move
// are. One that crosses a border is left for the next round. There the curve is shifted, so that borders lie elsewhere,
// and blocks are fewer, as contacts are. A round with one block leaves none; the eighth has one.
//
// So no body that moves is in two blocks of one round. Within a block, contacts are put into groups: up to sixteen that
// share no body that moves, as many as lanes solve at once. In order, a contact joins the first of 64 open groups that
// has neither of its bodies. A group that is full is closed and becomes the block's next; a new one opens in its place.
//
// How many blocks there are depends on the contacts alone, so solving in this order gives the same bits at every number
// of threads.
//
// In: manifolds, of two different bodies each; body[collider]; poses of the bodies, and which move. Out: blocks,
// resized; the caller owns them. Errors: std::bad_alloc.
//
// Source: [ITJ07] "Game Physics" cuts a fluid's particles into sub-grids and takes borders by themselves; here contacts
// are cut. Codes: common/spatial/morton.h.
#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "common/rigid/manifold.h"
#include "common/rigid/world.h"
#include "common/spatial/morton.h"

namespace lockstep::rigid {

struct ContactBlocks {
  std::vector<std::int32_t> order;   // contacts: the order in which they are solved
  std::vector<std::int32_t> groups;  // [group]: where it begins in `order`; one more entry here and below: the end
  std::vector<std::int32_t> blocks;  // [block]: its first group
  std::vector<std::int32_t> rounds;  // [round]: its first block
};

template <class Real>
using CutIntoBlocks = void(std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                           const Bodies<Real>& bodies, ContactBlocks& blocks);

namespace serial {
CutIntoBlocks<float> contact_blocks;
CutIntoBlocks<double> contact_blocks;
}  // namespace serial

namespace openmp {
CutIntoBlocks<float> contact_blocks;
}  // namespace openmp

// --- Rules that both versions share

inline constexpr int group_size = 16;       // contacts: lanes
inline constexpr int most_blocks = 64;      // of a round. More have more borders (notes/contact_solver.md)
inline constexpr int fewest_contacts = 96;  // of a block on average: their six vectors take longer than a barrier
inline constexpr int most_rounds = 8;       // the last takes what is left, such as contacts of a body that all touch

inline int blocks_of_round(int round, int contacts) {
  return round + 1 == most_rounds ? 1 : std::clamp(contacts / fewest_contacts, 1, most_blocks);
}

// The Morton curve of a round, over a cube with twice the sides of the contacts' bounds. The cube is shifted by a share
// of these sides that differs from round to round and from axis to axis: multiples of an irrational number, modulo 1.
template <class Real>
struct Curve {
  Vector3<Real> low;
  Real scale;

  // T is Real or lanes of it.
  template <class T>
  auto code(const Vector3<T>& point) const {
    return spatial::morton_code(point, low, scale);
  }
};

template <class Real>
inline Curve<Real> curve_of_round(const spatial::Box<Real>& bounds, int round) {
  const Vector3<Real> sides = bounds.high - bounds.low;
  const Real longest = max(sides.x, max(sides.y, sides.z));
  const auto shift = [&](double step) { return longest * static_cast<Real>(round * step - std::floor(round * step)); };
  return {bounds.low - Vector3<Real>{shift(.8191725), shift(.6710436), shift(.5497005)},
          spatial::morton_scale(bounds) / 2};
}

// A contact's bodies; -1 in place of one that does not move, which conflicts with nobody: nothing is written to it.
struct Ends {
  std::int32_t a, b;
};

// The code of a contact's first body that moves; 0 if none does.
inline std::int32_t code_of(const Ends& ends, const std::int32_t* code) {
  return ends.a >= 0 ? code[ends.a] : ends.b >= 0 ? code[ends.b] : 0;
}

// Codes first .. last - 1: what a block holds.
struct CodeRange {
  std::int32_t first, last;

  bool has(const Ends& ends, const std::int32_t* code) const {
    const auto has_body = [&](std::int32_t i) { return i < 0 || (code[i] >= first && code[i] < last); };
    return has_body(ends.a) && has_body(ends.b);
  }
};

// Block `block` of `count`: the codes between those of every (n / count)-th contact; code(k) is the k-th of n in their
// order. A cell of the curve that holds many contacts may leave a block without any.
template <class Code>
inline CodeRange range_of_block(int block, int count, int n, const Code& code) {
  const auto cut = [&](int k) { return code(static_cast<int>(std::int64_t(n) * k / count)); };
  return {block == 0 ? 0 : cut(block), block + 1 == count ? 1 << spatial::morton_bits : cut(block + 1)};
}

// Puts the contacts of a block into groups. Calls close(contacts) with each group that is full, and by close_all with
// the others.
template <class Close>
class OpenGroups {
 public:
  // taken[body]: the open groups that have the body, a bit each; 0 to begin with, and after close_all.
  OpenGroups(std::span<const Ends> ends, std::uint64_t* taken, const Close& close)
      : ends_(ends), taken_(taken), close_(close) {}

  void add(std::int32_t contact) {
    const Ends& ends = ends_[contact];
    if (~taken(ends) == 0) close_all();
    const int group = std::countr_one(taken(ends));
    const std::uint64_t bit = std::uint64_t(1) << group;
    if (ends.a >= 0) taken_[ends.a] |= bit;
    if (ends.b >= 0) taken_[ends.b] |= bit;
    contacts_[group][size_[group]++] = contact;
    if (size_[group] == group_size) close(group);
  }

  void close_all() {
    for (int group = 0; group < open_groups; ++group)
      if (size_[group] > 0) close(group);
  }

 private:
  static constexpr int open_groups = 64;

  // The groups that have a contact's bodies.
  std::uint64_t taken(const Ends& ends) const {
    return (ends.a >= 0 ? taken_[ends.a] : 0) | (ends.b >= 0 ? taken_[ends.b] : 0);
  }

  void close(int group) {
    const std::span<const std::int32_t> contacts(contacts_[group], size_[group]);
    const std::uint64_t others = ~(std::uint64_t(1) << group);
    for (const std::int32_t contact : contacts) {
      const auto [a, b] = ends_[contact];
      if (a >= 0) taken_[a] &= others;
      if (b >= 0) taken_[b] &= others;
    }
    close_(contacts);
    size_[group] = 0;
  }

  std::span<const Ends> ends_;
  std::uint64_t* taken_;
  Close close_;
  int size_[open_groups] = {};
  std::int32_t contacts_[open_groups][group_size];
};

}  // namespace lockstep::rigid
