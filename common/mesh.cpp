#include "common/mesh.h"

#include <algorithm>
#include <utility>

#include "common/input_error.h"

namespace lockstep {

void require_closed(const Mesh& mesh, const std::string& where) {
  std::vector<std::pair<int, int>> edges;
  for (const auto& [a, b, c] : mesh.triangles)
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)})
      edges.push_back(std::minmax(from, to));
  std::ranges::sort(edges);
  for (auto edge = edges.begin(); edge != edges.end();) {
    const auto next = std::upper_bound(edge, edges.end(), *edge);
    if (next - edge != 2)
      throw InputError(where + ": the edge of points " + std::to_string(edge->first + 1) + " and " +
                       std::to_string(edge->second + 1) + " is in " + std::to_string(next - edge) +
                       (next - edge == 1 ? " triangle" : " triangles") + ", expected two: a closed mesh");
    edge = next;
  }
}

}  // namespace lockstep
