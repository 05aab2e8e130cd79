// The Fast Marching Method: the front that starts at the interface passes each point once, the nearest first.
//
// A distance depends on smaller ones alone. So the smallest distance among the points beside the front cannot change any more: its
// point is passed, and its neighbours are tried again. That is Dijkstra's algorithm with the upwind solution for the length of a
// path. Points beside the front are kept in a binary heap, ordered by distance; each knows its place there, so that a distance that
// falls moves it up.
//
// A front is sequential; padded blocks are not: each thread marches through blocks of its own.
//
// Source: [ITJ07] Figure 6; Sethian, PNAS 93 (1996). The contract stands in common/levelset/fast_marching.h.
#include "common/levelset/fast_marching.h"

#include <utility>

#include "common/levelset/blocks.h"
#include "common/levelset/eikonal.h"
#include "common/real.h"

namespace lockstep::levelset::openmp {
namespace {

constexpr int untried = -1, passed = -2;  // else: the place in the heap

// The points beside the front: a binary heap by distance. Points at the same distance come in the order of the field.
class Front {
 public:
  explicit Front(Field<Real>& distance)
      : distance_(distance), place_(make_field<std::int32_t>(distance.nx, distance.ny, distance.nz, 0, untried)) {}

  bool empty() const { return heap_.empty(); }
  bool has_passed(const Point& p) const { return place_(p.x, p.y, p.z) == passed; }
  void pass(const Point& p) { place_(p.x, p.y, p.z) = passed; }

  // A point beside the front comes nearer, or becomes one.
  void bring_to(const Point& p, Real distance) {
    distance_(p.x, p.y, p.z) = distance;
    int& place = place_(p.x, p.y, p.z);
    if (place == untried) {
      place = static_cast<int>(heap_.size());
      heap_.push_back({distance, p});
    }
    heap_[place].distance = distance;
    rise(place);
  }

  // Passes the nearest point.
  Point pass_nearest() {
    const Point nearest = heap_[0].point;
    pass(nearest);
    const Entry last = heap_.back();
    heap_.pop_back();
    if (!heap_.empty()) {
      put(0, last);
      sink(0);
    }
    return nearest;
  }

 private:
  struct Entry {
    Real distance;
    Point point;
    bool operator<(const Entry& other) const { return distance < other.distance; }
  };

  void put(int place, const Entry& entry) {
    heap_[place] = entry;
    place_(entry.point.x, entry.point.y, entry.point.z) = place;
  }

  void rise(int place) {
    const Entry entry = heap_[place];
    for (int above = (place - 1) / 2; place > 0 && entry < heap_[above]; place = above, above = (place - 1) / 2) put(place, heap_[above]);
    put(place, entry);
  }

  void sink(int place) {
    const Entry entry = heap_[place];
    const int size = static_cast<int>(heap_.size());
    for (int below = 2 * place + 1; below < size; below = 2 * place + 1) {
      if (below + 1 < size && heap_[below + 1] < heap_[below]) ++below;
      if (!(heap_[below] < entry)) break;
      put(place, heap_[below]);
      place = below;
    }
    put(place, entry);
  }

  Field<Real>& distance_;
  Field<std::int32_t> place_;
  std::vector<Entry> heap_;
};

// What passed neighbours give a point.
Real from_passed(const Field<Real>& d, const Front& front, const Point& p) {
  const auto at = [&](int dx, int dy, int dz) {
    const Point n = {p.x + dx, p.y + dy, p.z + dz};
    const bool there = n.x >= 0 && n.x < d.nx && n.y >= 0 && n.y < d.ny && n.z >= 0 && n.z < d.nz;
    return there && front.has_passed(n) ? d(n.x, n.y, n.z) : far<Real>;
  };
  return upwind(min(at(-1, 0, 0), at(1, 0, 0)), min(at(0, -1, 0), at(0, 1, 0)), min(at(0, 0, -1), at(0, 0, 1)), d.spacing);
}

void fast_marching_heap(Distances<Real>& distances, Real band) {
  Field<Real>& d = distances.distance;
  Front front(d);
  const auto try_neighbours = [&](const Point& p) {
    for (const auto& [dx, dy, dz] : {Point{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}) {
      const Point n = {p.x + dx, p.y + dy, p.z + dz};
      if (n.x < 0 || n.x >= d.nx || n.y < 0 || n.y >= d.ny || n.z < 0 || n.z >= d.nz || front.has_passed(n)) continue;
      const Real u = from_passed(d, front, n);
      if (u < d(n.x, n.y, n.z) && u <= band) front.bring_to(n, u);
    }
  };
  for (const Point& p : distances.interface) front.pass(p);
  for (const Point& p : distances.interface) try_neighbours(p);
  while (!front.empty()) try_neighbours(front.pass_nearest());
}

}  // namespace

void fast_marching_blocks(Distances<Real>& distances, Real band, int size) {
  const std::vector<Block> blocks = make_blocks(distances, band, size);
  const int count = static_cast<int>(blocks.size());
  // A block reads interface points, which nobody changes, and writes its own points alone. Blocks differ in work, hence dynamic.
#pragma omp parallel for schedule(dynamic)
  for (int b = 0; b < count; ++b) {
    const Block& block = blocks[b];
    Distances<Real> padded = cut_out(distances, block);
    fast_marching_heap(padded, band);
    put_back(padded, block, distances);
  }
}

}  // namespace lockstep::levelset::openmp
