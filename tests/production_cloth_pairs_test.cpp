// The trees of a cloth's elements, and the pairs found in them: against all pairs, one by one.
#include "common/production_cloth/pairs.h"

#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "common/convert.h"
#include "common/production_cloth/bvh.h"
#include "common/production_cloth/sheets.h"

namespace lockstep::production_cloth {
namespace {

// A cloth somewhere between start and end.
struct MovingCloth {
  Topology topology;
  Vectors<float> start, end;
};

// A strip of so many triangles, with random places of vertices near a curve that comes back to itself.
MovingCloth strip(int triangles, unsigned seed) {
  std::vector<Triangle> list;
  for (int t = 0; t < triangles; ++t) list.push_back(t % 2 ? Triangle{t + 1, t, t + 2} : Triangle{t, t + 1, t + 2});
  MovingCloth cloth = {make_topology(triangles + 2, list, "strip"), {}, {}};
  cloth.start.resize(triangles + 2), cloth.end.resize(triangles + 2);
  std::mt19937 random(seed);
  const auto number = [&] { return static_cast<float>(random() >> 8) / (1 << 24) - .5f; };
  for (int i = 0; i < triangles + 2; ++i) {
    const Vector3<float> p = {std::sin(.3f * i) + .1f * number(), std::cos(.7f * i), .3f * number()};
    store(cloth.start, i, p);
    store(cloth.end, i, p + Vector3<float>{.1f * number(), .1f * number(), .1f * number()});
  }
  return cloth;
}

// A tube whose far end is turned by so many radians about its axis, over so many squares, and turns on.
MovingCloth twisted_tube(int around, int along, double turn) {
  const Mesh mesh = renumbered(make_tube({{0, 0, 0}, {1, 0, 0}, .2, {around, along}}));
  const int n = static_cast<int>(mesh.points.size());
  MovingCloth cloth = {make_topology(n, mesh.triangles, "tube"), {}, {}};
  cloth.start.resize(n), cloth.end.resize(n);
  for (int i = 0; i < n; ++i) {
    const auto& p = mesh.points[i];
    const auto turned = [&](double by) {
      const double c = std::cos(by * p.x), s = std::sin(by * p.x), narrow = 1 - .9 * std::sin(3.14159 * p.x);
      return convert<float>(Vector3<double>{p.x, narrow * (c * p.y - s * p.z), narrow * (s * p.y + c * p.z)});
    };
    store(cloth.start, i, turned(turn));
    store(cloth.end, i, turned(turn + .1));
  }
  return cloth;
}

std::vector<MovingCloth> cloths() {
  std::vector<MovingCloth> all;
  for (const int triangles : {1, 2, 3, 13, 14, 15, 16, 17, 31, 32, 33, 255, 256, 257, 300})
    all.push_back(strip(triangles, static_cast<unsigned>(triangles)));
  all.push_back(twisted_tube(12, 30, 6));
  all.push_back({make_topology(0, {}, "nothing"), {}, {}});
  all.back().start.resize(0), all.back().end.resize(0);
  return all;
}

ElementPairs all_pairs(const Topology& t, const SearchBoxes<float>& boxes) {
  ElementPairs pairs;
  for (std::int32_t v = 0; v < t.vertices; ++v)
    for (std::int32_t k = 0; k < static_cast<std::int32_t>(t.triangles.size()); ++k) {
      const auto corner = t.corners(k);
      const bool common = std::ranges::count(corner, v) > 0;
      if (!common && overlap(boxes.vertices.box(v), boxes.triangles.box(k))) pairs.point_triangle.push_back({v, k});
    }
  for (std::int32_t e = 0; e < static_cast<std::int32_t>(t.edges.size()); ++e)
    for (std::int32_t f = e + 1; f < static_cast<std::int32_t>(t.edges.size()); ++f) {
      const bool common =
          std::ranges::any_of(t.edges[e], [&](auto v) { return std::ranges::count(t.edges[f], v) > 0; });
      if (!common && overlap(boxes.edges.box(e), boxes.edges.box(f))) pairs.edge_edge.push_back({e, f});
    }
  return pairs;
}

// Both twins, one after another into the same arrays, so that what a larger cloth left must go.
TEST(ProductionClothPairs, AreAllPairsOnceAndInOrder) {
  ElementPairs serial_pairs, openmp_pairs;
  SearchBoxes<float> serial_boxes, openmp_boxes;
  for (const float margin : {0.f, .01f, .3f})
    for (const MovingCloth& cloth : cloths()) {
      const Search search = make_search(cloth.topology);
      serial::refit(search, cloth.start, cloth.end, margin, serial_boxes);
      serial::find_pairs(search, serial_boxes, serial_pairs);
      const ElementPairs expected = all_pairs(cloth.topology, serial_boxes);
      EXPECT_EQ(serial_pairs.point_triangle, expected.point_triangle) << cloth.topology.triangles.size();
      EXPECT_EQ(serial_pairs.edge_edge, expected.edge_edge) << cloth.topology.triangles.size();
      for (const int threads : {1, 2, 3, 8}) {
        omp_set_num_threads(threads);
        openmp::refit(search, cloth.start, cloth.end, margin, openmp_boxes);
        openmp::find_pairs(search, openmp_boxes, openmp_pairs);
        EXPECT_EQ(openmp_pairs.point_triangle, expected.point_triangle) << cloth.topology.triangles.size();
        EXPECT_EQ(openmp_pairs.edge_edge, expected.edge_edge) << cloth.topology.triangles.size();
      }
      omp_set_num_threads(omp_get_num_procs());
    }
  EXPECT_GT(strip(300, 1).topology.edges.size(), 256u);  // so that there were trees of two levels above the elements
}

// Overlap that a double computes from the positions themselves, without any rounding: floats and their sums with the
// margin are doubles. Whatever overlaps in truth overlaps in float and in double boxes.
TEST(ProductionClothPairs, AreNotMissedByRounding) {
  std::mt19937 random(7);
  const auto number = [&] { return static_cast<float>(random() >> 8) / (1 << 24); };
  int exactly_touching = 0;
  for (int k = 0; k < 20'000; ++k) {
    const float margin = k % 4 ? .001f * number() : 0x1p-149f * static_cast<float>(k);
    const float x = k % 4 ? 10 * number() - 5 : margin * number();
    // The nearest float to x + 2 margin that is no farther: the boxes must overlap, and hardly do.
    auto y = static_cast<float>(double(x) + 2 * double(margin));
    if (double(y) - x > 2 * double(margin)) y = std::nextafter(y, -10.f);
    exactly_touching += double(y) - x == 2 * double(margin);
    const Box<float> a = swept_box(Vector3<float>{x, x, x}, {x, x, x}, margin),
                     b = swept_box(Vector3<float>{y, y, y}, {y, y, y}, margin);
    EXPECT_TRUE(overlap(a, b)) << x << ' ' << y << ' ' << margin;
    EXPECT_LE(double(a.low.x), double(x) - margin);
    EXPECT_GE(double(a.high.y), double(x) + margin);
    // Not much wider either: epsilon, and two roundings of half an epsilon each, make two epsilons and a trifle.
    EXPECT_GE(double(a.low.x), double(x) - margin - 3 * 0x1p-23 * std::abs(double(x) - margin) - 0x1p-149);
  }
  EXPECT_GT(exactly_touching, 1'000);
}

// Boxes of edges, triangles and nodes hold those of which they are made, exactly; the padding is empty.
TEST(ProductionClothPairs, BoxesHoldTheirParts) {
  const auto holds = [](const Box<double>& outer, const Box<double>& inner) {
    const Box<double> both = spatial::around(outer, inner);
    return both.low.x == outer.low.x && both.low.y == outer.low.y && both.low.z == outer.low.z &&
           both.high.x == outer.high.x && both.high.y == outer.high.y && both.high.z == outer.high.z;
  };
  for (const MovingCloth& cloth : cloths()) {
    const Search search = make_search(cloth.topology);
    SearchBoxes<double> boxes;
    serial::refit(search, convert<double>(cloth.start), convert<double>(cloth.end), .01, boxes);
    for (std::size_t t = 0; t < cloth.topology.triangles.size(); ++t) {
      for (const std::int32_t v : cloth.topology.corners(t))
        EXPECT_TRUE(holds(boxes.triangles.box(static_cast<int>(t)), boxes.vertices.box(v)));
      for (const std::int32_t e : cloth.topology.edges_of[t])
        EXPECT_TRUE(holds(boxes.triangles.box(static_cast<int>(t)), boxes.edges.box(e)));
    }
    for (const auto& [levels, all] : {std::pair{&search.vertices, &boxes.vertices}, {&search.edges, &boxes.edges}}) {
      int n = levels->elements;
      for (int level = 0; level <= levels->last(); ++level) {
        const int first = levels->first[level], slots = levels->first[level + 1] - first;
        EXPECT_EQ(slots % tree_width, 0);
        for (int i = 0; i < slots; ++i) {
          EXPECT_EQ(all->low.x[first + i] <= all->high.x[first + i], i < n);
          if (level < levels->last()) {
            EXPECT_TRUE(i >= n || holds(all->box(levels->first[level + 1] + i / tree_width), all->box(first + i)));
          }
        }
        n = (n + tree_width - 1) / tree_width;
      }
      EXPECT_LE(levels->first[levels->last() + 1] - levels->first[levels->last()], tree_width);
    }
  }
}

}  // namespace
}  // namespace lockstep::production_cloth
