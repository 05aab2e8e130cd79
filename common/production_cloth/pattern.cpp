#include "common/production_cloth/pattern.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <vector>

namespace lockstep::production_cloth {
namespace {

// f(share, first corner, second corner), in the order of shares.
template <class Real, class F>
void for_each_share(const Elements<Real>& elements, const Pattern& pattern, const F& f) {
  for (int k = 0; k < elements.links; ++k) f(pattern.of_link(k), elements.from[k], elements.to[k]);
  for (int t = 0; t < elements.membranes; ++t)
    for (int p = 0; p < membrane_pairs; ++p)
      f(pattern.of_membrane(t) + p, elements.membrane_corner.at(t, membrane_pair[p][0]),
        elements.membrane_corner.at(t, membrane_pair[p][1]));
  for (int h = 0; h < elements.hinges; ++h)
    for (int p = 0; p < hinge_pairs; ++p)
      f(pattern.of_hinge(h) + p, elements.hinge_corner.at(h, hinge_pair[p][0]),
        elements.hinge_corner.at(h, hinge_pair[p][1]));
}

// Each row's columns: the vertex, and those of the elements at it, ascending. None in rows of held vertices.
template <class Real>
void set_columns(const Elements<Real>& elements, const Array<Real>& inverse_mass, Pattern& pattern) {
  std::vector<std::vector<std::int32_t>> rows(elements.vertices);
  const auto add = [&](std::int32_t row, std::int32_t column) {
    if (inverse_mass[row] > 0) rows[row].push_back(column);
  };
  for (std::int32_t v = 0; v < elements.vertices; ++v) add(v, v);
  for_each_share(elements, pattern, [&](int, std::int32_t a, std::int32_t c) { add(a, c), add(c, a); });
  pattern.begin.push_back(0);
  for (std::vector<std::int32_t>& row : rows) {
    std::ranges::sort(row);
    pattern.column.insert(pattern.column.end(), row.begin(), std::unique(row.begin(), row.end()));
    pattern.begin.push_back(pattern.blocks());
  }
}

template <class Real>
void set_places(const Elements<Real>& elements, Pattern& pattern) {
  pattern.place.assign(2 * static_cast<std::size_t>(pattern.shares), -1);
  const auto place = [&](std::int32_t row, std::int32_t column) {
    const auto first = pattern.column.begin() + pattern.begin[row],
               last = pattern.column.begin() + pattern.begin[row + 1];
    return first == last ? -1
                         : static_cast<std::int32_t>(std::lower_bound(first, last, column) - pattern.column.begin());
  };
  for_each_share(elements, pattern, [&](int share, std::int32_t a, std::int32_t c) {
    pattern.place[2 * static_cast<std::size_t>(share)] = place(a, c);
    pattern.place[2 * static_cast<std::size_t>(share) + 1] = place(c, a);
  });
}

// Sorts all shares by their blocks: a stable counting sort.
void set_shares(Pattern& pattern) {
  pattern.first_share.assign(pattern.blocks() + 1, 0);
  for (const std::int32_t block : pattern.place)
    if (block >= 0) ++pattern.first_share[block + 1];
  for (int k = 0; k < pattern.blocks(); ++k) pattern.first_share[k + 1] += pattern.first_share[k];
  Array<std::int32_t> next(pattern.first_share.begin(), pattern.first_share.end());
  pattern.share.resize(pattern.first_share.back());
  for (std::size_t i = 0; i < pattern.place.size(); ++i)
    if (pattern.place[i] >= 0) pattern.share[next[pattern.place[i]]++] = static_cast<std::int32_t>(i / 2);
}

}  // namespace

template <class Real>
Pattern make_pattern(const Elements<Real>& elements, const Array<Real>& inverse_mass) {
  const std::int64_t membranes = std::int64_t(lanes) * elements.membrane_corner_blocks(),
                     hinges = std::int64_t(lanes) * elements.hinge_corner_blocks(),
                     links = (elements.links + lanes - 1) / lanes * lanes;
  const std::int64_t shares = links + membrane_pairs * membranes + hinge_pairs * hinges;
  if (shares > std::numeric_limits<std::int32_t>::max() / 2)
    throw std::length_error("a cloth of too many elements for one matrix");
  Pattern pattern;
  pattern.vertices = elements.vertices;
  pattern.first_membrane = static_cast<int>(links);
  pattern.first_hinge = static_cast<int>(links + membrane_pairs * membranes);
  pattern.shares = static_cast<int>(shares);
  set_columns(elements, inverse_mass, pattern);
  set_places(elements, pattern);
  set_shares(pattern);
  return pattern;
}

template <class Real>
linear::BlockRows<Real> make_diagonal_block_rows(const Pattern& pattern) {
  linear::BlockRows<Real> rows;
  rows.rows = rows.columns = pattern.vertices;
  for (int v = 0; v < pattern.vertices; ++v) {
    if (pattern.begin[v] < pattern.begin[v + 1]) rows.column.push_back(v);
    rows.begin.push_back(static_cast<std::int32_t>(rows.column.size()));
  }
  rows.value.resize(9 * rows.column.size());
  return rows;
}

template Pattern make_pattern(const Elements<float>& elements, const Array<float>& inverse_mass);
template Pattern make_pattern(const Elements<double>& elements, const Array<double>& inverse_mass);
template linear::BlockRows<float> make_diagonal_block_rows(const Pattern& pattern);
template linear::BlockRows<double> make_diagonal_block_rows(const Pattern& pattern);

}  // namespace lockstep::production_cloth
