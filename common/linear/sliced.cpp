#include "common/linear/sliced.h"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <stdexcept>

namespace lockstep::linear {
namespace {

// The entries of a slice's rows, lane by lane, as they are dealt out to slots.
class Cursors {
 public:
  Cursors(const Rows<float>& a, int begin, int end) : a_(a), lanes_(end - begin) {
    for (int l = 0; l < lanes_; ++l) at_[l] = a.begin[begin + l], end_[l] = a.begin[begin + l + 1];
  }

  // The lanes whose next entries share the least column - lane, and that difference; no lanes if all entries are dealt
  // out.
  std::pair<std::uint16_t, std::int32_t> next_run() const {
    std::int32_t least = std::numeric_limits<std::int32_t>::max();
    std::uint16_t mask = 0;
    for (int l = 0; l < lanes_; ++l) {
      if (at_[l] == end_[l]) continue;
      const std::int32_t place = a_.column[at_[l]] - l;
      if (place < least) least = place, mask = 0;
      if (place == least) mask |= 1 << l;
    }
    return {mask, least};
  }

  std::uint16_t lanes_left() const {
    std::uint16_t mask = 0;
    for (int l = 0; l < lanes_; ++l)
      if (at_[l] < end_[l]) mask |= 1 << l;
    return mask;
  }

  int entry(int lane) const { return at_[lane]; }
  void advance(std::uint16_t mask) {
    for (int l = 0; l < lanes_; ++l) at_[l] += mask >> l & 1;
  }

 private:
  const Rows<float>& a_;
  int lanes_;
  std::array<std::int32_t, lanes> at_, end_;
};

void require_places(std::size_t places) {
  if (places > std::numeric_limits<std::int32_t>::max() - lanes)
    throw std::length_error("a sliced matrix of more than 2^31 - 17 places");
}

// Appends a slot of the cursors' next entries in the lanes of `mask`.
void add_slot(SlicedRows& sliced, const Rows<float>& a, const Cursors& cursors, std::uint16_t mask, bool gathers,
              std::int32_t place) {
  SlicedRows::Slot slot{.place = place,
                        .values = static_cast<std::int32_t>(sliced.value.size()),
                        .mask = mask,
                        .gathers = gathers,
                        .uniform = !gathers,
                        .inside = !gathers && place >= 0 && place <= a.columns - lanes};
  std::array<float, lanes> value{};
  std::array<std::int32_t, lanes> column{};
  const float first = a.value[cursors.entry(std::countr_zero(mask))];
  for (int l = 0; l < lanes; ++l)
    if (mask >> l & 1) {
      value[l] = a.value[cursors.entry(l)];
      column[l] = a.column[cursors.entry(l)];
      if (value[l] != first) slot.uniform = false;
    }
  if (gathers) {
    slot.place = static_cast<std::int32_t>(sliced.column.size());
    sliced.column.insert(sliced.column.end(), column.begin(), column.end());
  }
  if (slot.uniform)
    sliced.value.push_back(first);
  else
    sliced.value.insert(sliced.value.end(), value.begin(), value.end());
  require_places(std::max(sliced.value.size(), sliced.column.size()));
  sliced.slots.push_back(slot);
}

// A slice gathers if its runs need more than so many slots for each entry of its longest row. A slot that gathers reads
// sixteen columns; a slot of a run reads none.
constexpr int slots_for_a_gather = 2;

void add_slice(SlicedRows& sliced, const Rows<float>& a, int begin, int end) {
  int runs = 0, longest = 0;
  for (Cursors cursors(a, begin, end); const std::uint16_t mask = cursors.next_run().first; ++runs)
    cursors.advance(mask);
  for (int i = begin; i < end; ++i) longest = std::max(longest, a.begin[i + 1] - a.begin[i]);
  const bool gathers = runs > slots_for_a_gather * longest;

  Cursors cursors(a, begin, end);
  while (cursors.lanes_left()) {
    const auto [run, place] = cursors.next_run();
    const std::uint16_t mask = gathers ? cursors.lanes_left() : run;
    add_slot(sliced, a, cursors, mask, gathers, place);
    cursors.advance(mask);
  }
  sliced.first_row.push_back(end);
  sliced.first_slot.push_back(static_cast<std::int32_t>(sliced.slots.size()));
}

constexpr int window = 256;  // rows that are sorted by length

}  // namespace

SlicedRows slice(const Rows<float>& a, std::span<const std::int32_t> groups) {
  SlicedRows sliced;
  sliced.rows = a.rows, sliced.columns = a.columns;
  for (std::size_t g = 0; g + 1 < groups.size(); ++g)
    for (int begin = groups[g]; begin < groups[g + 1]; begin += lanes)
      add_slice(sliced, a, begin, std::min(begin + lanes, groups[g + 1]));
  return sliced;
}

SlicedRows slice(const Rows<float>& a) { return slice(a, std::array{0, a.rows}); }

SlicedBlockRows slice(const BlockRows<float>& a) {
  SlicedBlockRows sliced;
  sliced.rows = a.rows, sliced.columns = a.columns;
  const int slices = (a.rows + lanes - 1) / lanes;
  sliced.row.assign(static_cast<std::size_t>(slices) * lanes, -1);
  std::iota(sliced.row.begin(), sliced.row.begin() + a.rows, 0);
  sliced.length.assign(sliced.row.size(), 0);
  const auto length = [&](std::int32_t row) { return row < 0 ? 0 : a.begin[row + 1] - a.begin[row]; };
  for (int begin = 0; begin < a.rows; begin += window)
    std::stable_sort(sliced.row.begin() + begin, sliced.row.begin() + std::min(begin + window, a.rows),
                     [&](std::int32_t i, std::int32_t j) { return length(i) > length(j); });
  std::size_t slots = 0;
  for (int s = 0; s < slices; ++s) {
    int longest = 0;
    for (int l = 0; l < lanes; ++l) {
      sliced.length[s * lanes + l] = length(sliced.row[s * lanes + l]);
      longest = std::max(longest, sliced.length[s * lanes + l]);
    }
    slots += longest;
    require_places(lanes * slots);
    sliced.first_slot.push_back(static_cast<std::int32_t>(slots));
  }
  sliced.column.assign(lanes * slots, 0);
  sliced.value.assign(9 * lanes * slots, 0);
  for (int s = 0; s < slices; ++s)
    for (int l = 0; l < lanes; ++l)
      for (int k = 0; k < sliced.length[s * lanes + l]; ++k) {
        const std::size_t from = a.begin[sliced.row[s * lanes + l]] + k, slot = sliced.first_slot[s] + k;
        sliced.column[lanes * slot + l] = a.column[from];
        for (int e = 0; e < 9; ++e) sliced.value[lanes * (9 * slot + e) + l] = a.value[9 * from + e];
      }
  return sliced;
}

double bytes_of(const SlicedRows& a) {
  return 8. * a.slices() + sizeof(SlicedRows::Slot) * double(a.slots.size()) +
         4. * double(a.column.size() + a.value.size());
}

double bytes_of(const SlicedBlockRows& a) {
  return 4. * double(a.row.size() + a.length.size() + a.first_slot.size() + a.column.size() + a.value.size());
}

}  // namespace lockstep::linear
