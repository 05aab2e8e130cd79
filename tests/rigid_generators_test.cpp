// Generated bodies: how many, where they stand, how densely they overlap, and the memory that making them takes.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "common/mesh_file.h"
#include "common/rigid/generators.h"
#include "common/rigid/scene.h"
#include "tests/rigid_worlds.h"

namespace lockstep::rigid::worlds {
namespace {

const Kit plain_kit = {{0, 0, 0}, 1, {}};

TEST(RigidGenerators, CountTheirBodies) {
  for (const int layers : {1, 2, 3, 8, 15}) {
    World<double> world = make_world();
    add_pyramid(world, plain_kit, layers);
    EXPECT_EQ(world.bodies.count, pyramid_bodies(layers));
  }
  for (const int courses : {1, 2, 5})
    for (const int bricks : {15, 16, 21}) {
      World<double> world = make_world();
      add_castle(world, plain_kit, courses, bricks);
      EXPECT_EQ(world.bodies.count, castle_bodies(courses, bricks));
    }
  EXPECT_EQ(castle_bodies(16, 42), 10000);
  EXPECT_EQ(pyramid_bodies(24), 4900);
}

// Boxes along the axes: none overlaps another, and each stands on the ground or on another.
void expect_to_stand(const World<double>& world) {
  struct Block {
    Vector low, high;
  };
  std::vector<Block> blocks;
  for (int i = 0; i < world.colliders.count; ++i) {
    const Vector& p = world.bodies.pose[i].position;
    const Quad<double>& half = world.colliders.size[i];
    EXPECT_EQ(world.bodies.pose[i].orientation.w, 1);
    blocks.push_back({p - Vector{half.x, half.y, half.z}, p + Vector{half.x, half.y, half.z}});
  }
  std::ranges::sort(blocks, {}, [](const Block& b) { return b.low.x; });
  const double near = 1e-12;  // a few roundings of positions of tens of metres
  std::vector<char> stands(blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    stands[i] |= std::abs(blocks[i].low.y) <= near;
    for (std::size_t j = i + 1; j < blocks.size() && blocks[j].low.x < blocks[i].high.x - near; ++j) {
      const Block &a = blocks[i], &b = blocks[j];
      if (!(a.low.z < b.high.z - near && b.low.z < a.high.z - near)) continue;
      EXPECT_FALSE(a.low.y < b.high.y - near && b.low.y < a.high.y - near)
          << "at " << b.low.x << ' ' << b.low.y << ' ' << b.low.z;
      stands[i] |= std::abs(a.low.y - b.high.y) <= near;
      stands[j] |= std::abs(b.low.y - a.high.y) <= near;
    }
  }
  EXPECT_EQ(std::ranges::count(stands, false), 0);
}

TEST(RigidGenerators, BuildWhatStands) {
  const auto made = [](auto add) {
    World<double> world = make_world();
    add(world);
    return world;
  };
  expect_to_stand(made([](auto& w) { add_pyramid(w, plain_kit, 9); }));
  expect_to_stand(made([](auto& w) { add_wall(w, plain_kit, 20, 50); }));
  expect_to_stand(made([](auto& w) { add_castle(w, plain_kit, 16, 42); }));
  expect_to_stand(made([](auto& w) { add_castle(w, plain_kit, 3, 15); }));
  expect_to_stand(made([](auto& w) { add_stack(w, plain_kit, 10, {.5, .25, .5}); }));
  expect_to_stand(made([](auto& w) { add_dominoes(w, plain_kit, 10); }));
}

TEST(RigidGenerators, PutPyramidsWhereOthersDo) {
  World<double> world = make_world();
  add_pyramid(world, plain_kit, 3);
  const auto at = [&](int i) { return world.bodies.pose[i].position; };
  expect_near(at(0), {-1.575, .5, -1.575}, 1e-15);
  expect_near(at(5), {-.525, .5, .525}, 1e-15);
  expect_near(at(9), {-1.05, 1.5, -1.05}, 1e-15);
  expect_near(at(13), {-.525, 2.5, -.525}, 1e-15);
}

TEST(RigidGenerators, ChanceIsTheSameOnEveryMachine) {
  // SplitMix64's first two numbers of this seed, as published, are 6457827717110365317 and 3203168211198807973.
  World<double> world = make_world();
  add_pit(world, plain_kit, Assortment::boxes, 1, 11, 1.2, 1234567);
  const Vector& p = world.bodies.pose[pit_walls].position;
  EXPECT_NEAR(p.x, -8.5 + .2 * (6457827717110365317 * 0x1p-64 - .5), 1e-14);
  EXPECT_NEAR(p.z, -8.5 + .2 * (3203168211198807973 * 0x1p-64 - .5), 1e-14);
  EXPECT_EQ(p.y, 1.2);
}

TEST(RigidGenerators, FillPits) {
  World<double> world = make_world();
  add_pit(world, plain_kit, Assortment::hulls, 200, 9, 1, 1);
  ASSERT_EQ(world.bodies.count, 205);
  EXPECT_EQ(world.hulls.count, 3 + 64);
  // The walls begin 8 m from the middle.
  EXPECT_NEAR(world.bodies.pose[2].position.x - world.colliders.size[2].x, 8, 1e-14);
  EXPECT_NEAR(world.bodies.pose[4].position.z - world.colliders.size[4].z, 8, 1e-14);
  for (int h = 3; h < 67; ++h) {
    const int count = world.hulls.vertices(h);
    EXPECT_TRUE(count >= 12 && count <= 24) << "all points of an ellipsoid are corners";
    for (int i = 0; i < count; ++i) {
      EXPECT_LE(length(vertex_of(world.hulls, h, i)), .75 + 1e-15);
      EXPECT_GE(length(vertex_of(world.hulls, h, i)), .45 - 1e-15);
      for (int k = 0; k < i; ++k) EXPECT_GE(length(vertex_of(world.hulls, h, i) - vertex_of(world.hulls, h, k)), .1);
    }
  }
  World<double> boxes = make_world();
  add_pit(boxes, plain_kit, Assortment::boxes, 300, 11, 1.2, 1);
  EXPECT_NEAR(boxes.bodies.pose[2].position.x - boxes.colliders.size[2].x, 10, 1e-14);
  for (int i = 0; i < 300; ++i) {
    const Vector& p = boxes.bodies.pose[5 + i].position;
    EXPECT_LE(std::abs(p.x - 1.7 * (i % 11 - 5)), .1 + 1e-14);
    EXPECT_LE(std::abs(p.z - 1.7 * (i / 11 % 11 - 5)), .1 + 1e-14);
    EXPECT_NEAR(p.y, 1.2 + 1.7 * (i / 121), 1e-14);
    EXPECT_EQ(boxes.colliders.size[5 + i].x, (std::array{.5, .3, .4, .6})[i % 4]);
  }
}

ExactShape exact_collider(const World<double>& world, int i) {
  const Quad<double>& size = world.colliders.size[i];
  const int hull = world.colliders.hull[i];
  std::vector<Vector> vertices;
  for (int k = 0; k < world.hulls.vertices(hull); ++k) {
    const Vector v = vertex_of(world.hulls, hull, k);
    const Vector local = exact_place(world.colliders.local[i], {size.x * v.x, size.y * v.y, size.z * v.z});
    vertices.push_back(exact_place(world.bodies.pose[world.colliders.body[i]], local));
  }
  return exact_shape(vertices, faces_of(world.hulls, hull), size.w);
}

// The test counts bodies farther from the border than two bodies are wide. Each of them overlaps another with the given
// probability, but for two effects. Kinds differ in size, and 1 - exp(-n E) is not linear: for kinds with E up to a
// third from its mean and n E = .69, the difference is .015 at most. The rest is chance: three standard deviations for
// m bodies, doubled because neighbours overlap together.
TEST(RigidGenerators, SoupsAreAsDenseAsAsked) {
  for (const auto& [assortment, overlapping] :
       {std::pair(Assortment::rounds, .1), {Assortment::boxes, .5}, {Assortment::hulls, .5}, {Assortment::mixed, .1}}) {
    World<double> world = make_world();
    constexpr int count = 3000;
    add_soup(world, plain_kit, assortment, count, overlapping, 5);
    std::vector<ExactShape> shapes;
    double border = 0;
    for (int i = 0; i < count; ++i) {
      shapes.push_back(exact_collider(world, i));
      for (const Vector& v : shapes.back().vertex)
        border = std::max({border, std::abs(v.x), std::abs(v.y), std::abs(v.z)});
    }
    std::vector<char> overlaps(count);
    for (int i = 0; i < count; ++i)
      for (int k = 0; k < i; ++k) {
        const Vector apart = world.bodies.pose[i].position - world.bodies.pose[k].position;
        // The largest reach .92 m from their middle.
        if (dot(apart, apart) > 1.9 * 1.9 || (overlaps[i] && overlaps[k])) continue;
        if (exact_separation(shapes[i], shapes[k]).separation <= 0) overlaps[i] = overlaps[k] = true;
      }
    int inner = 0, hits = 0;
    for (int i = 0; i < count; ++i) {
      const Vector& p = world.bodies.pose[i].position;
      if (std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > border - 2 * .92 - .92) continue;
      ++inner;
      hits += overlaps[i];
    }
    EXPECT_GT(inner, 500);
    const double deviation = std::sqrt(overlapping * (1 - overlapping) / inner);
    EXPECT_NEAR(static_cast<double>(hits) / inner, overlapping, .015 + 6 * deviation) << static_cast<int>(assortment);
  }
}

TEST(RigidMemory, CountsWhatAWorldAllocates) {
  const auto bytes = [](const auto&... arrays) {
    return (0. + ... + static_cast<double>(arrays.capacity() * sizeof(arrays[0])));
  };
  const auto bytes_of = [&](const auto& world) {
    const auto& [b, c, h] = world;
    return bytes(b.pose, b.motion, b.inverse_mass, b.friction, b.restitution) +
           bytes(c.kind, c.body, c.group, c.local, c.hull, c.size) +
           bytes(h.vertex, h.plane, h.corner, h.first_vertex, h.first_face, h.first_corner, h.centre, h.half);
  };
  World<double> bodies = make_world(), mesh = make_world();
  add_pyramid(bodies, plain_kit, 20);
  begin_body(mesh, no_offset);
  add_mesh(mesh, read_obj("scenes/rigid/hare.obj"));
  const double of_bodies = bytes_of(bodies) + bytes_of(convert<float>(bodies));
  const double of_mesh = bytes_of(mesh) + bytes_of(convert<float>(mesh));
  EXPECT_LE(of_bodies, making_bytes(pyramid_bodies(20), 0));
  EXPECT_GE(of_bodies, making_bytes(pyramid_bodies(20), 0) / 4)
      << "what is needed in making, too, but not out of all proportion";
  EXPECT_LE(of_mesh, making_bytes(0, 5120));
  EXPECT_GE(of_mesh, making_bytes(0, 5120) / 4);
}

}  // namespace
}  // namespace lockstep::rigid::worlds
