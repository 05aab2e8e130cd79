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
  const std::map<std::string, std::pair<int, int>> expected{
      {"bar_shaken", {4608, 2}}, {"block_370k", {373248, 1}}, {"inside_out", {5292, 1}}, {"one_cell", {12, 1}}};
  std::map<std::string, std::pair<int, int>> found;
  for (const auto& file : std::filesystem::directory_iterator("scenes/production_face")) {
    const Scene scene = load_scene(file.path().string());
    found[scene.name] = {scene.body.tetrahedra, scene.body.muscles};
    EXPECT_EQ(scene.pose.activation.size(), static_cast<std::size_t>(scene.body.muscles));
    EXPECT_GT(scene.body.first_fibre.back(), 0);
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

TEST_F(ProductionFaceSceneTest, Refusals) {
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
