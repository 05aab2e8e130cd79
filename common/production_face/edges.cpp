#include "common/production_face/edges.h"

#include <algorithm>

namespace lockstep::production_face {

template <class Real>
Edges<Real> make_edges(const linear::BlockRows<Real>& k) {
  Edges<Real> edges;
  edges.nodes = k.rows;
  edges.at_node.resize(6 * static_cast<std::size_t>(k.rows));
  const auto is_empty = [&](int row) { return k.begin[row] == k.begin[row + 1]; };
  for (int i = 0; i < k.rows; ++i) {
    if (is_empty(i)) edges.held.push_back(i);
    for (int place = k.begin[i]; place < k.begin[i + 1]; ++place) {
      const Real* const block = &k.value[9 * static_cast<std::size_t>(place)];
      const int j = k.column[place];
      if (j == i) {
        Real* const own = &edges.at_node[6 * static_cast<std::size_t>(i)];
        for (int r = 0, e = 0; r < 3; ++r)
          for (int c = r; c < 3; ++c) own[e++] = block[3 * r + c];
      } else if (j > i || is_empty(j)) {
        edges.first.push_back(std::min(i, j)), edges.last.push_back(std::max(i, j));
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c) edges.between.push_back(j > i ? block[3 * r + c] : block[3 * c + r]);
      }
    }
  }
  return edges;
}

template Edges<float> make_edges(const linear::BlockRows<float>& k);
template Edges<double> make_edges(const linear::BlockRows<double>& k);

}  // namespace lockstep::production_face
