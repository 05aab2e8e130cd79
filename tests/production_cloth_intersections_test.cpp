// Where a cloth passes through itself: against the exact signs of integers, all pairs one by one, and cases by hand.
#include "common/production_cloth/intersections.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "common/convert.h"
#include "common/production_cloth/orientation.h"
#include "common/production_cloth/scene.h"
#include "common/production_cloth/sheets.h"
#include "tests/temporary_folder.h"

namespace lockstep::production_cloth {
namespace {

using Point = Vector3<float>;
using Corners = std::array<Point, 3>;

// Coordinates below 2^20 in magnitude: the determinant is below 6 * 2^63, and exact in 128 bits.
int sign_in_integers(const Point& a, const Point& b, const Point& c, const Point& d) {
  using Wide = __int128;
  const auto minus_a = [&](const Point& p) {
    return Vector3<Wide>{Wide(p.x) - Wide(a.x), Wide(p.y) - Wide(a.y), Wide(p.z) - Wide(a.z)};
  };
  const Wide determinant = dot(minus_a(b), cross(minus_a(c), minus_a(d)));
  return determinant > 0 ? 1 : determinant < 0 ? -1 : 0;
}

TEST(ProductionClothOrientation, HasTheSignOfTheDeterminant) {
  std::mt19937 random(3);
  int flat = 0;
  for (int k = 0; k < 50'000; ++k) {
    // Points on a plane through a lattice, and off it by one unit or none: a double cannot tell.
    const int bits = 1 + k % 19;
    const auto number = [&] { return static_cast<float>(static_cast<int>(random() % (2u << bits)) - (1 << bits)); };
    const auto on_plane = [&] {
      const float u = number(), v = number();
      return Point{u, v, (u + v) / 2 == std::floor((u + v) / 2) ? (u + v) / 2 : u};
    };
    const Point a = on_plane(), b = on_plane(), c = on_plane();
    Point d = on_plane();
    d.z += static_cast<float>(static_cast<int>(random() % 3) - 1);
    const int expected = sign_in_integers(a, b, c, d);
    flat += expected == 0;
    EXPECT_EQ(orient3d(a, b, c, d), expected);
    EXPECT_EQ(orient3d(b, a, c, d), -expected);
    // Powers of two change no sign, however far the filter is from the sum then.
    const auto scaled = [](const Point& p) { return Point{0x1p-120f * p.x, 0x1p90f * p.y, 0x1p-60f * p.z}; };
    EXPECT_EQ(orient3d(scaled(a), scaled(b), scaled(c), scaled(d)), expected);
    EXPECT_EQ(orient2d({a.x, a.y}, {b.x, b.y}, {c.x, c.y}),
              sign_in_integers({a.x, a.y, 0}, {b.x, b.y, 0}, {c.x, c.y, 0}, {a.x, a.y, 1}));
  }
  EXPECT_GT(flat, 1'000);
}

// Vectors whose determinant is `off`, out of products near 2^66 that cancel: a double's rounding exceeds it.
TEST(ProductionClothOrientation, DecidesWhatDoublesRoundAway) {
  std::mt19937 random(5);
  for (int k = 0; k < 1'000; ++k) {
    const auto n = static_cast<float>((1 << 21) + static_cast<int>(random() % (1u << 21)));
    const Point a = {static_cast<float>(k), static_cast<float>(-3 * k), 7};
    for (const float off : {-1.f, 0.f, 1.f}) {
      const Point b = a + Point{n, n + 1, n}, c = a + Point{n - 1, n, n - 1},
                  d = a + Point{2 * n - 1, 2 * n + 1, 2 * n - 1 + off};
      EXPECT_EQ(orient3d(a, b, c, d), static_cast<int>(off));
      EXPECT_EQ(sign_in_integers(a, b, c, d), static_cast<int>(off));
    }
  }
  constexpr float one = 1, least = 0x1p-149f, most = 0x1p127f;
  EXPECT_EQ(orient3d({0, 0, 0}, {one, 0, 0}, {0, one, 0}, {most, most, least}), 1);
  EXPECT_EQ(orient3d({0, 0, least}, {most, most, 0}, {most, least, 0}, {0, 0, 0}), 1);
  // (1, 1), (2^24, 2^24) and a point beside the line by the least step there.
  const float large = 0x1p24f;
  EXPECT_EQ(orient2d({least, least}, {large, large}, {one, one}), 0);
  EXPECT_EQ(orient2d({least, least}, {large, large}, {one, std::nextafter(one, 2.f)}), 1);
  EXPECT_EQ(orient2d({0, least}, {large, large}, {one, one}), -1);
  EXPECT_EQ(orient2d({least, 0}, {large, large}, {one, one}), 1);
}

constexpr Corners triangle = {Point{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};

TEST(ProductionClothIntersections, EdgeAndTriangleByHand) {
  const auto meets = [](const Point& p, const Point& q) {
    const auto [a, b, c] = triangle;
    const bool once = edge_meets_triangle(p, q, triangle);
    // However the two are turned or mirrored.
    for (const Corners& same : {Corners{b, c, a}, Corners{a, c, b}, Corners{c, b, a}}) {
      EXPECT_EQ(edge_meets_triangle(p, q, same), once);
      EXPECT_EQ(edge_meets_triangle(q, p, same), once);
    }
    const auto turned = [](const Point& v) { return Point{v.z, v.x, v.y}; };
    const auto again = [&](const Point& v) { return turned(turned(v)); };
    EXPECT_EQ(edge_meets_triangle(turned(p), turned(q), {turned(a), turned(b), turned(c)}), once);
    EXPECT_EQ(edge_meets_triangle(again(p), again(q), {again(a), again(b), again(c)}), once);
    return once;
  };
  const float little = 0x1p-40f;
  EXPECT_TRUE(meets({1, 1, -1}, {1, 1, 1}));       // through the middle
  EXPECT_FALSE(meets({1, 1, little}, {1, 1, 1}));  // above it
  EXPECT_TRUE(meets({1, 1, 0}, {1, 1, 1}));        // stands on it
  EXPECT_TRUE(meets({2, 2, -1}, {2, 2, 1}));       // through a side
  EXPECT_TRUE(meets({4, 0, -1}, {4, 0, 1}));       // through a corner
  EXPECT_FALSE(meets({3, 2, -1}, {3, 2, 1}));      // beside it
  EXPECT_FALSE(meets({2, -little, -1}, {2, -little, 1}));
  EXPECT_FALSE(meets({5, -1, -1}, {5, -1, 1}));      // on the line of a side, and of none
  EXPECT_TRUE(meets({1, 1, 0}, {2, 1, 0}));          // in the plane: inside
  EXPECT_TRUE(meets({-1, 1, 0}, {9, 1, 0}));         // across
  EXPECT_TRUE(meets({3, 3, 0}, {2, 2, 0}));          // touches a side
  EXPECT_TRUE(meets({2, 0, 0}, {7, 0, 0}));          // along a side
  EXPECT_TRUE(meets({0, 4, 0}, {0, 9, 0}));          // from a corner
  EXPECT_FALSE(meets({4.5, 0, 0}, {9, 0, 0}));       // on a side's line
  EXPECT_FALSE(meets({3, 3, 0}, {9, 9, 0}));         // beyond
  EXPECT_FALSE(meets({3.5f, -1, 0}, {5.5f, 1, 0}));  // past a corner: only its own line parts them
  EXPECT_TRUE(meets({1, 1, 0}, {1, 1, 0}));          // a point
  EXPECT_FALSE(meets({3, 3, 0}, {3, 3, 0}));
}

TEST(ProductionClothIntersections, ATriangleWithoutAnAreaMeetsWhatItsBoxMeets) {
  const Corners line = {Point{0, 0, 0}, {4, 4, 4}, {1, 1, 1}};
  EXPECT_TRUE(edge_meets_triangle({0, 1, 0}, {1, 1, 0}, line));
  EXPECT_FALSE(edge_meets_triangle({0, 5, 0}, {1, 5, 0}, line));
}

// A sheet, rolled into a spiral whose turns are `gap` apart, or cross each other where it is negative.
struct Rolled {
  Topology topology;
  Vectors<float> position;

  Rolled(int columns, int rows, double gap) {
    const Mesh mesh = renumbered(make_sheet({{0, 0, 0}, {3, 0, 0}, {0, 0, 1}, {columns, rows}}));
    const int n = static_cast<int>(mesh.points.size());
    topology = make_topology(n, mesh.triangles, "sheet");
    position.resize(n);
    for (int i = 0; i < n; ++i) {
      const Vector3<double>& p = mesh.points[i];
      const double radius = .2 + gap * (p.x / 1.2 + (gap < 0) * std::sin(3 * p.x)), angle = 5 * p.x;
      store(position, i, convert<float>(Vector3<double>{radius * std::cos(angle), radius * std::sin(angle), p.z}));
    }
  }
};

std::size_t count_all(const Topology& t, const Vectors<float>& position) {
  std::size_t count = 0;
  for (const auto& [a, b] : t.edges)
    for (std::size_t k = 0; k < t.triangles.size(); ++k) {
      const auto corner = t.corners(k);
      if (std::ranges::count(corner, a) > 0 || std::ranges::count(corner, b) > 0) continue;
      count += edge_meets_triangle(load(position, a), load(position, b),
                                   {load(position, corner[0]), load(position, corner[1]), load(position, corner[2])});
    }
  return count;
}

TEST(ProductionClothIntersections, OfAClothAreThoseOfAllPairs) {
  for (const auto& [columns, rows] : {std::pair{1, 1}, {2, 4}, {5, 3}, {60, 9}}) {
    const Rolled apart(columns, rows, .05), crossed(columns, rows, -.05);
    for (const Rolled* rolled : {&apart, &crossed}) {
      const std::size_t count = count_intersections(rolled->topology, rolled->position);
      EXPECT_EQ(count, count_all(rolled->topology, rolled->position));
      EXPECT_EQ(first_intersection(rolled->topology, rolled->position).has_value(), count > 0);
    }
  }
  const Rolled apart(60, 9, .05), crossed(60, 9, -.05);
  EXPECT_EQ(count_intersections(apart.topology, apart.position), 0u);
  EXPECT_GT(count_intersections(crossed.topology, crossed.position), 100u);
  EXPECT_EQ(count_intersections(make_topology(0, {}, "nothing"), {}), 0u);
}

// A flat sheet, upright, tilted and turned, lies in one plane, or nearly: neighbours that do not touch must not count.
TEST(ProductionClothIntersections, AFlatSheetHasNone) {
  for (const Vector3<double>& down : {Vector3<double>{0, 0, 1}, {0, 1, 0}, {.1, .7, .3}, {1, 1, 0}}) {
    const Mesh mesh = renumbered(make_sheet({{.1, .2, .3}, {1, 0, .3}, down, {20, 17}}));
    Vectors<float> position;
    position.resize(mesh.points.size());
    for (std::size_t i = 0; i < mesh.points.size(); ++i) store(position, i, convert<float>(mesh.points[i]));
    const Topology topology = make_topology(static_cast<int>(mesh.points.size()), mesh.triangles, "sheet");
    EXPECT_EQ(count_intersections(topology, position), 0u);
  }
}

struct ProductionClothStart : TemporaryFolder {
  std::string error(const std::string& text) const {
    write_bytes(path("a.toml"), "kind = \"production_cloth\"\n" + text);
    return error_of([&] { load_scene(path("a.toml")); });
  }
};

constexpr const char* lower = "[[sheet]]\norigin = [0, 0, 0]\nacross = [1, 0, 0]\ndown = [0, 0, 1]\nsquares = [1, 1]\n";

TEST_F(ProductionClothStart, ThatIntersectsIsRefused) {
  const std::string upright =
      "[[sheet]]\norigin = [0.3, -0.5, 0.2]\nacross = [0, 1, 0]\ndown = [0, 0, 0.1]\nsquares = [1, 1]\n";
  EXPECT_EQ(error(std::string(lower) + upright),
            path("a.toml") +
                ": triangle 3 of vertices 5, 6, 7 and triangle 1 of vertices 1, 2, 3 intersect or touch, near (0.3, "
                "-0.5, 0.2) m");
}

// Two sheets, one on the other: a gap of the least float is a start, none is not.
TEST_F(ProductionClothStart, ThatTouchesIsRefused) {
  const auto sheet_at = [](const std::string& height) {
    return "[[sheet]]\norigin = [0.5, " + height + ", 0.5]\nacross = [1, 0, 0]\ndown = [0, 0, 1]\nsquares = [3, 3]\n";
  };
  EXPECT_NE(error(lower + sheet_at("0")).find("intersect or touch"), std::string::npos);
  EXPECT_EQ(error(lower + sheet_at("1e-44")), "no error");
}

}  // namespace
}  // namespace lockstep::production_cloth
