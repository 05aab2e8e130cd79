#include "common/production_face/coarsening.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lockstep::production_face {
namespace {

// Elements that are to be aggregated, and which of them K couples. Those without a row are held.
struct Graph {
  Array<std::int32_t> begin{0}, column;

  int count() const { return static_cast<int>(begin.size()) - 1; }
  bool is_free(int i) const { return begin[i] < begin[i + 1]; }
};

// What nodes an element stands for: how many, their mean place, and the sums of squares about it. A node is one.
struct Cluster {
  double nodes = 0;
  Vector3<double> centre = {};
  double xx = 0, yy = 0, zz = 0, xy = 0, yz = 0, zx = 0;  // m^2
  bool turns = false;                                     // its nodes are not on a line
};

// Calls f(j) for i and all free elements at most `reach` edges away. `seen` has the last root of each element.
template <class F>
void for_each_near(const Graph& graph, int i, int reach, Array<std::int32_t>& seen, const F& f) {
  Array<std::int32_t> now{i}, next;
  seen[i] = i;
  for (int distance = 0;; ++distance) {
    for (const int j : now) f(j);
    if (distance == reach) return;
    next.clear();
    for (const int j : now)
      for (int k = graph.begin[j]; k < graph.begin[j + 1]; ++k)
        if (const int c = graph.column[k]; graph.is_free(c) && seen[c] != i) seen[c] = i, next.push_back(c);
    std::swap(now, next);
  }
}

// [element]: its aggregate; -1 if it is held. An element begins an aggregate if none that does is within reach; others
// join the one that is the fewest edges away.
Array<std::int32_t> aggregates_of(const Graph& graph, int reach) {
  Array<std::int32_t> of(graph.count(), -1), seen(graph.count(), -1), queue;
  Array<char> is_near(graph.count(), 0);
  for (int i = 0; i < graph.count(); ++i) {
    if (!graph.is_free(i) || is_near[i]) continue;
    of[i] = static_cast<std::int32_t>(queue.size());
    queue.push_back(i);
    for_each_near(graph, i, reach, seen, [&](int j) { is_near[j] = 1; });
  }
  for (std::size_t head = 0; head < queue.size(); ++head)
    for (int k = graph.begin[queue[head]]; k < graph.begin[queue[head] + 1]; ++k)
      if (const int c = graph.column[k]; graph.is_free(c) && of[c] < 0) of[c] = of[queue[head]], queue.push_back(c);
  return of;
}

template <class Real>
void set_members(int count, CoarseLevel<Real>& level) {
  level.first.assign(count + 1, 0);
  for (const int a : level.of)
    if (a >= 0) ++level.first[a + 1];
  std::partial_sum(level.first.begin(), level.first.end(), level.first.begin());
  Array<std::int32_t> next = level.first;
  level.member.resize(level.first.back());
  for (std::size_t i = 0; i < level.members(); ++i)
    if (level.of[i] >= 0) level.member[next[level.of[i]]++] = static_cast<std::int32_t>(i);
}

// Two clusters as one.
Cluster merged(const Cluster& a, const Cluster& b) {
  Cluster c;
  c.nodes = a.nodes + b.nodes;
  const Vector3<double> d = b.centre - a.centre;
  const double share = b.nodes / c.nodes, weight = a.nodes * share;
  c.centre = a.centre + share * d;
  c.xx = a.xx + b.xx + weight * d.x * d.x, c.xy = a.xy + b.xy + weight * d.x * d.y;
  c.yy = a.yy + b.yy + weight * d.y * d.y, c.yz = a.yz + b.yz + weight * d.y * d.z;
  c.zz = a.zz + b.zz + weight * d.z * d.z, c.zx = a.zx + b.zx + weight * d.z * d.x;
  c.turns = a.turns || b.turns;
  return c;
}

// Whether nodes are further from each line than a few per cent of their spread.
bool is_no_line(const Cluster& c) {
  const double trace = c.xx + c.yy + c.zz;
  const double minors = c.xx * c.yy - c.xy * c.xy + c.yy * c.zz - c.yz * c.yz + c.zz * c.xx - c.zx * c.zx;
  return minors > 1e-3 * trace * trace;
}

// The aggregates' clusters; sets the arms.
template <class Real>
std::vector<Cluster> set_arms(const std::vector<Cluster>& fine, CoarseLevel<Real>& level) {
  std::vector<Cluster> coarse(level.count());
  double squares = 0, nodes = 0;
  for (int a = 0; a < level.count(); ++a) {
    for (int k = level.first[a]; k < level.first[a + 1]; ++k) coarse[a] = merged(coarse[a], fine[level.member[k]]);
    coarse[a].turns |= is_no_line(coarse[a]);
    squares += coarse[a].xx + coarse[a].yy + coarse[a].zz, nodes += coarse[a].nodes;
  }
  const double length = squares > 0 ? std::sqrt(squares / nodes) : 1;
  level.arm.assign(3 * level.members(), 0);
  for (std::size_t i = 0; i < level.members(); ++i) {
    if (level.of[i] < 0 || !coarse[level.of[i]].turns) continue;
    const Vector3<double> d = fine[i].centre - coarse[level.of[i]].centre;
    level.arm[3 * i] = static_cast<Real>(d.x / length), level.arm[3 * i + 1] = static_cast<Real>(d.y / length);
    level.arm[3 * i + 2] = static_cast<Real>(d.z / length);
  }
  return coarse;
}

// Which aggregates K couples.
template <class Real>
Graph graph_of(const Graph& fine, const CoarseLevel<Real>& level) {
  Graph coarse;
  Array<std::int32_t> row;
  for (int a = 0; a < level.count(); ++a) {
    row.clear();
    for (int m = level.first[a]; m < level.first[a + 1]; ++m)
      for (int k = fine.begin[level.member[m]]; k < fine.begin[level.member[m] + 1]; ++k)
        if (const int b = level.of[fine.column[k]]; b >= 0) row.push_back(b);
    std::ranges::sort(row);
    coarse.column.insert(coarse.column.end(), row.begin(), std::unique(row.begin(), row.end()));
    coarse.begin.push_back(static_cast<std::int32_t>(coarse.column.size()));
  }
  return coarse;
}

// Block (parts row + p, parts column + q) of a matrix of parts x parts blocks for each entry of the graph.
struct Places {
  const Graph& graph;
  int parts;

  std::int32_t operator()(int row, int entry, int p, int q) const {
    const int begin = graph.begin[row], length = graph.begin[row + 1] - begin;
    return parts * (parts * begin + p * length + (entry - begin)) + q;
  }
};

int entry_of(const Graph& graph, int row, int column) {
  const auto first = graph.column.begin() + graph.begin[row], last = graph.column.begin() + graph.begin[row + 1];
  return static_cast<int>(std::lower_bound(first, last, column) - graph.column.begin());
}

constexpr int window = 256;  // couplings that are sorted by their number of shares, and read K near each other

template <class Real>
void set_matrix(const Graph& coarse, CoarseLevel<Real>& level) {
  for (int row = 0; row < 2 * coarse.count(); ++row) {
    for (int k = coarse.begin[row / 2]; k < coarse.begin[row / 2 + 1]; ++k)
      level.column.push_back(2 * coarse.column[k]), level.column.push_back(2 * coarse.column[k] + 1);
    level.begin.push_back(static_cast<std::int32_t>(level.column.size()));
  }
}

template <class Real>
void set_couplings(const Graph& fine, const Graph& coarse, CoarseLevel<Real>& level) {
  // Shares of each entry of the coarse graph, which are counted, and then put in order.
  const auto for_each_share = [&](const auto& f) {
    for (int i = 0; i < fine.count(); ++i)
      for (int k = fine.begin[i]; k < fine.begin[i + 1]; ++k)
        if (const int a = level.of[i], b = level.of[fine.column[k]]; a <= b && a >= 0) f(i, k, entry_of(coarse, a, b));
  };
  Array<std::int32_t> shares(coarse.column.size(), 0), row(coarse.column.size()), order;
  for_each_share([&](int, int, int entry) { ++shares[entry]; });
  for (int a = 0; a < coarse.count(); ++a)
    for (int k = coarse.begin[a]; k < coarse.begin[a + 1]; ++k) {
      row[k] = a;
      if (coarse.column[k] >= a) order.push_back(k);
    }
  for (std::size_t begin = 0; begin < order.size(); begin += window)
    std::stable_sort(order.begin() + begin, order.begin() + std::min(begin + window, order.size()),
                     [&](int k, int l) { return shares[k] > shares[l]; });

  const Places coarse_place = {coarse, 2}, fine_place = {fine, level.parts};
  Array<std::int32_t> next(coarse.column.size());
  level.diagonal.resize(coarse.count());
  for (const int k : order) {
    const int mirrored = entry_of(coarse, coarse.column[k], row[k]);
    if (coarse.column[k] == row[k]) level.diagonal[row[k]] = level.couplings();
    auto& coupling = level.coupling.emplace_back();
    for (int p = 0; p < 2; ++p)
      for (int q = 0; q < 2; ++q) {
        coupling.place[p][q] = coarse_place(row[k], k, p, q);
        coupling.mirrored[p][q] = coarse_place(coarse.column[k], mirrored, q, p);
      }
    next[k] = level.first_share.back();
    level.first_share.push_back(next[k] + shares[k]);
  }
  const int parts = level.parts;
  level.i.resize(level.first_share.back()), level.j.resize(level.first_share.back());
  level.share.resize(static_cast<std::size_t>(parts) * parts * level.first_share.back());
  for_each_share([&](int i, int k, int entry) {
    const std::size_t s = next[entry]++;
    level.i[s] = i, level.j[s] = fine.column[k];
    for (int p = 0; p < parts; ++p)
      for (int q = 0; q < parts; ++q) level.share[(s * parts + p) * parts + q] = fine_place(i, k, p, q);
  });
}

}  // namespace

template <class Real>
Coarsening<Real> make_coarsening(const Body<Real>& body, const Pattern& pattern) {
  Coarsening<Real> coarsening;
  Graph graph = {pattern.begin, pattern.column};
  std::vector<Cluster> clusters(body.nodes);
  for (int n = 0; n < body.nodes; ++n)
    clusters[n].nodes = 1, clusters[n].centre = {body.rest.x[n], body.rest.y[n], body.rest.z[n]};
  if (pattern.blocks() == 0) return coarsening;
  do {
    const bool of_nodes = coarsening.level.empty();
    CoarseLevel<Real> level;
    level.parts = of_nodes ? 1 : 2;
    level.of = aggregates_of(graph, of_nodes ? reach_of_nodes : reach_of_aggregates);
    set_members(*std::ranges::max_element(level.of) + 1, level);
    clusters = set_arms(clusters, level);
    Graph coarse = graph_of(graph, level);
    set_matrix(coarse, level);
    set_couplings(graph, coarse, level);
    const bool is_smaller = level.count() < graph.count();
    graph = std::move(coarse);
    if (of_nodes || is_smaller) coarsening.level.push_back(std::move(level));
    if (!is_smaller) break;
  } while (graph.count() > most_at_last);
  return coarsening;
}

template Coarsening<float> make_coarsening(const Body<float>& body, const Pattern& pattern);
template Coarsening<double> make_coarsening(const Body<double>& body, const Pattern& pattern);

}  // namespace lockstep::production_face
