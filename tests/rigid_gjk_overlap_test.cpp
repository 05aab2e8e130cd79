// GJK against separating planes and an independent test for overlap (libccd), over a million pairs.
#include <ccd/ccd.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "tests/rigid_gjk.h"

namespace lockstep::rigid::gjk_pairs {
namespace {

// A shape for libccd: the vertices, each with a ball around it.
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

// The answer of libccd is right if a gap or a depth is larger than this, m.
constexpr double ccd_good = 1e-7;

// The distance between two planes across a direction that separate the shapes. It is never more than the distance of
// the shapes.
double planes_apart(const std::vector<Vector>& a, const std::vector<Vector>& b, const Vector& direction) {
  if (!(length(direction) > 0)) return -std::numeric_limits<double>::infinity();
  double end_a = -std::numeric_limits<double>::infinity(), begin_b = -end_a;
  for (const Vector& v : a) end_a = std::max(end_a, dot(direction, v));
  for (const Vector& v : b) begin_b = std::min(begin_b, dot(direction, v));
  return (begin_b - end_a) / length(direction);
}

// The greatest such distance among the directions of a simplex of the difference: across its face, or from a to b at
// its corner.
double planes_apart(const std::vector<Vector>& a, const std::vector<Vector>& b, const Simplex& simplex) {
  const auto corner = [&](int k) { return b[simplex.b[k]] - a[simplex.a[k]]; };
  const Vector normal = simplex.count == 3 ? cross(corner(1) - corner(0), corner(2) - corner(0)) : corner(0);
  return std::max(planes_apart(a, b, normal), planes_apart(a, b, -normal));
}

// A million pairs of all kinds. If GJK finds a distance, two planes that far apart separate the cores, which proves
// that the distance is not too large. The directions to try come from GJK's own answers, in float and in double; the
// vertices alone decide whether the planes separate. If GJK and libccd differ, the cores touch to within the bound: the
// planes overlap by no more, or libccd sees an overlap, too, once every vertex has a ball of that radius.
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
      const double scale = unit_roundoff<float> * measure(placed, pair),
                   bound = (scene.has_thin(pair) ? thin_good : good) * scale;
      const bool overlap = ccd_overlap(a, b);
      overlaps += overlap, differ += overlap != (c.distance == 0);
      const Vector on_a = in_double(c.on_a), on_b = in_double(c.on_b);
      if (!(c.distance >= 0 && std::isfinite(length(on_a) + length(on_b)))) ++not_finite;
      if (c.distance > bound || (c.distance > 0 && overlap)) {
        const double apart = std::max({planes_apart(a.corner, b.corner, on_b - on_a),
                                       planes_apart(a.corner, b.corner, in_truth[k].on_b - in_truth[k].on_a),
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
  EXPECT_LE(doubtful, 10);  // only a few thin ones: 1 of these pairs
  EXPECT_GT(overlaps, pairs / 5);
  EXPECT_LT(overlaps, 4 * pairs / 5);
  EXPECT_LT(differ, pairs / 200);  // a quarter of the pairs stand on a grid, and many of those touch exactly
}

}  // namespace
}  // namespace lockstep::rigid::gjk_pairs
