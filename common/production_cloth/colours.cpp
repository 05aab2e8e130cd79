#include "common/production_cloth/colours.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <numeric>

namespace lockstep::production_cloth {
namespace {

constexpr int most = 64;

// corners_of(k): the vertices of element k.
template <class CornersOf>
Batches first_fit(int count, int vertices, const CornersOf& corners_of) {
  std::vector<std::uint64_t> taken(vertices);  // [vertex]: a bit a colour
  std::vector<int> colour(count);
  for (int k = 0; k < count; ++k) {
    std::uint64_t all = 0;
    for (const std::int32_t v : corners_of(k)) all |= taken[v];
    colour[k] = std::countr_one(all);
    if (colour[k] < most)
      for (const std::int32_t v : corners_of(k)) taken[v] |= std::uint64_t(1) << colour[k];
  }
  Batches batches;
  batches.order.resize(count);
  std::iota(batches.order.begin(), batches.order.end(), 0);
  std::ranges::stable_sort(batches.order, [&](int a, int b) { return colour[a] < colour[b]; });
  batches.begin = {0};
  for (int k = 1; k <= count; ++k) {
    const bool ends = k == count || colour[batches.order[k]] != colour[batches.order[k - 1]];
    if (ends || colour[batches.order[k]] == most) batches.begin.push_back(k);
  }
  return batches;
}

}  // namespace

template <class Real>
Colours make_colours(const Elements<Real>& e) {
  return {first_fit(e.links, e.vertices,
                    [&](int k) {
                      return std::array{e.from[k], e.to[k]};
                    }),
          first_fit(std::max(e.membranes, e.facets), e.vertices, [&](int t) {
            const auto corner = [&](int c) {
              return e.membranes > 0 ? e.membrane_corner.at(t, c) : e.facet_corner[e.place_of(t, c)];
            };
            return std::array{corner(0), corner(1), corner(2)};
          })};
}

template Colours make_colours(const Elements<float>& elements);
template Colours make_colours(const Elements<double>& elements);

}  // namespace lockstep::production_cloth
