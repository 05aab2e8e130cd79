// The stable counting sort, in sequence. In parallel: openmp/counting_sort.h.
#pragma once

#include <cstdint>
#include <vector>

namespace lockstep {

// Puts elements in the order of their keys, 0 .. keys - 1, and elements of equal keys in the order in which they come.
//
// for_each(visit) calls visit(element, key) for every element; it is called twice and must visit alike both times. Then
// put(element, place) is called once for each. begin, resized to keys + 1, says where the elements of a key are: at
// places begin[key] .. begin[key + 1] - 1.
template <class ForEach, class Put, class Allocator>
void stable_counting_sort(int keys, const ForEach& for_each, const Put& put,
                          std::vector<std::int32_t, Allocator>& begin) {
  begin.assign(keys + 2, 0);  // at first, begin[key + 2] counts; then begin[key + 1] is the next free place of key
  for_each([&](const auto&, std::int32_t key) { ++begin[key + 2]; });
  for (int key = 0; key < keys; ++key) begin[key + 2] += begin[key + 1];
  for_each([&](const auto& element, std::int32_t key) { put(element, begin[key + 1]++); });
  begin.pop_back();
}

}  // namespace lockstep
