// Closest points of convex cores: closed forms, the exact oracle (exact_convex.h), separating planes and an independent yes or no (libccd)
// over a million pairs, symmetry, any start, no NaN, and both versions bit by bit.
#include <ccd/ccd.h>
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <type_traits>
#include <vector>

#include "common/rigid/gjk.h"
#include "common/rigid/make.h"
#include "tests/exact_convex.h"
#include "tests/rigid_shapes.h"

namespace lockstep::rigid {
namespace {

using Vector = Vector3<double>;
using Random = std::mt19937;

template <class Real>
constexpr double unit_roundoff = std::numeric_limits<Real>::epsilon() / 2;

// What a distance may be wrong by, of what both shapes and the way between them measure. Placing a corner: the product of two quaternions,
// their matrix, three products and an offset, 16 u. When the walk stops: a step across, up to twice the measure, times two epsilon, 8 u. A
// point between corners: two epsilon for where it is, two for how much farther the next may be, 16 u in its terms. Together 40, and
// something for terms of second order.
constexpr double good = 64;
// Between the corners of a needle, long l and wide w, volumes are about w^2 l, and their rounding about u l^3: where w < sqrt(u) l, it
// hides whether they enclose the origin. GJK then ends with some distance within the needle, w at the most: less than sqrt(u) of the
// measure.
const double least_width = std::sqrt(unit_roundoff<float>);
const double thin_good = 1 / least_width;
// Where the walk is stuck this near to the origin, it calls it an overlap: 32 epsilon of an edge, of up to twice the measure.
constexpr double stuck = 128;
// --- Shapes

double any(Random& random, double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
int any_below(Random& random, int n) { return std::uniform_int_distribution<int>(0, n - 1)(random); }
Vector any_direction(Random& random) {
  std::normal_distribution<double> normal;
  const Vector v = {normal(random), normal(random), normal(random)};
  return 1 / length(v) * v;
}
Vector any_inside(Random& random) { return std::cbrt(any(random, 0, 1)) * any_direction(random); }

std::vector<Vector> points_on_sphere(Random& random, int n) {
  std::vector<Vector> points(n);
  for (Vector& p : points) p = any_direction(random);
  return points;
}

// Vertices without faces, also such as are no hull: flat, in a line, one on another. What GJK reads of a hull, and no more.
int add_vertices(Hulls<double>& hulls, const std::vector<Vector>& points) {
  const int hull = hulls.count++, first = hulls.first_vertex[hull], end = first + static_cast<int>(points.size());
  hulls.vertex.resize(padded(end)), hulls.first_vertex.resize(padded(hull + 2)), hulls.first_face.resize(padded(hull + 2));
  hulls.centre.resize(padded(hull + 1)), hulls.half.resize(padded(hull + 1));
  Vector low = points[0], high = points[0];
  for (int k = first; k < end; ++k) {
    const Vector& p = points[k - first];
    hulls.vertex[k] = {double(float(p.x)), double(float(p.y)), double(float(p.z)), 0};
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const Vector centre = .5 * (low + high), half = .5 * (high - low);
  hulls.centre[hull] = {centre.x, centre.y, centre.z, 0}, hulls.half[hull] = {half.x, half.y, half.z, 0};
  hulls.first_vertex[hull + 1] = end, hulls.first_face[hull + 1] = hulls.first_face[hull];
  hulls.most_vertices = std::max(hulls.most_vertices, end - first);
  return hull;
}

// Twenty of each kind: round ones, all sizes, triangles, flat ones, some with every vertex thrice, grids but for rounding, and needles,
// which are the last of every seven.
constexpr int vertex_kinds = 7;
std::vector<int> add_kinds(Random& random, Hulls<double>& hulls) {
  std::vector<int> added;
  for (int k = 0; k < 20; ++k) {
    const int n = 4 + any_below(random, most_hull_vertices - 3);
    added.push_back(add_vertices(hulls, points_on_sphere(random, 12 + k % 13)));
    added.push_back(add_vertices(hulls, points_on_sphere(random, n)));
    added.push_back(add_vertices(hulls, points_on_sphere(random, 3)));
    std::vector<Vector> flat = points_on_sphere(random, n), needle = flat, thrice = flat, grid = flat;
    const double width = std::pow(10., any(random, -7, -1));
    for (int l = 0; l < n; ++l) {
      flat[l].y = 0;
      needle[l].y *= width, needle[l].z *= width * any(random, 0, 1);
      thrice[l] = thrice[l / 3];
      grid[l] = 1e-6 * grid[l] + Vector{any_below(random, 3) - 1., any_below(random, 3) - 1., any_below(random, 3) - 1.};
    }
    for (const std::vector<Vector>& points : {flat, thrice, grid, needle}) added.push_back(add_vertices(hulls, points));
  }
  return added;
}

// Pairs of colliders, placed: pair k is of colliders 2 k and 2 k + 1.
struct Scene {
  Shapes shapes;
  Pairs pairs;
  std::vector<int> thin;  // hulls: needles that are

  void pair(int a, int b) { pairs.push_back({a, b}); }
  bool has_thin(const Pair& pair) const {
    const auto is_thin = [&](int collider) { return std::count(thin.begin(), thin.end(), shapes.colliders.hull[collider]) > 0; };
    return is_thin(pair.a) || is_thin(pair.b);
  }
};

// Pairs of all kinds, near, far and in one another, some along the axes of the world, some in one place.
Scene all_kinds(Random& random, int pairs) {
  Scene scene;
  Shapes& shapes = scene.shapes;
  const std::vector<int> kinds = add_kinds(random, shapes.hulls);
  for (std::size_t k = vertex_kinds - 1; k < kinds.size(); k += vertex_kinds) {
    const Quad<double>& half = shapes.hulls.half[kinds[k]];
    if (std::max(half.y, half.z) < least_width * half.x) scene.thin.push_back(kinds[k]);
  }
  for (int k = 0; k < pairs; ++k) {
    const bool along_axes = any_below(random, 4) == 0, coincident = any_below(random, 50) == 0;
    const Vector where = std::pow(10., any(random, -1, 1)) * any_inside(random);
    const auto add = [&](const Vector& position) {
      const Pose<double> place = at(position, along_axes ? no_rotation : any_turn(random));
      switch (any_below(random, 6)) {
        case 0: return shapes.sphere(.1, place);
        case 1: return shapes.capsule(any_below(random, 8) == 0 ? 0 : any(random, .1, 1), .1, place);
        case 2: {
          Vector half = {any(random, .2, 1), any(random, .2, 1), any(random, .2, 1)};
          if (along_axes) half = {.5, .5, .5};
          if (any_below(random, 8) == 0) half.y = 0;
          if (any_below(random, 8) == 0) half.x *= 1e-3;
          return shapes.box(half, place);
        }
        default: return shapes.hull(kinds[any_below(random, static_cast<int>(kinds.size()))], place);
      }
    };
    const int a = add(where);
    Vector step = any(random, 0, 2.8) * any_direction(random);
    if (along_axes) step = .25 * Vector{any_below(random, 9) - 4., any_below(random, 9) - 4., any_below(random, 9) - 4.};
    if (coincident) step = {0, 0, 0};
    scene.pair(a, add(where + step));
  }
  return scene;
}

// Real hulls, boxes, segments and points, for the oracle.
Scene faced_kinds(Random& random, int pairs) {
  Scene scene;
  Shapes& shapes = scene.shapes;
  std::vector<int> hulls;
  for (int k = 0; k < 10; ++k) hulls.push_back(make_hull(shapes.hulls, points_on_sphere(random, 4 + 2 * k)));
  for (int k = 0; k < pairs; ++k) {
    const auto add = [&](const Vector& position) {
      const Pose<double> place = at(position, any_turn(random));
      switch (any_below(random, 5)) {
        case 0: return shapes.sphere(.1, place);
        case 1: return shapes.capsule(any(random, .1, 1), .1, place);
        case 2: return shapes.box({any(random, .2, 1), any(random, .2, 1), any(random, .2, 1)}, place);
        default: return shapes.hull(hulls[any_below(random, 10)], place);
      }
    };
    const Vector where = 3. * any_inside(random);
    const int a = add(where);
    scene.pair(a, add(where + any(random, .5, 2.5) * any_direction(random)));
  }
  return scene;
}

// In double, orientations that float has rounded are of length 1 only to float's precision, which is put right.
template <class Real>
Rounded<Real> round_shapes(const Shapes& shapes) {
  Rounded<Real> rounded(shapes);
  if constexpr (std::is_same_v<Real, double>)
    for (Pose<double>& pose : rounded.pose) {
      auto& [x, y, z, w] = pose.orientation;
      const double scale = 1 / std::sqrt(x * x + y * y + z * z + w * w);
      x *= scale, y *= scale, z *= scale, w *= scale;
    }
  return rounded;
}

// The vertices of a core, in the world.
template <class Real>
ExactShape core(const Placed<Real>& placed, int collider) {
  ExactShape shape = exact_collider(placed, collider);
  shape.radius = 0;
  return shape;
}
template <class Real>
std::vector<Vector> corners(const Placed<Real>& placed, int collider) {
  const auto& [colliders, hulls, pose] = placed;
  const int hull = colliders.hull[collider];
  const Quad<Real>& size = colliders.size[collider];
  std::vector<Vector> result;
  for (int v = hulls.first_vertex[hull]; v < hulls.first_vertex[hull + 1]; ++v) {
    const Quad<Real>& p = hulls.vertex[v];
    result.push_back(exact_place(pose[collider], {double(p.x) * size.x, double(p.y) * size.y, double(p.z) * size.z}));
  }
  return result;
}
Vector in_double(const Vector3<float>& v) { return {v.x, v.y, v.z}; }
Vector in_double(const Vector3<double>& v) { return v; }

// What rounding is measured against: both shapes as seen from their own origins, and the way between these.
template <class Real>
double measure(const Placed<Real>& placed, const Pair& pair) {
  const auto reach = [&](int collider) {
    double farthest = 0;
    for (const Vector& v : corners(placed, collider)) farthest = std::max(farthest, length(v - in_double(placed.pose[collider].position)));
    return farthest;
  };
  return reach(pair.a) + reach(pair.b) + length(in_double(placed.pose[pair.b].position) - in_double(placed.pose[pair.a].position));
}

// --- Running it

template <class Real>
struct Answer {
  std::vector<Closest<Real>> closest;
  std::vector<Simplex> simplex;
};
template <class Real>
Answer<Real> run(Gjk<Real>& gjk, const Placed<Real>& placed, std::span<const Pair> pairs,
                 std::vector<Simplex> start = {}) {
  start.resize(pairs.size());
  std::vector<Closest<Real>> closest(pairs.size());
  gjk(placed, pairs, start, closest);
  return {std::move(closest), std::move(start)};
}

// Any simplex of vertices that there are.
Simplex any_simplex(Random& random, const Placed<float>& placed, const Pair& pair) {
  Simplex simplex = {any_below(random, 5), {}, {}};
  const auto vertex = [&](int collider) {
    return static_cast<std::uint8_t>(any_below(random, placed.hulls.vertices(placed.colliders.hull[collider])));
  };
  for (int k = 0; k < simplex.count; ++k) simplex.a[k] = vertex(pair.a), simplex.b[k] = vertex(pair.b);
  return simplex;
}

// --- Closed forms

// The distance is what it should be, the points are that far apart, and where there is but one way between them, they are it.
template <class Real>
void expect_closest(const Shapes& shapes, double distance, const Vector* on_a = nullptr, const Vector* on_b = nullptr) {
  const Rounded<Real> rounded = round_shapes<Real>(shapes);
  const Pair pair = {0, 1};
  const double bound = good * unit_roundoff<Real> * measure(rounded.placed(), pair);
  const Closest<Real> c = run<Real>(serial::gjk, rounded.placed(), std::span(&pair, 1)).closest[0];
  EXPECT_NEAR(c.distance, distance, bound);
  EXPECT_NEAR(length(in_double(c.on_b) - in_double(c.on_a)), c.distance, bound);
  if (on_a) {
    EXPECT_LE(length(in_double(c.on_a) - *on_a), bound);
    EXPECT_LE(length(in_double(c.on_b) - *on_b), bound);
  }
}
void expect_closest(const Shapes& shapes, double distance) {
  expect_closest<float>(shapes, distance);
  expect_closest<double>(shapes, distance);
}
void expect_closest(const Shapes& shapes, double distance, const Vector& on_a, const Vector& on_b) {
  expect_closest<float>(shapes, distance, &on_a, &on_b);
  expect_closest<double>(shapes, distance, &on_a, &on_b);
}

// Turns without rounding: y to x, and y to z.
constexpr Quaternion<double> along_x = {-.5, -.5, -.5, .5}, along_z = {.5, .5, .5, .5};

TEST(Gjk, Points) {
  Shapes apart, together;
  apart.sphere(.1, at({1, 2, 3})), apart.sphere(.1, at({3, 5, 9}));
  expect_closest(apart, 7, {1, 2, 3}, {3, 5, 9});
  together.sphere(.1, at({1, 2, 3})), together.sphere(.1, at({1, 2, 3}));
  expect_closest(together, 0, {1, 2, 3}, {1, 2, 3});
}

TEST(Gjk, Segments) {
  Shapes crossing, parallel, in_line, touching;
  crossing.capsule(1, .1, at({0, 0, 0})), crossing.capsule(1, .1, at({.25, .5, 2}, along_x));
  expect_closest(crossing, 2, {0, .5, 0}, {0, .5, 2});
  parallel.capsule(1, .1, at({0, 0, 0})), parallel.capsule(1, .1, at({3, .5, 4}));
  expect_closest(parallel, 5);
  in_line.capsule(1, .1, at({0, 0, 0})), in_line.capsule(.5, .1, at({0, 4, 0}));
  expect_closest(in_line, 2.5, {0, 1, 0}, {0, 3.5, 0});
  touching.capsule(1, .1, at({0, 0, 0})), touching.capsule(1, .1, at({.5, .25, 0}, along_x));
  expect_closest(touching, 0, {0, .25, 0}, {0, .25, 0});
}

TEST(Gjk, BoxesAlongTheAxes) {
  Shapes face, edge, corner, inside;
  for (Shapes* shapes : {&face, &edge, &corner, &inside}) shapes->box({.5, 1, 1.5}, at({1, 1, 1}));
  face.box({.5, .5, .5}, at({2.25, 1.5, .5}));
  expect_closest(face, .25);
  edge.box({.5, .5, .5}, at({5, 6.5, 1.25}));
  expect_closest(edge, 5);
  corner.box({.5, .5, .5}, at({3, 4.5, 9}));
  expect_closest(corner, std::hypot(1, 2, 6), {1.5, 2, 2.5}, {2.5, 4, 8.5});
  inside.box({.25, .25, .25}, at({1.125, 1, .75}));
  expect_closest(inside, 0);
}

TEST(Gjk, SegmentOverTriangle) {
  Shapes end, middle, through;
  const int triangle = add_vertices(end.hulls, {{0, 0, 0}, {4, 0, 0}, {0, 0, 4}});
  middle.hulls = through.hulls = end.hulls;
  for (Shapes* shapes : {&end, &middle, &through}) shapes->add(Kind::triangle, triangle, {1, 1, 1, 0}, at({1, 2, 3}));
  end.capsule(1, .1, at({2, 4, 4}));
  expect_closest(end, 1, {2, 2, 4}, {2, 3, 4});
  middle.capsule(2, .1, at({-2, 6, 5}, along_z));
  expect_closest(middle, 5);
  through.capsule(1, .1, at({2, 2.5, 4}));
  expect_closest(through, 0, {2, 2, 4}, {2, 2, 4});
}

// --- Against the exact oracle

template <class Real>
void expect_exact(int pairs) {
  Random random(1);
  const Scene scene = faced_kinds(random, pairs);
  const Rounded<Real> rounded = round_shapes<Real>(scene.shapes);
  const Placed<Real> placed = rounded.placed();
  const Answer<Real> answer = run<Real>(serial::gjk, placed, scene.pairs);
  int apart = 0;
  for (int k = 0; k < pairs; ++k) {
    const Pair& pair = scene.pairs[k];
    const ExactShape a = core(placed, pair.a), b = core(placed, pair.b);
    const double bound = good * unit_roundoff<Real> * measure(placed, pair);
    const double exact = exact_separation(a, b).separation;
    const Closest<Real>& c = answer.closest[k];
    ASSERT_NEAR(c.distance, std::max(exact, 0.), bound) << "pair " << k << ", " << c.iterations << " iterations";
    if (exact < bound) continue;
    ++apart;
    // In the world a coordinate is rounded where the pair stands, and by the turn there.
    const double in_world = bound + 8 * unit_roundoff<Real> * (length(in_double(placed.pose[pair.a].position)) + measure(placed, pair));
    const Vector on_a = in_double(c.on_a), on_b = in_double(c.on_b);
    ASSERT_NEAR(length(on_b - on_a), c.distance, in_world) << "pair " << k;
    ASSERT_LE(exact_separation(a, exact_shape({on_a}, {})).separation, in_world) << "pair " << k;
    ASSERT_LE(exact_separation(b, exact_shape({on_b}, {})).separation, in_world) << "pair " << k;
  }
  EXPECT_GT(apart, pairs / 4);
}

TEST(Gjk, ExactDistanceInFloat) { expect_exact<float>(4000); }
TEST(Gjk, ExactDistanceInDouble) { expect_exact<double>(4000); }

// --- Yes or no

// For libccd: the vertices, each with a ball around it.
struct Support {
  std::vector<Vector> corner;
  double radius;
};
void farthest_of(const void* shape, const ccd_vec3_t* direction, ccd_vec3_t* farthest) {
  const Support& support = *static_cast<const Support*>(shape);
  const Vector d = {direction->v[0], direction->v[1], direction->v[2]};
  const auto nearer = [&](const Vector& p, const Vector& q) { return dot(d, p) < dot(d, q); };
  const Vector& corner = *std::max_element(support.corner.begin(), support.corner.end(), nearer);
  const double to_surface = support.radius > 0 ? support.radius / length(d) : 0;
  ccdVec3Set(farthest, corner.x + to_surface * d.x, corner.y + to_surface * d.y, corner.z + to_surface * d.z);
}
bool ccd_overlap(const Support& a, const Support& b) {
  ccd_t ccd;
  CCD_INIT(&ccd);
  ccd.support1 = ccd.support2 = farthest_of;
  ccd.max_iterations = 200;
  return ccdGJKIntersect(&a, &b, &ccd) != 0;
}

// Where a gap or a depth is more, m, its yes or no is right.
constexpr double ccd_good = 1e-7;

// How far apart the planes across a direction are that hold the shapes apart: never more than the distance.
double planes_apart(const std::vector<Vector>& a, const std::vector<Vector>& b, const Vector& direction) {
  if (!(length(direction) > 0)) return -std::numeric_limits<double>::infinity();
  double end_a = -std::numeric_limits<double>::infinity(), begin_b = -end_a;
  for (const Vector& v : a) end_a = std::max(end_a, dot(direction, v));
  for (const Vector& v : b) begin_b = std::min(begin_b, dot(direction, v));
  return (begin_b - end_a) / length(direction);
}

// The most among directions that a simplex of their difference gives: across its face, or from a to b at its corner.
double planes_apart(const std::vector<Vector>& a, const std::vector<Vector>& b, const Simplex& simplex) {
  const auto corner = [&](int k) { return b[simplex.b[k]] - a[simplex.a[k]]; };
  const Vector normal = simplex.count == 3 ? cross(corner(1) - corner(0), corner(2) - corner(0)) : corner(0);
  return std::max(planes_apart(a, b, normal), planes_apart(a, b, -normal));
}

// A million pairs of all kinds. Where GJK finds a distance, planes that far apart have the cores on either side, which alone proves that it
// is not too large: where to try such planes, its own answer says, and that in double, but whether they are that far apart only the
// vertices. Where GJK and libccd differ, the cores touch but for the bound: those planes overlap by no more, or a ball of that radius
// around every vertex makes libccd see an overlap, too.
TEST(Gjk, YesOrNoOverAMillionPairs) {
  constexpr int pairs = 1'000'000, at_a_time = 50'000;
  Random random(2);
  int overlaps = 0, differ = 0, doubtful = 0, not_finite = 0;
  for (int done = 0; done < pairs; done += at_a_time) {
    const Scene scene = all_kinds(random, at_a_time);
    const Rounded<float> rounded(scene.shapes);
    const Placed<float> placed = rounded.placed();
    const Answer<float> answer = run<float>(openmp::gjk, placed, scene.pairs);
    const Rounded<double> unrounded(scene.shapes);
    const auto in_truth = run<double>(serial::gjk, unrounded.placed(), scene.pairs).closest;
    for (int k = 0; k < at_a_time; ++k) {
      const Pair& pair = scene.pairs[k];
      const Closest<float>& c = answer.closest[k];
      const Support a = {corners(placed, pair.a), 0}, b = {corners(placed, pair.b), 0};
      const double scale = unit_roundoff<float> * measure(placed, pair), bound = (scene.has_thin(pair) ? thin_good : good) * scale;
      const bool overlap = ccd_overlap(a, b);
      overlaps += overlap, differ += overlap != (c.distance == 0);
      const Vector on_a = in_double(c.on_a), on_b = in_double(c.on_b);
      if (!(c.distance >= 0 && std::isfinite(length(on_a) + length(on_b)))) ++not_finite;
      if (c.distance > bound || (c.distance > 0 && overlap)) {
        const double apart =
            std::max({planes_apart(a.corner, b.corner, on_b - on_a), planes_apart(a.corner, b.corner, in_truth[k].on_b - in_truth[k].on_a),
                      planes_apart(a.corner, b.corner, answer.simplex[k])});
        ASSERT_GE(apart, c.distance - bound) << "pair " << done + k << ", " << c.iterations << " iterations";
        doubtful += apart < c.distance - good * scale;
      }
      if (c.distance == 0 && !overlap) {
        const double gap = stuck * scale + ccd_good;
        ASSERT_TRUE(ccd_overlap({a.corner, gap}, {b.corner, gap})) << "pair " << done + k;
      }
    }
  }
  EXPECT_EQ(not_finite, 0);
  EXPECT_LE(doubtful, 10);  // thin ones alone, and few of them: 1 of these
  EXPECT_GT(overlaps, pairs / 5);
  EXPECT_LT(overlaps, 4 * pairs / 5);
  EXPECT_LT(differ, pairs / 200);  // a quarter stand on a grid, where many touch exactly
}

// --- Symmetry, starts, degenerate input

TEST(Gjk, TurnedRoundTheDistanceIsTheSame) {
  Random random(3);
  const Scene scene = all_kinds(random, 20'000);
  const Rounded<float> rounded(scene.shapes);
  Pairs turned = scene.pairs;
  for (Pair& pair : turned) std::swap(pair.a, pair.b);
  const auto there = run<float>(serial::gjk, rounded.placed(), scene.pairs).closest;
  const auto back = run<float>(serial::gjk, rounded.placed(), turned).closest;
  for (std::size_t k = 0; k < turned.size(); ++k)
    ASSERT_NEAR(there[k].distance, back[k].distance,
                2 * (scene.has_thin(turned[k]) ? thin_good : good) * unit_roundoff<float> * measure(rounded.placed(), turned[k]))
        << "pair " << k;
}

TEST(Gjk, AnyStartGivesTheSameDistance) {
  Random random(4);
  const Scene scene = all_kinds(random, 200'000);
  const Rounded<float> rounded(scene.shapes);
  const Placed<float> placed = rounded.placed();
  const auto [cold, known] = run<float>(serial::gjk, placed, scene.pairs);
  const auto [warm, known_too] = run<float>(serial::gjk, placed, scene.pairs, known);
  std::vector<Simplex> garbage(scene.pairs.size());
  for (std::size_t k = 0; k < garbage.size(); ++k) garbage[k] = any_simplex(random, placed, scene.pairs[k]);
  const auto [any, known_as_well] = run<float>(serial::gjk, placed, scene.pairs, garbage);
  int looks = 0;
  for (std::size_t k = 0; k < garbage.size(); ++k) {
    const Pair& pair = scene.pairs[k];
    const double bound = 2 * (scene.has_thin(pair) ? thin_good : good) * unit_roundoff<float> * measure(placed, pair);
    ASSERT_NEAR(cold[k].distance, warm[k].distance, bound) << "pair " << k;
    ASSERT_NEAR(cold[k].distance, any[k].distance, bound) << "pair " << k;
    ASSERT_GE(known[k].count, 1);
    ASSERT_LE(known[k].count, 4);
    looks += warm[k].iterations;
  }
  EXPECT_LT(looks, static_cast<int>(1.05 * garbage.size()));  // from where it ended, one look, or none where the cores overlap
}

// Shapes so small, or so large, that squares of squares of them leave the range of float.
TEST(Gjk, NeverNan) {
  Random random(5);
  for (const double scale : {1e-30, 1e-18, 1e-12, 1e-9, 1e-6, 1e-3, 1., 1e3}) {
    Scene scene;
    for (int k = 0; k < 2000; ++k) {
      const auto add = [&](const Vector& position) {
        const Vector half = {any_below(random, 3) * .5 * scale, any_below(random, 3) * .5 * scale, any_below(random, 3) * .5 * scale};
        return scene.shapes.box(half, at(position, any_below(random, 2) ? no_rotation : any_turn(random)));
      };
      const int a = add({0, 0, 0});
      scene.pair(a, add((any_below(random, 4) * scale) * any_direction(random)));
    }
    const Rounded<float> rounded(scene.shapes);
    for (Gjk<float>* gjk : {serial::gjk, openmp::gjk})
      for (const Closest<float>& c : run<float>(*gjk, rounded.placed(), scene.pairs).closest) {
        ASSERT_GE(c.distance, 0) << scale;
        ASSERT_TRUE(std::isfinite(length(in_double(c.on_a)) + length(in_double(c.on_b)) + c.distance)) << scale;
        ASSERT_LE(c.distance, 5 * scale);
      }
  }
}

// --- Bit by bit

TEST(Gjk, BothVersionsHaveTheSameBits) {
  Random random(6);
  const Scene scene = all_kinds(random, 6000);
  const Rounded<float> rounded(scene.shapes);
  const Placed<float> placed = rounded.placed();
  std::vector<Simplex> cold(scene.pairs.size()), garbage = cold;
  for (std::size_t k = 0; k < garbage.size(); ++k) garbage[k] = any_simplex(random, placed, scene.pairs[k]);
  const int threads_before = omp_get_max_threads();
  for (const std::size_t count : {0, 1, 15, 16, 17, 513, 6000}) {
    const std::span pairs = std::span(scene.pairs).first(count);
    const std::vector<Simplex> warm = run<float>(serial::gjk, placed, pairs).simplex;
    for (const std::vector<Simplex>& start : {cold, garbage, warm}) {
      const std::vector<Simplex> from(start.begin(), start.begin() + count);
      const Answer<float> expected = run<float>(serial::gjk, placed, pairs, from);
      for (const int threads : {1, 2, 3, 8}) {
        omp_set_num_threads(threads);
        const Answer<float> answer = run<float>(openmp::gjk, placed, pairs, from);
        for (std::size_t k = 0; k < count; ++k) {
          ASSERT_EQ(std::memcmp(&answer.closest[k], &expected.closest[k], sizeof(Closest<float>)), 0)
              << count << " pairs, " << threads << " threads, pair " << k << ": " << answer.closest[k].distance << " against "
              << expected.closest[k].distance;
          ASSERT_EQ(std::memcmp(&answer.simplex[k], &expected.simplex[k], sizeof(Simplex)), 0) << count << " pairs, pair " << k;
        }
      }
    }
  }
  omp_set_num_threads(threads_before);
}

}  // namespace
}  // namespace lockstep::rigid
