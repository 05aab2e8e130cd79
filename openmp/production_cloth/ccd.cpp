// Continuous collision detection, sixteen pairs at a time through the tests that dismiss pairs.
//
// Both positions of a vertex are first put side by side, so that a vertex of a pair costs one access. Then threads take
// chunks of pairs. The test along the axes takes a pair's axes and both ends at once, pair after pair. What a test
// leaves of a chunk is packed into lanes, so that the dearer ones have full vectors, too. The few pairs that are left
// after all tests are searched for their impact in lanes of double.
//
// What is left does not depend on the order of the tests. The axes come first, or second where a sample says that they
// dismiss little: neighbours on a cloth that hangs are near, but the middle of the step tells them apart.
//
// Each thread keeps what it finds; the impacts of a chunk stand together and in order. They move to their places when
// it is known how many the chunks before have. So the result does not depend on which thread did what.
//
// The contract stands in common/production_cloth/ccd.h, the tests in ccd_filters.h, the search in ccd_impact.h.
#include "common/production_cloth/ccd.h"

#include <omp.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <span>

#include "common/production_cloth/ccd_impact.h"
#include "common/real.h"
#include "common/simd_double.h"
#include "common/simd_records.h"
#include "openmp/failure.h"
#include "openmp/vector_lanes.h"

namespace lockstep::production_cloth {
namespace meeting {

// Lanes of double round as double does.
template <>
inline constexpr double unit<doublev> = unit<double>;
template <>
inline constexpr double least<doublev> = least<double>;

}  // namespace meeting

namespace openmp {
namespace {

using namespace meeting;
using Number = floatv;
using Mask = maskv;
using Vertices = std::array<std::int32_t, 4>;
using Found = CcdMemory::Found;

constexpr int chunk_size = 4096;  // pairs

// Pairs of a chunk: how many, and which.
struct Left {
  int count = 0;
  std::int32_t which[chunk_size + lanes];
};

// The padding, too.
void put_side_by_side(const Vectors<Real>& start, const Vectors<Real>& end, int vertices, Array<Real>& vertex) {
  static constexpr std::int32_t consecutive[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  const Vector3<const Real*> from = pointers(start), to = pointers(end);
  // Sixteen vertices are one thread's.
#pragma omp parallel for schedule(static)
  for (int v = 0; v < vertices; v += lanes) {
    const Vector3<floatv> x = load(from, v), y = load(to, v);
    store_records(&vertex[8 * std::size_t(v)], consecutive, {{x.x, x.y, x.z, 0.f, y.x, y.y, y.z, 0.f}});
  }
}

// Of fewer than sixteen pairs, the rest repeats the first.
LOCKSTEP_INLINE Corners<Number> load_corners(const Array<Real>& vertex, std::span<const ElementPair> pairs,
                                             const std::int32_t* which, int n, const auto& corners_of) {
  std::int32_t corner[4][lanes];
  for (int l = 0; l < lanes; ++l) {
    const Vertices v = corners_of(pairs[which[l < n ? l : 0]]);
    for (int i = 0; i < 4; ++i) corner[i][l] = v[i];
  }
  Corners<Number> x;
  for (int i = 0; i < 4; ++i) {
    const Records r = load_records(vertex.data(), corner[i]);
    x.start[i] = {r.field[0], r.field[1], r.field[2]};
    x.end[i] = {r.field[4], r.field[5], r.field[6]};
  }
  return x;
}

Corners<doublev> to_double(const Corners<Number>& x) {
  const auto wide = [](const Vector3<Number>& v) {
    return Vector3<doublev>{to_double(v.x), to_double(v.y), to_double(v.z)};
  };
  Corners<doublev> y;
  for (int i = 0; i < 4; ++i) y.start[i] = wide(x.start[i]), y.end[i] = wide(x.end[i]);
  return y;
}

// The extents of some vertices along all axes, at the start and at the end: records hold both positions of a vertex
// side by side, as x, y, z and 0.
struct Extents {
  recordv low, high;
};
template <int from, int to>
LOCKSTEP_INLINE Extents extents_of(const Real* vertex, const Vertices& corner) {
  const auto record = [&](int i) { return load_record(lockstep::record_at<8>(vertex, corner[i])); };
  Extents e = {record(from), record(from)};
  for (int i = from + 1; i < to; ++i) e = {min(e.low, record(i)), max(e.high, record(i))};
  return e;
}

// Of n pairs, those that the test of ccd_filters.h along the axes does not dismiss; the k-th is pair number_of(k). One
// pair after another: to fill lanes would take longer than the test. Pairs of one first element follow each other, so
// that its extents are kept.
template <Kind kind>
LOCKSTEP_INLINE void keep_near(const Real* vertex, std::span<const ElementPair> pairs, const auto& corners_of, int n,
                               const auto& number_of, Left& left) {
  Extents a = {};
  left.count = 0;
  for (int k = 0, first = -1; k < n; ++k) {
    const int number = number_of(k);
    const Vertices corner = corners_of(pairs[number]);
    if (pairs[number].a != first) first = pairs[number].a, a = extents_of<0, first_of<kind>>(vertex, corner);
    const Extents b = extents_of<first_of<kind>, 4>(vertex, corner);
    const std::uint32_t below = less(a.high, b.low), above = less(b.high, a.low);
    left.which[left.count] = number;
    left.count += ((below & below >> 4) | (above & above >> 4)) == 0;
  }
}

// Keeps those of `left` that `dismissed` does not dismiss, in order.
LOCKSTEP_INLINE void keep(Left& left, const auto& dismissed) {
  int kept = 0;
  for (int k = 0; k < left.count; k += lanes) {
    const Mask stays = first_lanes(left.count - k) & !dismissed(left.which + k, left.count - k);
    store(left.which + kept, compress(stays, load(left.which + k)));
    kept += count(stays);
  }
  left.count = kept;
}

template <Kind kind>
void find(const Array<Real>& vertex, std::span<const ElementPair> pairs, const auto& corners_of,
          std::vector<Found>& found) {
  const int n = static_cast<int>(pairs.size());
  Left left;
  const auto keep_near_of = [&](int some, const auto& number_of) {
    keep_near<kind>(vertex.data(), pairs, corners_of, some, number_of, left);
  };
  const auto keep_not_apart_midway = [&] {
    keep(left, [&](const std::int32_t* which, int n) {
      return apart_midway<kind>(spans_of(load_corners(vertex, pairs, which, n, corners_of)));
    });
  };
  constexpr int apart = 64;  // pairs of the sample
  const int asked = (n + apart - 1) / apart;
  keep_near_of(asked, [](int k) { return apart * k; });
  if (2 * left.count > asked) {
    std::iota(left.which, left.which + n, 0), left.count = n;
    keep_not_apart_midway();
    keep_near_of(left.count, [&](int k) { return left.which[k]; });
  } else {
    keep_near_of(n, [](int k) { return k; });
    keep_not_apart_midway();
  }
  keep(left, [&](const std::int32_t* which, int n) {
    return never_in_plane(cubic_of(spans_of(load_corners(vertex, pairs, which, n, corners_of))));
  });
  keep(left, [&](const std::int32_t* which, int n) {
    return apart_in_quarters<kind>(spans_of(load_corners(vertex, pairs, which, n, corners_of)));
  });
  for (int k = 0; k < left.count; k += lanes) {
    const std::int32_t* which = left.which + k;
    const int n = left.count - k;
    Impact<doublev> impact;
    const Mask meets = find_impact<kind>(to_double(load_corners(vertex, pairs, which, n, corners_of)), impact);
    const doublev normal[4] = {impact.normal.x, impact.normal.y, impact.normal.z, impact.time};
    float weight_of[4][lanes], normal_of[4][lanes];
    for (int i = 0; i < 4; ++i)
      store(weight_of[i], to_float(impact.weight[i])), store(normal_of[i], to_float(normal[i]));
    for (std::uint32_t rest = bits(meets & first_lanes(n)); rest != 0; rest &= rest - 1) {
      const int l = std::countr_zero(rest);
      const Vertices corner = corners_of(pairs[which[l]]);
      Found& f = found.emplace_back();
      for (int i = 0; i < 4; ++i) f.corner[i] = corner[i], f.weight[i] = weight_of[i][l], f.normal[i] = normal_of[i][l];
    }
  }
}

std::span<const ElementPair> chunk_of(const Array<ElementPair>& pairs, std::size_t chunk) {
  const std::size_t begin = chunk * chunk_size;
  return std::span(pairs).subspan(begin, std::min<std::size_t>(chunk_size, pairs.size() - begin));
}
std::size_t chunks_of(const Array<ElementPair>& pairs) { return (pairs.size() + chunk_size - 1) / chunk_size; }

}  // namespace

void ccd(const Topology& topology, const ElementPairs& pairs, const Vectors<Real>& start, const Vectors<Real>& end,
         CcdMemory& memory, Contacts<Real>& impacts) {
  Array<float>& vertex = memory.vertex;
  std::vector<std::vector<Found>>& found = memory.found;
  std::vector<CcdMemory::Part>& part = memory.part;
  std::vector<std::size_t>& before = memory.before;
  const std::size_t of_triangles = chunks_of(pairs.point_triangle), chunks = of_triangles + chunks_of(pairs.edge_edge);
  vertex.resize(8 * padded(topology.vertices));
  found.resize(std::max<std::size_t>(found.size(), omp_get_max_threads()));
  for (std::vector<Found>& of_thread : found) of_thread.clear();
  part.resize(chunks), before.resize(chunks + 1);
  put_side_by_side(start, end, topology.vertices, vertex);

  lockstep::openmp::Failure failure;
  // A thread appends to its own list; a chunk's part is its thread's alone. Chunks differ in work, hence dynamic.
#pragma omp parallel for schedule(dynamic)
  for (std::size_t chunk = 0; chunk < chunks; ++chunk)
    failure.guard([&] {
      const int thread = omp_get_thread_num();
      std::vector<Found>& mine = found[thread];
      const auto begin = static_cast<int>(mine.size());
      if (chunk < of_triangles)
        find<Kind::point_triangle>(
            vertex, chunk_of(pairs.point_triangle, chunk),
            [&](const ElementPair& p) { return corners_of_point_triangle(topology, p); }, mine);
      else
        find<Kind::edge_edge>(
            vertex, chunk_of(pairs.edge_edge, chunk - of_triangles),
            [&](const ElementPair& p) { return corners_of_edge_edge(topology, p); }, mine);
      part[chunk] = {thread, begin, static_cast<int>(mine.size())};
    });
  failure.rethrow();

  before[0] = 0;
  for (std::size_t chunk = 0; chunk < chunks; ++chunk)
    before[chunk + 1] = before[chunk] + (part[chunk].end - part[chunk].begin);
  impacts.resize(before[chunks]);
  // A chunk's impacts have places of their own.
#pragma omp parallel for schedule(static)
  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    std::size_t to = 4 * before[chunk];
    for (int k = part[chunk].begin; k < part[chunk].end; ++k, to += 4) {
      const Found& f = found[part[chunk].thread][k];
      std::copy(f.corner, f.corner + 4, &impacts.corner[to]);
      std::copy(f.weight, f.weight + 4, &impacts.weight[to]);
      std::copy(f.normal, f.normal + 4, &impacts.normal[to]);
    }
  }
}

}  // namespace openmp
}  // namespace lockstep::production_cloth
