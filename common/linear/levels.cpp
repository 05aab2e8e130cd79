#include "common/linear/levels.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace lockstep::linear {

template <class Real>
Levels make_levels(const Rows<Real>& a) {
  std::vector<std::int32_t> level(a.rows, 0);
  int count = 0;
  for (int i = 0; i < a.rows; ++i) {
    for (int k = a.begin[i]; k < a.begin[i + 1] && a.column[k] < i; ++k)
      level[i] = std::max(level[i], level[a.column[k]] + 1);
    count = std::max(count, level[i] + 1);
  }
  Levels levels;
  levels.begin.assign(count + 1, 0);
  for (const std::int32_t l : level) ++levels.begin[l + 1];
  for (int l = 0; l < count; ++l) levels.begin[l + 1] += levels.begin[l];
  std::vector<std::int32_t> next(levels.begin.begin(), levels.begin.end());
  levels.order.resize(a.rows);
  for (int i = 0; i < a.rows; ++i) levels.order[next[level[i]]++] = i;
  return levels;
}

template <class Real>
Rows<Real> reordered(const Rows<Real>& a, std::span<const std::int32_t> order) {
  std::vector<std::int32_t> number(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) number[order[i]] = static_cast<std::int32_t>(i);
  Rows<Real> b{.rows = a.rows, .columns = a.columns, .begin = {0}, .column = {}, .value = {}};
  b.begin.reserve(a.begin.size()), b.column.reserve(a.column.size()), b.value.reserve(a.value.size());
  std::vector<std::pair<std::int32_t, Real>> row;
  for (const std::int32_t i : order) {
    row.clear();
    for (int k = a.begin[i]; k < a.begin[i + 1]; ++k) row.emplace_back(number[a.column[k]], a.value[k]);
    std::sort(row.begin(), row.end(), [](const auto& p, const auto& q) { return p.first < q.first; });
    for (const auto& [column, value] : row) b.column.push_back(column), b.value.push_back(value);
    b.begin.push_back(static_cast<std::int32_t>(b.column.size()));
  }
  return b;
}

template Levels make_levels(const Rows<float>& a);
template Levels make_levels(const Rows<double>& a);
template Rows<float> reordered(const Rows<float>& a, std::span<const std::int32_t> order);
template Rows<double> reordered(const Rows<double>& a, std::span<const std::int32_t> order);

}  // namespace lockstep::linear
