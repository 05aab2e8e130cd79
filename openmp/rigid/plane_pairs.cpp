// Planes against everything: they are unbounded, so the other broad phases do not pair them.
//
// A box reaches below a plane if its lowest corner does; the signs of the normal say which corner that is. There are
// few planes, so every box is tested against each plane. The pairs of a collider are made together, where it is the
// smaller of the two numbers: this gives the order of the contract.
//
// The runs of colliders in that order are cut into strips. Threads take strips dynamically and test sixteen boxes at
// once. Each strip has a list of its own; the lists are joined in order when all are complete.
//
// Source: Ericson, Real-Time Collision Detection (2005), 5.2.3. The contract stands in common/rigid/broad_phase.h.
#include <algorithm>
#include <bit>

#include "common/math.h"
#include "common/real.h"
#include "common/rigid/broad_phase.h"
#include "common/rigid/reach.h"
#include "common/simd.h"
#include "openmp/failure.h"
#include "openmp/spatial/boxes.h"

namespace lockstep::rigid::openmp {
namespace {

using namespace lockstep::openmp;
using namespace spatial::openmp;

struct Plane {
  std::int32_t collider, group;
  Vector3<Real> normal, point;
};

std::vector<Plane> planes_of(const Colliders<Real>& colliders, std::span<const Pose<Real>> placed) {
  std::vector<Plane> planes;
  for (int first = 0; first < colliders.count; first += lanes) {
    const intv kind = load(&colliders.kind[first], first_lanes(colliders.count - first));
    if (none(first_lanes(colliders.count - first) & (kind == static_cast<std::int32_t>(Kind::plane)))) continue;
    for (int i = first; i < std::min(first + lanes, colliders.count); ++i)
      if (colliders.kind[i] == static_cast<std::int32_t>(Kind::plane))
        planes.push_back({i, colliders.group[i], matrix_of(placed[i].orientation).y, placed[i].position});
  }
  return planes;
}

// Colliders begin .. end - 1 with planes first .. last - 1.
struct Strip {
  int begin, end;
  std::size_t first, last;
};

void cut_into_strips(int begin, int end, std::size_t first, std::size_t last, std::vector<Strip>& strips) {
  constexpr int length = 1024;
  for (int i = begin; i < end && first < last; i += length)
    strips.push_back({i, std::min(i + length, end), first, last});
}

}  // namespace

void plane_pairs(const Colliders<Real>& colliders, std::span<const Pose<Real>> placed, const Bounds<Real>& bounds,
                 Pairs& pairs) {
  const std::vector<Plane> planes = planes_of(colliders, placed);
  const auto touch = [&](const Plane& plane, int i, maskv inside) {
    const Box<floatv> box = load_boxes(bounds, i);
    const maskv below = inside & bounded(box) & (lowest_corner(box, plane.normal, plane.point) <= 0.f);
    // Most boxes are above all planes: their groups need not be loaded.
    return none(below) ? below : below & (plane.group != load(&colliders.group[i], inside));
  };
  // Not inlined: inlined into the guarded loop below, it took 71 us instead of 63 (boxes_100k, one thread, AVX-512).
  const auto pairs_of = [&](const Strip& strip) __attribute__((noinline)) {
    const auto [begin, end, first, last] = strip;
    Pairs result;
    std::vector<std::uint32_t> below(last - first);  // [plane]: which of sixteen boxes reach below it
    for (int i = begin; i < end; i += lanes) {
      std::uint32_t any = 0;
      for (std::size_t q = first; q < last; ++q)
        any |= below[q - first] = bits(touch(planes[q], i, first_lanes(end - i)));
      for (std::uint32_t set = any; set != 0; set &= set - 1) {
        const int l = std::countr_zero(set);
        for (std::size_t q = first; q < last; ++q)
          if (below[q - first] >> l & 1) result.push_back(make_pair(i + l, planes[q].collider));
      }
    }
    return result;
  };

  std::vector<Strip> strips;
  int begin = 0;
  for (std::size_t p = 0; p <= planes.size(); ++p) {
    // Colliders before the next plane, each with that plane and all later ones; then that plane with all later
    // colliders.
    const int end = p < planes.size() ? planes[p].collider : colliders.count;
    cut_into_strips(begin, end, p, planes.size(), strips);
    if (p < planes.size()) cut_into_strips(end + 1, colliders.count, p, p + 1, strips);
    begin = end + 1;
  }

  std::vector<Pairs> found(strips.size());
  Failure failure;
  // Iterations are independent: a strip has its own list.
#pragma omp parallel for schedule(dynamic)
  for (std::size_t s = 0; s < strips.size(); ++s) failure.guard([&] { found[s] = pairs_of(strips[s]); });
  failure.rethrow();
  pairs.clear();
  for (const Pairs& strip : found) pairs.insert(pairs.end(), strip.begin(), strip.end());
}

}  // namespace lockstep::rigid::openmp
