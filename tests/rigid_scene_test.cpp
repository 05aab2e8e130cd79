// Scenes of rigid bodies and frames: those of the repository load, and a scene has what its file says. Refusals are
// tested in tests/rigid_scene_refusals_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "common/convert.h"
#include "common/mesh_file.h"
#include "common/rigid/vtk.h"
#include "tests/rigid_scenes.h"
#include "tests/rigid_worlds.h"
#include "verify/domain.h"

namespace lockstep::rigid::worlds {
namespace {

// The tests run from the root of the repository, as `make test` does.

int movable(const World<float>& world) {
  int count = 0;
  for (int i = 0; i < world.bodies.count; ++i) count += world.bodies.inverse_mass[i].w > 0;
  return count;
}

TEST(RigidScenes, OfTheRepositoryLoad) {
  const std::map<std::string, int> expected{
      {"assorted", 307},    {"billiard", 16},        {"box_pit_4000", 4000},  {"boxes_100k", 100000},
      {"castle", 10000},    {"castle_hit", 10001},   {"degenerate", 44},      {"dominoes_1000", 1001},
      {"castles_4", 40000}, {"castles_16", 160000},  {"hull_soup_100k", 100000},
      {"four_bodies", 3},   {"hull_pit_2000", 2000}, {"hull_soup", 5000},     {"mesh_and_hulls", 500},
      {"pyramid_15", 1240}, {"pyramid_24", 4900},    {"pyramid_24_at_4", 4900}, {"rounds_20000", 20000},
      {"slope", 5},         {"soup_1", 10000},       {"soup_10", 10000},      {"soup_50", 10000},
      {"stack_10", 10},     {"top", 1},              {"wall", 1000},
  };
  std::map<std::string, int> found;
  for (const auto& file : std::filesystem::directory_iterator("scenes/rigid")) {
    if (file.path().extension() != ".toml") continue;
    EXPECT_EQ(verify::domain_of_scene(file.path().string()).name, "rigid");
    EXPECT_LT(std::filesystem::file_size(file.path()), 10'000u);
    const Scene scene = load_scene(file.path().string());
    found[scene.name] = movable(scene.world);
    for (int i = 0; i < scene.world.colliders.count; ++i) {
      const Colliders<float>& c = scene.world.colliders;
      EXPECT_TRUE(i == 0 || c.body[i] >= c.body[i - 1]);
      EXPECT_EQ(c.group[i], scene.world.bodies.inverse_mass[c.body[i]].w > 0 ? c.body[i] : -1);
    }
  }
  EXPECT_EQ(found, expected);
}

TEST_F(RigidSceneTest, HareIsWhatItsScriptWrites) {
  const Mesh mesh = read_obj("scenes/rigid/hare.obj");
  EXPECT_EQ(mesh.triangles.size(), 5120u);
  require_closed(mesh, "hare");
  if (std::system("python3 -c '' 2>/dev/null") != 0) GTEST_SKIP() << "no python3";
  std::filesystem::copy_file("scenes/rigid/hare.py", path("hare.py"));
  ASSERT_EQ(std::system(("python3 " + path("hare.py")).c_str()), 0);
  EXPECT_TRUE(read_bytes(path("hare.obj")) == read_bytes("scenes/rigid/hare.obj"));
}

TEST_F(RigidSceneTest, SaysWhatItSays) {
  const Scene scene = load(
      "kind = \"rigid\"\nframes = 7\nsettle = 5\ntime_step = 0.01\niterations = 3\ngravity = [1, 2, 3]\nfriction = "
      "0.25\nrestitution = "
      "0.5\n"
      "[[hull]]\nname = \"gem\"\npoints = [[-1, -1, -1], [1, 1, -1], [1, -1, 1], [-1, 1, 1]]\n"
      "[[body]]\nplane = [0, 0, -2]\nposition = [4, 5, 6]\n"
      "[[body]]\nhull = \"gem\"\ndensity = 3\nposition = [1, 2, 3]\nvelocity = [4, 5, 6]\nangular_velocity = [7, 8, "
      "9]\nfriction = 0.75\n"
      "restitution = 0.125\norientation = [0, 0, 0.6, 0.8002]\n"
      "[[body]]\nmass = 2\n[[body.part]]\nsphere = 0.5\nposition = [0, 1, 0]\n"
      "[[body.part]]\ncapsule = { half = 2, radius = 0.5 }\nposition = [0, -1, 0]\n[[body.part]]\nbox = [1, 2, 3]\n");
  EXPECT_EQ(scene.name, "a");
  EXPECT_EQ(scene.path, path("a.toml"));
  EXPECT_EQ(scene.frames, 7);
  EXPECT_EQ(scene.settle, 5);
  EXPECT_EQ(scene.iterations, 3);
  EXPECT_EQ(scene.time_step, .01);
  expect_near(scene.gravity, {1, 2, 3}, 0);
  const auto& [bodies, colliders, hulls] = scene.world;
  ASSERT_EQ(bodies.count, 3);
  ASSERT_EQ(colliders.count, 5);

  EXPECT_EQ(colliders.kind[0], static_cast<int>(Kind::plane));
  EXPECT_EQ(colliders.hull[0], -1);
  EXPECT_EQ(bodies.pose[0].position.y, 5);
  EXPECT_EQ(bodies.friction[0], .25f);
  EXPECT_EQ(bodies.restitution[0], .5f);
  const Vector3<float> normal = matrix_of(colliders.local[0].orientation) * Vector3<float>{0, 1, 0};
  expect_near({normal.x, normal.y, normal.z}, {0, 0, -1}, 1e-7);

  EXPECT_EQ(colliders.kind[1], static_cast<int>(Kind::hull));
  EXPECT_EQ(hulls.vertices(colliders.hull[1]), 4);
  EXPECT_EQ(bodies.pose[1].position.z, 3);
  EXPECT_EQ(bodies.pose[1].orientation.z, static_cast<float>(.6 / std::sqrt(.36 + .8002 * .8002))) << "made a unit";
  EXPECT_EQ(bodies.motion[1].velocity.y, 5);
  EXPECT_EQ(bodies.motion[1].angular_velocity.z, 9);
  EXPECT_EQ(bodies.friction[1], .75f);
  EXPECT_EQ(bodies.restitution[1], .125f);
  EXPECT_NEAR(bodies.inverse_mass[1].w, 1 / (3 * 8. / 3), 1e-7) << "a third of the cube around it";

  EXPECT_EQ(bodies.inverse_mass[2].w, .5f);
  const Kind kinds[] = {Kind::sphere, Kind::capsule, Kind::box};
  for (int i = 0; i < 3; ++i) EXPECT_EQ(colliders.kind[2 + i], static_cast<int>(kinds[i]));
  EXPECT_EQ(colliders.size[2].w, .5f);
  EXPECT_EQ(colliders.size[3].y, 2);
  EXPECT_EQ(colliders.size[4].z, 3);
  EXPECT_NEAR(colliders.local[2].position.y - colliders.local[3].position.y, 2, 1e-6);
}

TEST_F(RigidSceneTest, HasDefaults) {
  const Scene scene = load(head + "[[body]]\nsphere = 0.5\n");
  EXPECT_EQ(scene.time_step, 1. / 60);
  EXPECT_EQ(scene.iterations, 8);
  expect_near(scene.gravity, {0, -9.81, 0}, 0);
  EXPECT_EQ(scene.world.bodies.friction[0], .5f);
  EXPECT_EQ(scene.world.bodies.restitution[0], 0);
  EXPECT_EQ(scene.world.bodies.inverse_mass[0].w, 0) << "static";
  EXPECT_EQ(scene.world.bodies.pose[0].orientation.w, 1);
  EXPECT_EQ(movable(load(head + "[[castle]]\n[[pit]]\nof = \"rounds\"\ncount = 5\n").world), 10005);
}

TEST_F(RigidSceneTest, PlanesFaceAnyWay) {
  for (const Vector& n :
       {Vector{0, 1, 0}, {0, -1, 0}, {1, 0, 0}, {0, 0, -1}, {1, -2, 3}, {1e-4, -1, 0}, {1e-6, -1, 0}, {0, -1, 3e-3}}) {
    const std::string normal = std::to_string(n.x) + ", " + std::to_string(n.y) + ", " + std::to_string(n.z);
    const Scene scene = load(head + "[[body]]\nplane = [" + normal + "]\n");
    const World<double> world = convert<double>(scene.world);
    const Vector found = matrix_of(world.colliders.local[0].orientation) * Vector{0, 1, 0};
    // The numbers of the quaternion are rounded to float, each by 6e-8. A component of a turned vector has at most
    // eight products of them.
    expect_near(found, 1 / length(n) * n, 8 * 6e-8);
  }
}

TEST_F(RigidSceneTest, TakesHullsAndMeshesOfFiles) {
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";
  write_bytes(path("a.obj"), corners + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const Scene hull = load(head + "[[hull]]\nname = \"a\"\nfile = \"a.obj\"\n[[body]]\nhull = \"a\"\nmass = 1\n");
  EXPECT_EQ(hull.world.hulls.vertices(3), 4);
  const Scene mesh = load(head + "[[body]]\nmesh = \"a.obj\"\nposition = [1, 0, 0]\n");
  EXPECT_EQ(mesh.world.colliders.count, 4);
  EXPECT_EQ(mesh.world.colliders.kind[3], static_cast<int>(Kind::triangle));

  const std::string body = "[[body]]\nmesh = \"a.obj\"\n";
  EXPECT_EQ(error(head + "[[body]]\nmesh = \"b.obj\"\n"), "b.obj: cannot be read: No such file or directory");
  write_bytes(path("a.obj"), corners + "f 1 3 2\nf 1 2 4\nf 1 4 3\n");
  EXPECT_EQ(error(head + body), "a.obj: the edge of points 2 and 3 is in 1 triangle, expected two: a closed mesh");
  write_bytes(path("a.obj"), corners + "f 1 2 9\n");
  EXPECT_EQ(error(head + body), "a.obj:5: f: point 9 of 4");
  write_bytes(path("a.obj"), "v 0 0 0\nv 2e5 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  EXPECT_EQ(error(head + body), "a.obj: point 2 is not within 1e5 m of the origin");
  write_bytes(path("a.obj"), "v 0 0 0\nv 1 0 0\nv 0.5 0 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  EXPECT_EQ(error(head + body), "a.obj: triangle 1 is thinner than a plane needs");
  EXPECT_EQ(error(head + "[[hull]]\nname = \"a\"\nfile = \"a.obj\"\n[[body]]\nhull = \"a\"\nmass = 1\n"),
            "a.obj: the points are flat");
}

// --- Frames

struct Frame {
  std::vector<Vector> points;
  std::vector<std::vector<int>> cells;
  std::vector<int> body;
  std::vector<float> speed;
};

// Reads the file as ParaView does, and expects nothing else in it.
Frame read_vtk(const std::string& bytes) {
  Frame frame;
  std::size_t at = 0;
  const auto line = [&] {
    const std::size_t end = bytes.find('\n', at);
    const std::string text = bytes.substr(at, end - at);
    at = end + 1;
    return text;
  };
  const auto word = [&] {
    std::uint32_t x = 0;
    for (int k = 0; k < 4; ++k) x = x << 8 | static_cast<unsigned char>(bytes.at(at++));
    return x;
  };
  const auto real = [&] { return std::bit_cast<float>(word()); };
  for (const char* text : {"# vtk DataFile Version 3.0", "Lockstep rigid bodies", "BINARY", "DATASET POLYDATA"})
    EXPECT_EQ(line(), text);
  int points = 0, cells = 0, words = 0;
  EXPECT_EQ(std::sscanf(line().c_str(), "POINTS %d float", &points), 1);
  for (int i = 0; i < points; ++i) {
    const double x = real(), y = real(), z = real();
    frame.points.push_back({x, y, z});
  }
  EXPECT_EQ(line(), "");
  EXPECT_EQ(std::sscanf(line().c_str(), "POLYGONS %d %d", &cells, &words), 2);
  for (int i = 0; i < cells; ++i) {
    frame.cells.emplace_back(word());
    words -= 1 + static_cast<int>(frame.cells.back().size());
    for (int& corner : frame.cells.back()) {
      corner = static_cast<int>(word());
      EXPECT_TRUE(corner >= 0 && corner < points);
    }
  }
  EXPECT_EQ(words, 0);
  EXPECT_EQ(line(), "");
  EXPECT_EQ(line(), "CELL_DATA " + std::to_string(cells));
  EXPECT_EQ(line(), "SCALARS body int 1");
  EXPECT_EQ(line(), "LOOKUP_TABLE default");
  for (int i = 0; i < cells; ++i) frame.body.push_back(static_cast<int>(word()));
  EXPECT_EQ(line(), "");
  EXPECT_EQ(line(), "SCALARS speed float 1");
  EXPECT_EQ(line(), "LOOKUP_TABLE default");
  for (int i = 0; i < cells; ++i) frame.speed.push_back(real());
  EXPECT_EQ(line(), "");
  EXPECT_EQ(at, bytes.size());
  return frame;
}

// The volume inside the cells of a body by the divergence theorem; the cells must be counterclockwise from outside.
double volume_of(const Frame& frame, int body) {
  double sum = 0;
  for (std::size_t c = 0; c < frame.cells.size(); ++c) {
    if (frame.body[c] != body) continue;
    const auto& cell = frame.cells[c];
    for (std::size_t k = 1; k + 1 < cell.size(); ++k)
      sum += dot(frame.points[cell[0]], cross(frame.points[cell[k]], frame.points[cell[k + 1]])) / 6;
  }
  return sum;
}

TEST_F(RigidSceneTest, WritesFramesForParaView) {
  write_bytes(path("a.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const Scene scene =
      load(head +
           "[[hull]]\nname = \"a\"\nfile = \"a.obj\"\n"
           "[[body]]\nbox = [0.5, 1, 1.5]\nposition = [1, 2, 3]\norientation = [0, 0.6, 0, 0.8]\nmass = 1\n"
           "velocity = [2, 3, 6]\n"
           "[[body]]\nsphere = 0.5\nposition = [-1, 2, 0]\n[[body]]\ncapsule = { half = 2, radius = 0.5 }\n"
           "[[body]]\nhull = \"a\"\nmass = 1\n[[body]]\nmesh = \"a.obj\"\n[[body]]\nplane = [0, 1, 0]\nposition = [0, "
           "-3, 0]\n");
  const auto frame_of = [&](Part part) {
    EXPECT_TRUE(has(scene.world, part));
    write_surfaces(path("a.vtk"), scene.world, part);
    return read_vtk(read_bytes(path("a.vtk")));
  };
  const Frame moving = frame_of(Part::moving), fixed = frame_of(Part::fixed), planes = frame_of(Part::planes);
  const auto cells_of = [](const Frame& frame, int body) { return std::ranges::count(frame.body, body); };
  EXPECT_EQ(cells_of(moving, 0), 6);
  EXPECT_EQ(cells_of(moving, 3), 4);
  EXPECT_EQ(moving.cells.size(), 10u);
  EXPECT_EQ(cells_of(fixed, 4), 4);
  EXPECT_EQ(cells_of(fixed, 0) + cells_of(fixed, 3) + cells_of(fixed, 5), 0);
  EXPECT_EQ(planes.body, std::vector{5});
  for (std::size_t c = 0; c < moving.cells.size(); ++c) EXPECT_EQ(moving.speed[c], moving.body[c] == 0 ? 7 : 0);
  // Points are floats, of some metres.
  EXPECT_NEAR(volume_of(moving, 0), 6, 1e-5);
  EXPECT_NEAR(volume_of(moving, 3), 1. / 6, 1e-6);
  EXPECT_NEAR(volume_of(fixed, 4), 1. / 6, 1e-6);
  // The corners lie on the sphere: the volume is less than the sphere's, and more than half of it.
  const double sphere = volume_of(fixed, 1), capsule = volume_of(fixed, 2);
  EXPECT_LT(sphere, M_PI / 6);
  EXPECT_GT(sphere, M_PI / 12);
  EXPECT_NEAR(capsule - sphere, 4 * .25 * 4 * std::sin(M_PI / 4), 1e-5) << "a prism of eight sides";
  for (const Vector& p : planes.points) EXPECT_EQ(p.y, -3);
  EXPECT_EQ(error_of([&] { write_surfaces(path("none/a.vtk"), scene.world, Part::moving); }),
            path("none/a.vtk") + ": cannot be written: No such file or directory");
  EXPECT_EQ(error_of([&] { write_bodies(path("none/a.vtk"), scene.world); }),
            path("none/a.vtk") + ": cannot be written: No such file or directory");
}

}  // namespace
}  // namespace lockstep::rigid::worlds
