#include "common/production_face/waves.h"

#include <algorithm>

namespace lockstep::production_face {

template <class Real>
Waves make_waves(const Body<Real>& body, int blocks) {
  Waves waves;
  waves.blocks = blocks;
  const auto block_of = [&](int corner) { return body.corner_at_node[corner] / 4 / lanes; };
  const auto last_block = [&](int node) { return block_of(body.first_corner[node + 1] - 1); };
  waves.first.assign(body.blocks() + 1, 0);
  for (int n = 0; n < body.nodes; ++n) {
    ++waves.first[last_block(n) + 1];
    waves.span = std::max(waves.span, last_block(n) - block_of(body.first_corner[n]));
  }
  for (int b = 0; b < body.blocks(); ++b) waves.first[b + 1] += waves.first[b];
  Array<std::int32_t> next(waves.first.begin(), waves.first.end());
  waves.node.resize(body.nodes);
  for (int n = 0; n < body.nodes; ++n) waves.node[next[last_block(n)]++] = n;
  for (const int n : waves.node) {
    for (int k = body.first_corner[n]; k < body.first_corner[n + 1]; ++k) waves.part.push_back(body.corner_at_node[k]);
    waves.first_part.push_back(static_cast<std::int32_t>(waves.part.size()));
  }
  return waves;
}

template Waves make_waves(const Body<float>& body, int blocks);
template Waves make_waves(const Body<double>& body, int blocks);

}  // namespace lockstep::production_face
