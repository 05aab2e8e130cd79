// Scenes of the production face: those of the repository load, muscles are where they say, a bad one is refused.
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>

#include "common/memory.h"
#include "common/production_face/scene.h"
#include "tests/temporary_folder.h"

namespace lockstep::production_face {
namespace {

struct ProductionFaceSceneTest : TemporaryFolder {
  Scene load(const std::string& toml) const {
    write_bytes(path("a.toml"), "kind = \"production_face\"\n" + toml);
    return load_scene(path("a.toml"));
  }
  std::string error(const std::string& toml) const {
    return error_of([&] { load(toml); }).substr(folder.size() + 1);
  }
};

// Run from the root of the repository, as `make test` does.
TEST(ProductionFaceScenes, OfTheRepositoryLoad) {
  const std::map<std::string, std::pair<int, int>> expected{{"bar_pulls", {6144, 2}},
                                                            {"bar_shaken", {4608, 2}},
                                                            {"bar_turns", {9216, 1}},
                                                            {"crushed", {1728, 0}},
                                                            {"inside_out", {5292, 1}},
                                                            {"block_370k", {373248, 1}},
                                                            {"twelve", {12, 1}},
                                                            {"face_6k", {6061, 32}},
                                                            {"face_smile", {46156, 32}},
                                                            {"face_frown", {46156, 32}},
                                                            {"face_pucker", {46156, 32}},
                                                            {"face_open_mouth", {46156, 32}},
                                                            {"face_surprise", {46156, 32}},
                                                            {"face_381k", {380622, 32}}};
  std::map<std::string, std::pair<int, int>> found;
  for (const auto& file : std::filesystem::directory_iterator("scenes/production_face")) {
    const Scene scene = load_scene(file.path().string());
    found[scene.name] = {scene.body.tetrahedra, scene.body.muscles};
    EXPECT_EQ(scene.pose.activation.size(), static_cast<std::size_t>(scene.body.muscles));
    EXPECT_EQ(scene.body.first_fibre.back() > 0, scene.body.muscles > 0);
  }
  EXPECT_EQ(found, expected);
}

TEST_F(ProductionFaceSceneTest, MusclesAreCapsules) {
  const Scene scene = load(
      "[lattice]\ncells = [4, 4, 4]\nspacing = 0.5\n"
      "[[muscle]]\nfrom = [0.5, 1, 1]\nto = [1.5, 1, 1]\nradius = 0.3\nshare = 0.25\n");
  const Body<float>& body = scene.body;
  int with_fibre = 0;
  for (int t = 0; t < body.tetrahedra; ++t) {
    Vector3<float> centroid = {0, 0, 0};
    for (int a = 0; a < 4; ++a) centroid = centroid + .25f * lockstep::load(body.rest, body.corner.at(t, a));
    const float x = std::min(std::max(centroid.x, .5f), 1.5f);
    const bool inside = std::hypot(centroid.x - x, centroid.y - 1, centroid.z - 1) <= .3f;
    bool has_one = false;
    for (int slot = body.first_fibre[t / lanes]; slot < body.first_fibre[t / lanes + 1]; ++slot) {
      const int place = slot * lanes + t % lanes;
      if (body.muscle.at(place, 0) < 0) continue;
      has_one = true;
      EXPECT_EQ(body.fibre.at(place, 0), 1);
      EXPECT_EQ(body.fibre.at(place, 3), .25f);
    }
    EXPECT_EQ(has_one, inside) << t;
    with_fibre += has_one;
  }
  EXPECT_GT(with_fibre, 20);
}

TEST_F(ProductionFaceSceneTest, ShakesWithinItsBound) {
  const Scene scene = load("shake = 0.25\n[lattice]\ncells = [5, 5, 5]\nspacing = 1\n");
  float most = 0;
  for (const float d : scene.pose.displacement.x) most = std::max(most, std::abs(d));
  EXPECT_LE(most, .25f);
  EXPECT_GT(most, .24f);
  for (const float d : load("[lattice]\ncells = [1, 1, 1]\nspacing = 1\n").pose.displacement.x) EXPECT_EQ(d, 0);
}

TEST_F(ProductionFaceSceneTest, BonesHoldNodesAndKeysMoveThem) {
  const Scene scene = load(
      "[lattice]\ncells = [2, 1, 1]\nspacing = 1\n"
      "[[muscle]]\nname = \"m left\"\nfrom = [0, 0, 0]\nto = [2, 0, 0]\nradius = 2\nactivation = 0.25\n"
      "[[muscle]]\nname = \"m right\"\nfrom = [0, 1, 0]\nto = [2, 1, 0]\nradius = 2\n"
      "[[bone]]\nname = \"a\"\nfrom = [0, 0, 0]\nto = [0, 1, 1]\n[[bone]]\nname = \"b\"\nfrom = [2, 0, 0]\nto = [2, 1, "
      "1]\n"
      "[[key]]\ntime = 2\n[[key.pull]]\nmuscle = \"m\"\nactivation = 1\n"
      "[[key.move]]\nbone = \"b\"\nturn = [0, 0, 3.141592653589793]\nshift = [0, 0, 1]\n");
  ASSERT_EQ(scene.body.held.size(), 8u);
  const Key start = key_at(scene.motion, 0), half = key_at(scene.motion, .5), end = key_at(scene.motion, 5);
  EXPECT_EQ(start.activation, (std::vector<float>{.25f, 0}));
  EXPECT_EQ(half.activation, (std::vector<float>{.25f + .75f * .15625f, .15625f}));  // w = 1/4: 3 / 16 - 2 / 64
  EXPECT_EQ(end.activation, (std::vector<float>{1, 1}));
  EXPECT_DOUBLE_EQ(half.bones[1].shift.z, .15625);
  const Target<float> target = target_at(scene.body, scene.motion, 2);
  for (std::size_t k = 0; k < scene.body.held.size(); ++k) {
    const Vector3<float> x = lockstep::load(scene.body.rest, scene.body.held[k]), d = lockstep::load(target.held, k);
    const bool moves = x.x == 2;  // half a turn about z and the origin
    EXPECT_NEAR(d.x, moves ? -2 * x.x : 0, 1e-6);
    EXPECT_NEAR(d.y, moves ? -2 * x.y : 0, 1e-6);
    EXPECT_EQ(d.z, moves ? 1 : 0);
  }
}

TEST_F(ProductionFaceSceneTest, KeysRepeatIfTold) {
  const std::string toml =
      "[lattice]\ncells = [1, 1, 1]\nspacing = 1\n[[bone]]\nname = \"a\"\nfrom = [0, 0, 0]\nto = [0, 1, 1]\n"
      "[[key]]\ntime = 1\n[[key.move]]\nbone = \"a\"\nshift = [1, 0, 0]\n[[key]]\ntime = 2\n";
  const Motion once = load(toml).motion, again = load("repeat = true\n" + toml).motion;
  for (const double time : {0., .5, 1., 1.75, 2.}) {
    const double x = key_at(once, time).bones[0].shift.x;
    EXPECT_DOUBLE_EQ(key_at(again, time).bones[0].shift.x, x);
    EXPECT_DOUBLE_EQ(key_at(again, time + 2).bones[0].shift.x, x);
    EXPECT_EQ(key_at(once, time + 2).bones[0].shift.x, 0);
  }
}

TEST_F(ProductionFaceSceneTest, Refusals) {
  const std::string box = "[lattice]\ncells = [1, 1, 1]\nspacing = 1\n";
  EXPECT_EQ(error(box + "[face]\nspacing = 0.01\n"),
            "a.toml:1:1: expected exactly one of lattice, mesh, face and facesim");
  EXPECT_EQ(error("[face]\nspacing = 0.01\n[[bone]]\nname = \"a\"\nfrom = [0, 0, 0]\nto = [1, 1, 1]\n"),
            "a.toml:4:1: bone: expected none beside [face], which has its own");
  EXPECT_EQ(error(box + "[[key]]\ntime = 1\n[[key]]\ntime = 1\n"),
            "a.toml:8:8: time: expected a later time than the key's before");
  EXPECT_EQ(error(box + "[[key]]\ntime = 1\n[[key.pull]]\nmuscle = \"a\"\nactivation = 1\n"),
            "a.toml:8:10: muscle: expected the name of a muscle");
  EXPECT_EQ(error("[lattice]\ncells = [1.5, 1, 1]\nspacing = 1\n"), "a.toml:3:9: cells: expected three whole numbers");
  EXPECT_EQ(error("[lattice]\ncells = [1, 1, 1]\nspacing = 1\n"
                  "[[muscle]]\nfrom = [1, 1, 1]\nto = [1, 1, 1]\nradius = 1\n"),
            "a.toml:7:6: to: expected another point than `from`");
  limit_memory(1e8);
  EXPECT_EQ(error("[lattice]\ncells = [100, 100, 100]\nspacing = 1\n"),
            "a.toml:2:1: 12000000 tetrahedra needs 6000 MB of memory, and 100 MB is available");
  limit_memory(std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace lockstep::production_face
