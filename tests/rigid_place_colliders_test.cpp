// Boxes against the vertices that they are to hold, and where colliders are.
#include "tests/rigid_boxes.h"

namespace lockstep::rigid {
namespace {

Vector3<double> in_double(const Vector3<float>& v) { return {v.x, v.y, v.z}; }
Vector3<double> at(const Pose<double>& pose, const Vector3<double>& v) {
  return pose.position + matrix_of(pose.orientation) * v;
}

TEST_F(BroadPhase, BoxesAreTheSmallestThatHoldTheirColliders) {
  Random random(5);
  for (const float margin : {0.f, .05f})
    for (const int bodies : {0, 1, 7, 300}) {
      const World<float> world = convert<float>(random_world(random, bodies, 50, .05f));
      const Colliders<float>& colliders = world.colliders;
      Array<Pose<float>> placed;
      Bounds<float> bounds;
      serial::place_colliders(world, margin, placed, bounds);
      ASSERT_EQ(bounds.count, colliders.count);
      for (int i = 0; i < colliders.count; ++i) {
        SCOPED_TRACE(i);
        EXPECT_EQ(bounds.bounded(i), colliders.kind[i] != static_cast<int>(Kind::plane));
        if (!bounds.bounded(i)) continue;

        // The float pose in double. With u = 2^-24, to first order: an element of its matrix, at most 1, is off by at
        // most 5 u (squares by u each, twice their sum, and the last difference), so a turned vector h by (5 + 1 + 2) u
        // sum|h|, and by u sum|h| more as its components are products. That holds for the middle and for the extent;
        // radius and margin, then extent, middle and the ends are each rounded once more, the ends of at most |p| + 2
        // s, where p is the position and s the sum of all that is added to it. The hull's box and its vertices came
        // from double and are off by u each: 2 u s. In total 2 u |p| + 18 u s; one more for the higher orders.
        const Quad<float>&size = colliders.size[i], &centre = world.hulls.centre[colliders.hull[i]],
              &half = world.hulls.half[colliders.hull[i]];
        const Vector3<double> p = in_double(placed[i].position);
        const Quaternion<float>& q = placed[i].orientation;
        const Pose<double> pose = {p, {q.x, q.y, q.z, q.w}, 0};
        const double s = size.x * (std::abs(centre.x) + half.x) + size.y * (std::abs(centre.y) + half.y) +
                         size.z * (std::abs(centre.z) + half.z) + size.w + margin;
        const double u = std::ldexp(1., -24), widening = double(size.w) + margin;
        const auto bound = [&](double position) { return u * (2 * std::abs(position) + 19 * s); };
        const Box<float> box = bounds.box(i);

        Box<double> around_vertices = empty_box<double>;
        for (int k = world.hulls.first_vertex[colliders.hull[i]]; k < world.hulls.first_vertex[colliders.hull[i] + 1];
             ++k) {
          const Quad<float>& vertex = world.hulls.vertex[k];
          const Vector3<double> v =
              at(pose, {double(size.x) * vertex.x, double(size.y) * vertex.y, double(size.z) * vertex.z});
          around_vertices = around(around_vertices, {v, v});
        }
        EXPECT_NEAR(box.low.x, around_vertices.low.x - widening, bound(p.x));
        EXPECT_NEAR(box.low.y, around_vertices.low.y - widening, bound(p.y));
        EXPECT_NEAR(box.low.z, around_vertices.low.z - widening, bound(p.z));
        EXPECT_NEAR(box.high.x, around_vertices.high.x + widening, bound(p.x));
        EXPECT_NEAR(box.high.y, around_vertices.high.y + widening, bound(p.y));
        EXPECT_NEAR(box.high.z, around_vertices.high.z + widening, bound(p.z));
      }

      for (const int threads : thread_counts) {
        omp_set_num_threads(threads);
        Array<Pose<float>> parallel_placed;
        Bounds<float> parallel;
        openmp::place_colliders(world, margin, parallel_placed, parallel);
        EXPECT_TRUE(same_bits(bounds, parallel));
        EXPECT_TRUE(same_bits(placed, parallel_placed, colliders.count));
      }
    }
}

TEST_F(BroadPhase, CollidersGoWhereTheirBodiesAre) {
  Random random(6);
  const World<double> world = random_world(random, 100, 50, 0);
  Array<Pose<double>> placed;
  Bounds<double> bounds;
  serial::place_colliders(world, 0, placed, bounds);
  for (int i = 0; i < world.colliders.count; ++i)
    for (const Vector3<double>& v : {Vector3<double>{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
      const Vector3<double> expected = at(world.bodies.pose[world.colliders.body[i]], at(world.colliders.local[i], v));
      const Vector3<double> off = at(placed[i], v) - expected;
      // Lengths of at most 60, of some 30 roundings each.
      EXPECT_LT(std::sqrt(dot(off, off)), 30 * 60 * std::ldexp(1., -53));
    }
}

}  // namespace
}  // namespace lockstep::rigid
