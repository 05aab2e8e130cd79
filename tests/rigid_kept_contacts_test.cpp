// Contacts that are kept from step to step: how far a pair may have moved, how wrong separations then are, and that
// what stands with contacts found anew stands with these.
#include <gtest/gtest.h>
#include <omp.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "common/rigid/narrow_phase.h"
#include "common/rigid/scene.h"
#include "common/rigid/step.h"
#include "tests/rigid_shapes.h"
#include "verify/rigid/run.h"

namespace lockstep::rigid {
namespace {

constexpr double margin = .01, tolerance = kept_share * margin;

double uniform(std::mt19937& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
Vector3<double> any_point(std::mt19937& random, double far) {
  return {uniform(random, -far, far), uniform(random, -far, far), uniform(random, -far, far)};
}
double length(const Vector3<double>& v) { return std::sqrt(dot(v, v)); }

// A pose near another one: moved by up to `far`, m, and turned by up to `angle`.
Pose<double> near(std::mt19937& random, const Pose<double>& pose, double far, double angle) {
  return at(pose.position + any_point(random, far),
            turn(any_point(random, 1), uniform(random, 0, angle)) * pose.orientation);
}

// How far a point of a body, in its axes, is from where it was, as another body sees it.
double moved(const Pose<double>& then, const Pose<double>& now, const Vector3<double>& point) {
  const auto place = [&](const Pose<double>& pose) { return pose.position + matrix_of(pose.orientation) * point; };
  return length(place(now) - place(then));
}
Pose<double> inverse(const Pose<double>& pose) {
  const Quaternion<double> back = conjugate(pose.orientation);
  return at(-(matrix_of(back) * pose.position), back);
}

// All points of b within its reach, or all of a, have moved at most so far relative to the other collider.
TEST(KeptContacts, NoPointHasMovedFarther) {
  std::mt19937 random(1);
  double tightest = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    const Pose<double> then = at(any_point(random, 2), any_turn(random)), now = near(random, then, .02, .1);
    const double reach_a = uniform(random, .1, 3), reach_b = uniform(random, .1, 3);
    const double counted = moved_since(then, now, reach_a, reach_b);
    double of_a = 0, of_b = 0;
    for (int k = 0; k < 200; ++k) {
      const Vector3<double> p = any_point(random, 1), on_sphere = 1 / length(p) * p;
      of_b = std::max(of_b, moved(then, now, reach_b * on_sphere));
      of_a = std::max(of_a, moved(inverse(then), inverse(now), reach_a * on_sphere));
    }
    EXPECT_GE(counted, std::min(of_a, of_b) * (1 - 1e-12));
    tightest = std::max(tightest, std::min(of_a, of_b) / counted);
  }
  EXPECT_GT(tightest, .9);
}

TEST(KeptContacts, PosesThatAreNotNumbersAreNotNear) {
  const Pose<float> pose = {{0, 0, 0}, {0, 0, 0, 1}, 0};
  Pose<float> lost = pose;
  lost.position.y = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(moved_since(pose, lost, 1.f, 1.f) <= 1);
  lost = pose, lost.orientation.w = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(moved_since(pose, lost, 1.f, 1.f) <= 1);
}

// A hull and a box or another hull that touch or nearly do, two and two.
struct Couples {
  Shapes shapes;
  Pairs pairs;
};
Couples couples(int count, std::mt19937& random) {
  Couples result;
  Shapes& shapes = result.shapes;
  std::vector<int> hulls;
  for (int k = 0; k < 8; ++k) {
    std::vector<Vector3<double>> points;
    for (int p = 0; p < 8 + 4 * k; ++p) {
      const Vector3<double> v = any_point(random, 1);
      points.push_back(.5 / length(v) * v);
    }
    hulls.push_back(make_hull(shapes.hulls, points));
  }
  for (int k = 0; k < count; ++k) {
    const Vector3<double> middle = {3. * k, 0, 0};
    const auto any_hull = [&] { return hulls[random() % hulls.size()]; };
    const auto half = [&] { return uniform(random, .2, .6); };
    const Vector3<double> off = any_point(random, 1);
    const Pose<double> first = at(middle, any_turn(random)),
                       second = at(middle + uniform(random, .6, 1.2) / length(off) * off, any_turn(random));
    const int a = k % 2 ? shapes.box({half(), half(), half()}, first) : shapes.hull(any_hull(), first),
              b = shapes.hull(any_hull(), second);
    result.pairs.push_back({a, b});
  }
  return result;
}

int make_cube(Hulls<double>& hulls, double half) {
  std::vector<Vector3<double>> corners;
  for (const double x : {-half, half})
    for (const double y : {-half, half})
      for (const double z : {-half, half}) corners.push_back({x, y, z});
  return make_hull(hulls, corners);
}

// The depth of each pair, `margin` where it has no point.
std::vector<double> deepest(const Pairs& pairs, const Array<Manifold<double>>& manifolds) {
  std::vector<double> least(pairs.size(), margin);
  for (const Manifold<double>& m : manifolds) {
    double& of_pair = least[std::ranges::lower_bound(pairs, Pair{m.a, m.b}) - pairs.begin()];
    for (int k = 0; k < m.count; ++k) of_pair = std::min(of_pair, m.point[k].separation);
  }
  return least;
}

// In double: the deepest separation of a kept contact is within 2 e of that of one found anew. What it has turned about
// the smaller collider adds e |s| / reach. Kernels choose among axes by 1e-6 of a size (axis_preference).
TEST(KeptContacts, SeparationsAreWithinTwiceOfWhatHasMoved) {
  std::mt19937 random(2);
  Couples there = couples(3000, random);
  NarrowPhaseState state, anew_state;
  KeptContacts<double> kept;
  Array<Manifold<double>> manifolds, anew;
  serial::narrow_phase_kept(Rounded<double>(there.shapes).placed(), there.pairs, margin, state, kept, manifolds);
  const KeptContacts<double> before = kept;
  for (int b = 1; b < there.shapes.colliders.count; b += 2)
    there.shapes.pose[b] = near(random, there.shapes.pose[b], .6 * tolerance, .8 * tolerance);
  const Rounded<double> moved(there.shapes);
  serial::narrow_phase_kept(moved.placed(), there.pairs, margin, state, kept, manifolds);
  serial::narrow_phase(moved.placed(), there.pairs, margin, anew_state, anew);
  const std::vector<double> of_kept = deepest(there.pairs, manifolds), of_anew = deepest(there.pairs, anew);
  double worst = 0;
  int were_kept = 0;
  for (std::size_t k = 0; k < kept.pairs.size(); ++k) {
    const Pair& pair = kept.pairs[k];
    const std::size_t at = std::ranges::lower_bound(there.pairs, pair) - there.pairs.begin();
    const KeptContact<double>& contact = before.contact[k];
    const Pose<double> now = pair_poses(moved.pose[pair.a], moved.pose[pair.b]).b_in_a;
    const double e = moved_since(contact.b_in_a, now, contact.reach_a, contact.reach_b);
    const double off = std::abs(of_kept[at] - of_anew[at]);
    if (e > tolerance) {
      EXPECT_LE(off, 1e-12) << k;  // GJK starts from another simplex
      continue;
    }
    were_kept++;
    EXPECT_LE(off, 2 * e + e * std::abs(of_kept[at]) / std::min(contact.reach_a, contact.reach_b) + 1e-6) << k;
    worst = std::max(worst, off / (2 * e));
  }
  std::printf("  %d of %zu pairs kept; separations off by up to %.2f of 2 e\n", were_kept, kept.pairs.size(), worst);
  EXPECT_GT(were_kept, 1000);
  EXPECT_LT(were_kept, 2900);
  EXPECT_GT(worst, .02);
}

// A small cube, as a hull, over the face of a large box. Whatever it does within the tolerance, its corners' heights
// are exact. The large box is a, or b.
TEST(KeptContacts, CornersOverAFaceAreExact) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 200; ++trial) {
    const bool large_is_a = trial % 2 == 0;
    const Pose<double> world = at(any_point(random, 1), any_turn(random));
    const auto put = [&](const Pose<double>& pose) {
      return at(world.position + matrix_of(world.orientation) * pose.position, world.orientation * pose.orientation);
    };
    const Pose<double> rests = at({.3, .5 + .1, .2}, turn({0, 1, 0}, .3));
    Shapes shapes;
    const int cube = make_cube(shapes.hulls, .1);
    const auto large = [&] { return shapes.box({2, .5, 2}, world); };
    const auto small = [&] { return shapes.hull(cube, put(rests)); };
    const int first = large_is_a ? large() : small(), second = large_is_a ? small() : large();
    const Pairs pairs = {{first, second}};
    NarrowPhaseState state;
    KeptContacts<double> kept;
    Array<Manifold<double>> manifolds;
    serial::narrow_phase_kept(Rounded<double>(shapes).placed(), pairs, margin, state, kept, manifolds);
    ASSERT_EQ(manifolds.size(), 1u);
    ASSERT_EQ(manifolds[0].count, 4);
    const Pose<double> tilted = near(random, rests, .2 * tolerance, .2 * tolerance);
    shapes.pose[large_is_a ? second : first] = put(tilted);
    const KeptContact<double> before = kept.contact[0];
    serial::narrow_phase_kept(Rounded<double>(shapes).placed(), pairs, margin, state, kept, manifolds);
    ASSERT_EQ(kept.contact[0].b_in_a.position.x, before.b_in_a.position.x);
    for (int k = 0; k < 4; ++k) {
      // The lower corners of the small box, by their heights over the face.
      double nearest = 1;
      for (const double x : {-.1, .1})
        for (const double z : {-.1, .1}) {
          const Vector3<double> corner = tilted.position + matrix_of(tilted.orientation) * Vector3<double>{x, -.1, z};
          nearest = std::min(nearest, std::abs(corner.y - .5 - manifolds[0].point[k].separation));
        }
      // The poses are rounded to float; where the large box is b, its face turned by t while a's corners stay.
      EXPECT_LT(nearest, 1e-6) << trial;
    }
  }
}

// .6 of the tolerance a step: kept once, found anew in the second step.
TEST(KeptContacts, MotionIsCountedFromWhereTheContactWasFound) {
  Shapes shapes;
  const int ground = shapes.box({2, .5, 2}, at({0, 0, 0})),
            box = shapes.hull(make_cube(shapes.hulls, .5), at({0, 1, 0}));
  const Pairs pairs = {{ground, box}};
  NarrowPhaseState state;
  KeptContacts<float> kept;
  Array<Manifold<float>> manifolds;
  std::vector<float> found_at;
  for (int step = 0; step < 5; ++step) {
    shapes.pose[box].position.x = static_cast<float>(.6 * tolerance * step);
    serial::narrow_phase_kept(Rounded<float>(shapes).placed(), pairs, float(margin), state, kept, manifolds);
    found_at.push_back(std::round(kept.contact[0].b_in_a.position.x / (.6f * float(tolerance))));
    ASSERT_EQ(manifolds.size(), 1u);
    EXPECT_EQ(manifolds[0].count, 4);
  }
  EXPECT_EQ(found_at, (std::vector<float>{0, 0, 2, 2, 4}));
}

// A heap of hulls comes to rest as it does with contacts found anew.
TEST(KeptContacts, AHeapOfHullsComesToRest) {
  omp_set_num_threads(1);  // the results are the same, and a thread that waits for a busy core waits long
  const Scene scene = load_scene("scenes/rigid/hull_pit_2000.toml");
  const StepSettings settings = verify::settings_of(scene);
  const auto at_rest = [&](Step<float>* step) {
    World<float> world = scene.world;
    StepMemory<float> memory;
    for (int k = 0; k < 600; ++k) step(settings, world, memory);
    double deepest = 0;
    for (const Manifold<float>& m : memory.manifolds)
      for (int k = 0; k < m.count; ++k) deepest = std::max(deepest, -double(m.point[k].separation));
    return std::pair(verify::energy(world.bodies, {0, 0, 0}) / world.bodies.count, deepest);
  };
  const auto [anew, depth_anew] = at_rest(openmp::step_batches);
  const auto [kept, depth_kept] = at_rest(openmp::step_batches_kept);
  std::printf("  hull_pit_2000: found anew %.2g J a body, deepest %.2f mm; kept %.2g J, %.2f mm\n", anew,
              1e3 * depth_anew, kept, 1e3 * depth_kept);
  EXPECT_LT(kept, 1e-5);
  EXPECT_LT(depth_kept, .02);
}

}  // namespace
}  // namespace lockstep::rigid
