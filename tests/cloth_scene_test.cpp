// Scenes of the game cloth and frames: those of the repository load, and a scene has what its file says. Refusals are
// tested in tests/cloth_scene_refusals_test.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/cloth/limits.h"
#include "common/cloth/make.h"
#include "common/cloth/vtk.h"
#include "tests/cloth_scenes.h"
#include "verify/domain.h"

namespace lockstep::cloth {
namespace {

std::vector<int> pinned(const Cloth<double>& cloth) {
  std::vector<int> particles;
  for (int r = 0; r < cloth.sheet.rows; ++r)
    for (int c = 0; c < cloth.sheet.columns; ++c)
      if (cloth.inverse_mass[cloth.sheet.index(r, c)] == 0) particles.push_back(r * cloth.sheet.columns + c);
  return particles;
}

// The tests run from the root of the repository, as `make test` does.

TEST(ClothScenes, OfTheRepositoryLoad) {
  const std::map<std::string, std::pair<int, int>> sizes{
      {"flag_128", {128, 128}},
      {"flag_256", {256, 256}},
      {"flag_1024", {1024, 1024}},
      {"flag_128_substeps", {128, 128}},
      {"flag_33", {33, 47}},
      {"tiny", {5, 5}},
      {"curtain", {64, 97}},
      {"sheet_on_sphere", {80, 80}},
      {"sheet_over_box_and_capsule", {64, 96}},
      {"pulled_edge", {64, 64}},
      {"rope", {1, 33}},
      {"garment", {0, 0}},
      {"napkin", {0, 0}},
      {"washing_line", {1, 33}},
      {"flags_64", {128, 128}},
  };
  std::map<std::string, std::pair<int, int>> found;
  for (const auto& file : std::filesystem::directory_iterator("scenes/cloth")) {
    if (file.path().extension() != ".toml") continue;
    EXPECT_EQ(verify::domain_of_scene(file.path().string()).name, "cloth");
    const Scene scene = load_scene(file.path().string());
    found[scene.name] = {scene.cloth.sheet.rows, scene.cloth.sheet.columns};
    EXPECT_GT(scene.cloth.constraints.count, 0) << scene.name;
  }
  EXPECT_EQ(found, sizes);
}

TEST_F(ClothSceneTest, GarmentIsWhatItsScriptWrites) {
  if (std::system("python3 -c '' 2>/dev/null") != 0) GTEST_SKIP() << "no python3";
  std::filesystem::copy_file("scenes/cloth/garment.py", path("garment.py"));
  ASSERT_EQ(std::system(("python3 " + path("garment.py")).c_str()), 0);
  EXPECT_TRUE(read_bytes(path("garment.obj")) == read_bytes("scenes/cloth/garment.obj"));
}

TEST_F(ClothSceneTest, SaysWhatItSays) {
  const Scene scene =
      load(head +
           "frames = 7\ntime_step = 0.02\nsubsteps = 4\niterations = 0\ngravity = [1, 2.5, -3]\nwind = [4, 5, 6]\n"
           "drag = 1.2\ndamping = 0.5\nfriction = 0.25\n" +
           sheet + "bending = true\n");
  EXPECT_EQ(scene.name, "a");
  EXPECT_EQ(scene.path, path("a.toml"));
  EXPECT_EQ(scene.frames, 7);
  const Model<double>& model = scene.cloth.model;
  EXPECT_EQ(model.time_step, .005);
  EXPECT_EQ(model.substeps, 4);
  EXPECT_EQ(model.iterations, 0);
  EXPECT_EQ(model.gravity.y, 2.5);
  EXPECT_EQ(model.wind.z, 6);
  EXPECT_EQ(model.drag, 1.2);
  EXPECT_DOUBLE_EQ(model.velocity_factor, std::exp(-.0025));
  EXPECT_EQ(scene.cloth.bodies.friction, .25);
  EXPECT_EQ(scene.bodies.friction, .25);

  const Cloth<double>& cloth = scene.cloth;
  EXPECT_EQ(cloth.sheet.rows, 3);
  EXPECT_EQ(cloth.sheet.columns, 5);
  const int last = cloth.sheet.index(2, 4);
  EXPECT_EQ(cloth.position.x[last], 5);
  EXPECT_EQ(cloth.position.y[last], 1);
  EXPECT_EQ(cloth.previous.z[last], 3);
  EXPECT_DOUBLE_EQ(cloth.inverse_mass[last], 15 / .3);
  EXPECT_EQ(cloth.families.size(), 6u);
  EXPECT_EQ(pinned(cloth), std::vector<int>{});
}

TEST_F(ClothSceneTest, HasDefaults) {
  const Scene scene = load(head + sheet);
  EXPECT_EQ(scene.frames, 300);
  const Model<double>& model = scene.cloth.model;
  EXPECT_EQ(model.time_step, 1. / 60);
  EXPECT_EQ(model.substeps, 1);
  EXPECT_EQ(model.iterations, 20);
  EXPECT_EQ(model.gravity.y, -9.81);
  EXPECT_EQ(model.wind.x, 0);
  EXPECT_EQ(model.drag, 0);
  EXPECT_EQ(model.velocity_factor, 1);
  EXPECT_EQ(scene.cloth.bodies.friction, 0);
  EXPECT_EQ(scene.cloth.families.size(), 4u);
  EXPECT_TRUE(scene.cloth.bodies.planes.empty() && scene.cloth.bodies.capsules.empty() &&
              scene.cloth.bodies.boxes.empty());
}

TEST_F(ClothSceneTest, PinsEdgesCornersAndParticles) {
  const auto of = [&](const std::string& pins) { return pinned(load(head + sheet + "pins = " + pins + '\n').cloth); };
  using Numbers = std::vector<int>;
  EXPECT_EQ(of("[]"), Numbers{});
  EXPECT_EQ(of("[\"top\"]"), (Numbers{0, 1, 2, 3, 4}));
  EXPECT_EQ(of("[\"bottom\"]"), (Numbers{10, 11, 12, 13, 14}));
  EXPECT_EQ(of("[\"left\"]"), (Numbers{0, 5, 10}));
  EXPECT_EQ(of("[\"right\"]"), (Numbers{4, 9, 14}));
  EXPECT_EQ(of("[\"top_left\", \"top_right\", \"bottom_left\", \"bottom_right\"]"), (Numbers{0, 4, 10, 14}));
  EXPECT_EQ(of("[[1, 2]]"), (Numbers{7}));
  EXPECT_EQ(of("[[1, 2], \"left\", \"top_left\", [0, 0], [1, 2]]"), (Numbers{0, 5, 7, 10})) << "pinned twice is pinned";
}

TEST_F(ClothSceneTest, PullsAnEdgeAndPinsIt) {
  const Scene still = load(head + sheet),
              pulled = load(head + sheet + "pull = { edge = \"right\", by = [0.5, 0.25, -1] }\n");
  EXPECT_EQ(pinned(pulled.cloth), (std::vector<int>{4, 9, 14}));
  const int moved = pulled.cloth.sheet.index(1, 4), unmoved = pulled.cloth.sheet.index(1, 3);
  for (const Vectors<double>& points : {pulled.cloth.position, pulled.cloth.previous}) {
    EXPECT_EQ(points.x[moved], still.cloth.position.x[moved] + .5);
    EXPECT_EQ(points.y[moved], still.cloth.position.y[moved] + .25);
    EXPECT_EQ(points.z[moved], still.cloth.position.z[moved] - 1);
    EXPECT_EQ(points.x[unmoved], still.cloth.position.x[unmoved]);
  }
  EXPECT_EQ(pulled.cloth.families[1].rest_2, still.cloth.families[1].rest_2);
}

TEST_F(ClothSceneTest, MakesBodiesThickerForTheCloth) {
  const Scene scene = load(head + "thickness = 0.1\n" + sheet +
                           "[[plane]]\nnormal = [0, 2, 0]\npoint = [7, 3, 7]\n"
                           "[[sphere]]\ncentre = [1, 2, 3]\nradius = 0.5\n"
                           "[[capsule]]\nfrom = [0, 0, 0]\nto = [0, 1, 0]\nradius = 0.25\n"
                           "[[box]]\ncentre = [4, 5, 6]\nhalf = [1, 2, 3]\n"
                           "[[box]]\ncentre = [4, 5, 6]\nhalf = [1, 2, 3]\nturn = [90, 0, 90]\n");
  ASSERT_EQ(scene.bodies.planes.size(), 1u);
  ASSERT_EQ(scene.bodies.capsules.size(), 2u);
  ASSERT_EQ(scene.bodies.boxes.size(), 2u);
  EXPECT_EQ(scene.bodies.planes[0].normal.y, 1);
  EXPECT_EQ(scene.bodies.planes[0].offset, 3);
  EXPECT_DOUBLE_EQ(scene.cloth.bodies.planes[0].offset, 3.1);
  EXPECT_EQ(scene.bodies.capsules[0].from.z, scene.bodies.capsules[0].to.z);
  EXPECT_EQ(scene.bodies.capsules[0].radius, .5);
  EXPECT_DOUBLE_EQ(scene.cloth.bodies.capsules[0].radius, .6);
  EXPECT_EQ(scene.bodies.capsules[1].to.y, 1);
  EXPECT_EQ(scene.bodies.boxes[0].half.z, 3);
  EXPECT_DOUBLE_EQ(scene.cloth.bodies.boxes[0].half.z, 3.1);
  EXPECT_EQ(scene.bodies.boxes[0].axis[1].y, 1);
  // The turn about x takes y to z and z to -y. The turn about z then takes x to y and -y to x.
  const auto [x, y, z] = scene.bodies.boxes[1].axis;
  EXPECT_NEAR(x.y, 1, 1e-15);
  EXPECT_NEAR(y.z, 1, 1e-15);
  EXPECT_NEAR(z.x, 1, 1e-15);
}

TEST_F(ClothSceneTest, TakesAMesh) {
  write_bytes(path("a.obj"), square + "f 1 2 3\nf 1 3 4\n");
  const Cloth<double> cloth = load(head + mesh + "scale = 2\nbending = true\npins_above = 1.5\n").cloth;
  EXPECT_EQ(cloth.count, 4);
  EXPECT_EQ(cloth.sheet.rows, 0);
  EXPECT_EQ(cloth.position.x[2], 2);
  EXPECT_EQ(cloth.constraints.count, 6 - 1) << "four sides, two diagonals, none between the two pinned";
  EXPECT_EQ(cloth.inverse_mass[0], 4 / .3);
  EXPECT_EQ(cloth.inverse_mass[2], 0);
  EXPECT_EQ(cloth.inverse_mass[3], 0);
}

TEST_F(ClothSceneTest, KnowsItsKind) {
  const auto kind = [&](const std::string& toml) {
    write_bytes(path("a.toml"), toml);
    return verify::domain_of_scene(path("a.toml")).name;
  };
  EXPECT_EQ(kind("kind = \"fluid\"\n"), "fluid");
  EXPECT_EQ(kind(head + "whatever = 1\n"), "cloth");
  EXPECT_EQ(kind("kind = \"levelset\"\n"), "levelset");
  EXPECT_EQ(verify::domain_of_scene(path("none.fluid")).name, "fluid");
  const auto error = [&](const std::string& toml) { return without_folder(error_of([&] { kind(toml); })); };
  EXPECT_EQ(error("frames = 1\n"), "a.toml:1:1: kind is missing");
  const std::string known = "expected \"fluid\", \"cloth\", \"levelset\"";
  EXPECT_EQ(error("frames = 1\nkind = \"sand\"\n").rfind("a.toml:2:8: kind: " + known, 0), 0u);
  EXPECT_EQ(error("kind = 1\n").rfind("a.toml:1:8: kind: " + known, 0), 0u);
  EXPECT_EQ(error("kind = \n").rfind("a.toml:1:", 0), 0u);
  EXPECT_EQ(without_folder(error_of([&] { verify::domain_of_scene(path("none.toml")); })),
            "none.toml: cannot be read: No such file or directory");
}

TEST(ClothMemory, CountsWhatAClothAllocates) {
  const Scene scene = load_scene("scenes/cloth/flag_33.toml");
  const auto bytes = [](const auto&... arrays) { return (0. + ... + (arrays.size() * sizeof(arrays[0]))); };
  const auto bytes_of = [&](const auto& c) {
    double sum = bytes(c.inverse_mass, c.triangles, c.corner_begin, c.corner);
    for (const auto& v : {c.position, c.previous, c.force}) sum += bytes(v.x, v.y, v.z);
    for (const auto& list : {c.constraints, c.batched}) sum += bytes(list.a, list.b, list.rest_2);
    return sum;
  };
  const double kept = bytes_of(scene.cloth) + bytes_of(convert<float>(scene.cloth));
  const double counted = making_bytes(33 * 48, 6 * 33 * 48, 2 * 34 * 64, 12);
  EXPECT_LE(kept, counted);
  EXPECT_GE(kept, counted / 6) << "what is needed in making, too, but not out of all proportion";
}

// Memory for constraints beyond the first 64 batches grows with their number. An earlier count charged every particle
// with all batches of the busiest one.
TEST(ClothMemory, CountsAFanByItsConstraints) {
  const double triangles = 100'000;
  EXPECT_LT(making_bytes(triangles + 1, 6 * triangles, triangles, 4 * triangles), 5e8);
}

// --- Meshes

TEST_F(ClothSceneTest, TakesOpenAndNonManifoldMeshes) {
  // Three triangles share one edge, and one hangs by a corner.
  const std::string obj = square + "v 0.5 0 1\nv 3 0 0\nv 3 1 0\nf 1 2 3\nf 1 2 4\nf 1 2 5\nf 2 6 7\n";
  write_bytes(path("a.obj"), obj);
  const Cloth<double> cloth = load(head + mesh + "bending = true\n").cloth;
  EXPECT_EQ(cloth.constraints.count, 3 + 2 + 2 + 3 + 2);
}

// --- Several cloths

TEST_F(ClothSceneTest, TakesSeveralSheetsAndMeshesAndTheirCopies) {
  write_bytes(path("a.obj"), square + "f 1 2 3\nf 1 3 4\n");
  const std::string several =
      "[[sheet]]\nrows = 2\ncolumns = 3\norigin = [0, 0, 0]\nwidth = [2, 0, 0]\nheight = [0, "
      "-1, 0]\nmass = 1\ncopies = 3\nshift = [0, 1, 0.5]\n[[sheet]]\nrows = 1\ncolumns = "
      "2\norigin = [0, 0, 0]\nwidth = [1, 0, 0]\nheight = [0, 0, 0]\nmass = 1\n[[mesh]]\nfile "
      "= \"a.obj\"\nmass = 1\ncopies = 2\nshift = [5, 0, 0]\n";
  const Scene scene = load(head + several);
  ASSERT_EQ(scene.others.size(), 5u);
  const auto first_of = [&](int k) { return lockstep::load(scene.others[k].position, 0); };
  EXPECT_EQ(lockstep::load(scene.cloth.position, 0).y, 0);
  EXPECT_EQ(first_of(0).y, 1);
  EXPECT_EQ(first_of(1).y, 2);
  EXPECT_EQ(first_of(1).z, 1);
  EXPECT_EQ(lockstep::load(scene.others[1].previous, 0).y, 2);
  EXPECT_EQ(scene.others[1].position.x[3], 0) << "padding stays where it is";
  EXPECT_EQ(scene.others[2].sheet.columns, 2);
  EXPECT_EQ(scene.others[3].sheet.rows, 0);
  EXPECT_EQ(first_of(4).x, first_of(3).x + 5);
  EXPECT_EQ(scene.others[0].constraints.rest_2, scene.cloth.constraints.rest_2);
}

// --- Frames

std::string big_endian(const auto... numbers) {
  std::string bytes;
  for (const auto x : {numbers...}) {
    const char* word = reinterpret_cast<const char*>(&x);
    bytes.append(std::reverse_iterator(word + sizeof x), std::reverse_iterator(word));
  }
  return bytes + '\n';
}

TEST_F(ClothSceneTest, WritesFramesForParaView) {
  Cloth<float> cloth = convert<float>(load(head + "time_step = 0.5\n[sheet]\nrows = 2\ncolumns = 2\norigin = [1, 2, "
                                                  "3]\nwidth = [1, 0, 0]\nheight = [0, -1, 0]\nmass = 1\n")
                                          .cloth);
  cloth.previous.x[cloth.sheet.index(1, 0)] -= 1;
  write_vtk(path("a.vtk"), {&cloth, 1});
  EXPECT_EQ(read_bytes(path("a.vtk")),
            "# vtk DataFile Version 3.0\nLockstep cloth\nBINARY\nDATASET POLYDATA\nPOINTS 4 float\n" +
                big_endian(1.f, 2.f, 3.f, 2.f, 2.f, 3.f, 1.f, 1.f, 3.f, 2.f, 1.f, 3.f) + "POLYGONS 2 8\n" +
                big_endian(3, 0, 1, 2, 3, 3, 2, 1) + "POINT_DATA 4\nVECTORS velocity float\n" +
                big_endian(0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 2.f, 0.f, 0.f, 0.f, 0.f, 0.f));
  EXPECT_EQ(error_of([&] {
              write_vtk(path("none/a.vtk"), {&cloth, 1});
            }),
            path("none/a.vtk") + ": cannot be written: No such file or directory");
  EXPECT_EQ(files(), 2);
}

TEST_F(ClothSceneTest, WritesSeveralClothsIntoOneFrame) {
  const std::string rope =
      "[[sheet]]\nrows = 1\ncolumns = 2\norigin = [7, 8, 9]\nwidth = [1, 0, 0]\nheight = [0, 0, "
      "0]\nmass = 1\n";
  const std::string square =
      "[[sheet]]\nrows = 2\ncolumns = 2\norigin = [0, 0, 0]\nwidth = [1, 0, 0]\nheight = [0, "
      "-1, 0]\nmass = 1\n";
  const Scene scene = load(head + rope + square);
  const std::vector<Cloth<float>> cloths = {convert<float>(scene.cloth), convert<float>(scene.others[0])};
  write_vtk(path("a.vtk"), cloths);
  EXPECT_EQ(read_bytes(path("a.vtk")),
            "# vtk DataFile Version 3.0\nLockstep cloth\nBINARY\nDATASET POLYDATA\nPOINTS 6 float\n" +
                big_endian(7.f, 8.f, 9.f, 8.f, 8.f, 9.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, -1.f, 0.f, 1.f, -1.f, 0.f) +
                "LINES 1 3\n" + big_endian(2, 0, 1) + "POLYGONS 2 8\n" + big_endian(3, 2, 3, 4, 3, 5, 4, 3) +
                "POINT_DATA 6\nVECTORS velocity float\n" +
                big_endian(0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f));
}

TEST_F(ClothSceneTest, WritesARopeAsALine) {
  for (const char* size : {"rows = 1\ncolumns = 3", "rows = 3\ncolumns = 1"}) {
    const Scene rope = load(head + "[sheet]\n" + size +
                            "\norigin = [0, 0, 0]\nwidth = [2, 0, 0]\nheight = [2, 0, 0]\nmass = 1\nbending = true\n");
    const Cloth<float> cloth = convert<float>(rope.cloth);
    write_vtk(path("a.vtk"), {&cloth, 1});
    EXPECT_EQ(read_bytes(path("a.vtk")),
              "# vtk DataFile Version 3.0\nLockstep cloth\nBINARY\nDATASET POLYDATA\nPOINTS 3 float\n" +
                  big_endian(0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 2.f, 0.f, 0.f) + "LINES 1 4\n" + big_endian(3, 0, 1, 2) +
                  "POINT_DATA 3\nVECTORS velocity float\n" + big_endian(0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f, 0.f));
  }
}

}  // namespace
}  // namespace lockstep::cloth
