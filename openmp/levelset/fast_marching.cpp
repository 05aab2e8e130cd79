// The Fast Marching Method: the front that starts at the interface accepts each point once, the nearest first.
//
// A distance depends on smaller ones alone. So the smallest distance among the trial points, those beside the front,
// cannot change any more: its point is accepted, and its neighbours are tried again. That is Dijkstra's algorithm with
// the upwind solution for the length of a path. A binary heap holds the trial points (common/levelset/front.h).
//
// A front is sequential; padded blocks are not: each thread marches through blocks of its own.
//
// Source: [ITJ07] Figure 6; Sethian, PNAS 93 (1996). The contract stands in common/levelset/fast_marching.h.
#include "common/levelset/fast_marching.h"

#include "common/levelset/blocks.h"
#include "common/levelset/eikonal.h"
#include "common/levelset/front.h"
#include "common/real.h"
#include "openmp/failure.h"

namespace lockstep::levelset::openmp {
namespace {

using namespace lockstep::openmp;

// The upwind solution at a point from its accepted neighbours.
Real from_accepted(const Field<Real>& d, const Front<Real>& front, const Point& p) {
  const std::size_t here = d.index(p.x, p.y, p.z), line = d.pitch, plane = d.ny * line;
  const auto at = [&](std::size_t index) { return front.has_accepted(index) ? d.value[index] : far<Real>; };
  // Of the two neighbours along an axis of n points, `stride` values apart; i is the point's coordinate along it.
  const auto nearer = [&](int i, int n, std::size_t stride) {
    return min(i > 0 ? at(here - stride) : far<Real>, i < n - 1 ? at(here + stride) : far<Real>);
  };
  return upwind(nearer(p.x, d.nx, 1), nearer(p.y, d.ny, line), nearer(p.z, d.nz, plane), d.spacing);
}

void fast_marching_heap(Distances<Real>& distances, Real band) {
  Field<Real>& d = distances.distance;
  Front<Real> front(d);
  const auto try_neighbours = [&](const Point& p) {
    for (const auto& [dx, dy, dz] : {Point{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}) {
      const Point n = {p.x + dx, p.y + dy, p.z + dz};
      if (n.x < 0 || n.x >= d.nx || n.y < 0 || n.y >= d.ny || n.z < 0 || n.z >= d.nz || front.has_accepted(n)) continue;
      const Real u = from_accepted(d, front, n);
      if (u < d(n.x, n.y, n.z) && u <= band) front.lower(n, u);
    }
  };
  for (const Point& p : distances.interface) front.accept(p);
  for (const Point& p : distances.interface) try_neighbours(p);
  while (!front.empty()) try_neighbours(front.accept_nearest());
}

}  // namespace

void fast_marching_blocks(Distances<Real>& distances, Real band, int size) {
  const std::vector<Block> blocks = make_blocks(distances, band, size);
  const int count = static_cast<int>(blocks.size());
  Failure failure;
  // A block reads interface points, which no thread changes, and writes its own points alone. Blocks differ in work,
  // hence dynamic.
#pragma omp parallel for schedule(dynamic)
  for (int b = 0; b < count; ++b)
    failure.guard([&] {
      const Block& block = blocks[b];
      Distances<Real> padded = cut_out(distances, block);
      fast_marching_heap(padded, band);
      put_back(padded, block, distances);
    });
  failure.rethrow();
}

}  // namespace lockstep::levelset::openmp
