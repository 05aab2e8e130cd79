#include "common/production_face/waves.h"

#include <algorithm>

namespace lockstep::production_face {

template <class Real>
Waves make_waves(const Body<Real>& body, int blocks) {
  Waves waves;
  waves.blocks = blocks;
  const int count = (body.blocks() + blocks - 1) / blocks;
  const auto wave_of = [&](int corner) { return body.corner_at_node[corner] / 4 / lanes / blocks; };
  const auto last_wave = [&](int node) { return wave_of(body.first_corner[node + 1] - 1); };
  int most = 1;
  waves.first.assign(count + 1, 0);
  for (int n = 0; n < body.nodes; ++n) {
    ++waves.first[last_wave(n) + 1];
    most = std::max(most, last_wave(n) - wave_of(body.first_corner[n]) + 1);
  }
  waves.room = most * blocks;
  for (int w = 0; w < count; ++w) waves.first[w + 1] += waves.first[w];
  Array<std::int32_t> next(waves.first.begin(), waves.first.end());
  waves.node.resize(body.nodes);
  for (int n = 0; n < body.nodes; ++n) waves.node[next[last_wave(n)]++] = n;
  for (const int n : waves.node) {
    for (int k = body.first_corner[n]; k < body.first_corner[n + 1]; ++k)
      waves.part.push_back(body.corner_at_node[k] % (4 * lanes * waves.room));
    waves.first_part.push_back(static_cast<std::int32_t>(waves.part.size()));
  }
  return waves;
}

template Waves make_waves(const Body<float>& body, int blocks);
template Waves make_waves(const Body<double>& body, int blocks);

}  // namespace lockstep::production_face
