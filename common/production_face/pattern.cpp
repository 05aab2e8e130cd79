#include "common/production_face/pattern.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "common/production_face/element_stiffness.h"

namespace lockstep::production_face {
namespace {

// Each row's columns: the nodes of the tetrahedra at its node, ascending. None in rows of held nodes.
template <class Real>
void set_columns(const Body<Real>& body, Pattern& pattern) {
  Array<std::int32_t> row;
  for (int n = 0; n < body.nodes; ++n) {
    row.clear();
    if (std::ranges::binary_search(body.held, n)) {
      pattern.begin.push_back(pattern.blocks());
      continue;
    }
    for (int k = body.first_corner[n]; k < body.first_corner[n + 1]; ++k)
      for (int a = 0; a < 4; ++a) row.push_back(body.corner.at(body.corner_at_node[k] / 4, a));
    std::ranges::sort(row);
    pattern.column.insert(pattern.column.end(), row.begin(), std::unique(row.begin(), row.end()));
    pattern.begin.push_back(pattern.blocks());
  }
}

template <class Real>
void set_places(const Body<Real>& body, Pattern& pattern) {
  pattern.place.resize(16 * static_cast<std::size_t>(body.tetrahedra));
  for (int t = 0; t < body.tetrahedra; ++t)
    for (int a = 0; a < 4; ++a)
      for (int c = 0; c < 4; ++c) {
        const int row = body.corner.at(t, a);
        const auto first = pattern.column.begin() + pattern.begin[row];
        const auto last = pattern.column.begin() + pattern.begin[row + 1];
        const auto found = std::lower_bound(first, last, body.corner.at(t, c));
        pattern.place[16 * static_cast<std::size_t>(t) + 4 * a + c] =
            first == last ? -1 : static_cast<std::int32_t>(found - pattern.column.begin());
      }
}

// Sorts all shares by their blocks: a stable counting sort.
void set_shares(int tetrahedra, Pattern& pattern) {
  const auto for_each_share = [&](const auto& f) {
    for (int t = 0; t < tetrahedra; ++t)
      for (int a = 0; a < 4; ++a)
        for (int c = 0; c < 4; ++c)
          if (const int block = pattern.place[16 * static_cast<std::size_t>(t) + 4 * a + c]; a != c && block >= 0)
            f(block, pairs * t + block_of[a][c]);
  };
  pattern.first_share.assign(pattern.blocks() + 1, 0);
  for_each_share([&](std::int32_t block, int) { ++pattern.first_share[block + 1]; });
  for (int k = 0; k < pattern.blocks(); ++k) pattern.first_share[k + 1] += pattern.first_share[k];
  Array<std::int32_t> next(pattern.first_share.begin(), pattern.first_share.end());
  pattern.share.resize(pattern.first_share.back());
  for_each_share([&](std::int32_t block, int share) { pattern.share[next[block]++] = share; });
}

}  // namespace

template <class Real>
Pattern make_pattern(const Body<Real>& body) {
  if (body.tetrahedra > std::numeric_limits<std::int32_t>::max() / 16)
    throw std::length_error("a body of more than 2^31 / 16 tetrahedra");
  Pattern pattern = {.nodes = body.nodes, .begin = {0}, .column = {}, .place = {}, .first_share = {}, .share = {}};
  set_columns(body, pattern);
  set_places(body, pattern);
  set_shares(body.tetrahedra, pattern);
  return pattern;
}

template Pattern make_pattern(const Body<float>& body);
template Pattern make_pattern(const Body<double>& body);

}  // namespace lockstep::production_face
