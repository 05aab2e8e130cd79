// Planes against the corners of every box.
#include "tests/rigid_boxes.h"

namespace lockstep::rigid {
namespace {

TEST_F(BroadPhase, PlanesMeetWhatReachesBelowThem) {
  Random random(7);
  long found = 0;
  for (int k = 0; k < 200; ++k) {
    SCOPED_TRACE(k);
    // Some with many colliders, so that strips are cut; planes before, between and after them.
    const World<float> world =
        convert<float>(random_world(random, k < 195 ? random.integer(0, 60) : 2000, 5, k % 5 * .1f));
    const Colliders<float>& colliders = world.colliders;
    Array<Pose<float>> placed;
    Bounds<float> bounds;
    serial::place_colliders(world, 0, placed, bounds);

    // Any of eight corners below the plane. Corners are as far from the plane as this text says, in the same order of
    // operations.
    Pairs expected;
    const auto reaches_below = [&](int plane, int i) {
      const Vector3<float> normal = matrix_of(placed[plane].orientation).y, point = placed[plane].position;
      bool below = false;
      for (int corner = 0; corner < 8; ++corner) {
        const Box<float> box = bounds.box(i);
        const Vector3<float> v = {corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                                  corner & 4 ? box.high.z : box.low.z};
        below |= dot(v - point, normal) <= 0;
      }
      return below;
    };
    for (int a = 0; a < colliders.count; ++a)
      for (int b = a + 1; b < colliders.count; ++b) {
        if (bounds.bounded(a) == bounds.bounded(b) || colliders.group[a] == colliders.group[b]) continue;
        if (bounds.bounded(a) ? reaches_below(b, a) : reaches_below(a, b)) expected.push_back({a, b});
      }
    found += static_cast<long>(expected.size());

    Pairs pairs = {{-1, -1}};
    serial::plane_pairs(colliders, placed, bounds, pairs);
    EXPECT_EQ(pairs, expected);
    omp_set_num_threads(thread_counts[k % 5]);
    openmp::plane_pairs(colliders, placed, bounds, pairs);
    EXPECT_EQ(pairs, expected);
  }
  EXPECT_GT(found, 10'000);
}

}  // namespace
}  // namespace lockstep::rigid
