// Folders of frames: of one run at a time, and of nothing but that run. What the files hold: tests/frames_test.py.
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "tests/cli.h"

namespace lockstep {
namespace {

const std::string two_balls =
    "kind = \"rigid\"\nframes = 3\ntime_step = 0.01\n[[body]]\nplane = [0, 1, 0]\n[[body]]\nbox = [1, 1, 1]\n"
    "[[body]]\nsphere = 0.5\nposition = [0, 3, 0]\nmass = 2\n";

struct Frames : Cli {
  std::vector<std::string> of(const std::string& scene, const std::string& out, int frames,
                              const std::vector<std::string>& more = {}) const {
    // clang-format off
    std::vector<std::string> arguments = {"run", "--scene", scene, "--out", path(out),
                                          "--frames", std::to_string(frames), "--threads", "1"};
    // clang-format on
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }

  std::set<std::string> names_in(const std::string& out) const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path(out))) names.insert(entry.path().filename());
    return names;
  }

  nlohmann::json series(const std::string& file) const { return nlohmann::json::parse(read_bytes(path(file))); }
};

TEST_F(Frames, OfAnotherRunAreRefusedOrReplaced) {
  const std::string fluid = scene(good_scene, "fluid.toml"), cloth = scene(good_cloth, "cloth.toml"),
                    rigid = scene(two_balls, "rigid.toml");
  ASSERT_EQ(run(of(rigid, "alone", 2)).code, 0);
  const std::set<std::string> alone = names_in("alone");
  EXPECT_EQ(alone, (std::set<std::string>{"frame_00000.vtk", "frame_00001.vtk", "frame_00002.vtk", "frame.vtk.series",
                                          "bodies_00000.vtk", "bodies_00001.vtk", "bodies_00002.vtk",
                                          "bodies.vtk.series", "static.vtk", "ground.vtk", "state.lockstep"}));

  // What is a user's own stays, whatever it is called like.
  std::filesystem::create_directory(path("frames"));
  const std::set<std::string> own = {"frame_00001.vtk.bak", "frame.vtk",  "my_frame_00001.vtk", "frame_1.vtk",
                                     "frame_00001_cut.vtk", "bodies.csv", "state.lockstep.old"};
  for (const std::string& name : own) write_bytes(path("frames/" + name), "mine");
  ASSERT_EQ(run(of(fluid, "frames", 5)).code, 0);
  write_bytes(path("frames/frame_00006.vtk.tmp~"), "half");

  expect_refused(of(fluid, "frames", 5), "frames: holds the frames of fluid ");
  expect_refused(of(cloth, "frames", 5), "--force replaces them, --resume goes on");
  expect_refused(of(cloth, "frames", 5, {"--force", "--resume"}), "--force");
  for (const std::string& other : {cloth, rigid}) EXPECT_EQ(run(of(other, "frames", 2, {"--force"})).code, 0);
  std::set<std::string> expected = alone;
  expected.insert(own.begin(), own.end());
  EXPECT_EQ(names_in("frames"), expected);
  for (const std::string& name : own) EXPECT_EQ(read_bytes(path("frames/" + name)), "mine") << name;
  EXPECT_EQ(series("frames/bodies.vtk.series")["files"].size(), 3u);
}

// Frames of a run without a state, such as those of a level set.
TEST_F(Frames, WithoutAStateAreNotMixedEither) {
  const std::vector<std::string> slab = of("scenes/levelset/slab_33.toml", "level", 1);
  ASSERT_EQ(run(slab).code, 0);
  EXPECT_EQ(names_in("level"), (std::set<std::string>{"frame_00000.vtk", "frame_00001.vtk"}));
  expect_refused(slab, "holds the frames of another run; --force replaces them");
  std::vector<std::string> forced = slab;
  forced.push_back("--force");
  EXPECT_EQ(run(forced).code, 0);
}

TEST_F(Frames, HaveOneRunAtATime) {
  const std::string fluid = scene(good_scene, "fluid.toml");
  const pid_t first = start(of(fluid, "frames", 1000000));
  wait_for("frames/frame_00003.vtk");
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--force"}, {"--resume"}}) {
    const Outcome second = run(of(fluid, "frames", 5, more));
    EXPECT_EQ(second.code, 2);
    EXPECT_EQ(second.error_lines(), 1) << second.err;
    EXPECT_NE(second.err.find("frames: another run is writing"), std::string::npos) << second.err;
  }
  EXPECT_EQ(kill(first, 0), 0) << "the first run goes on";
  kill(first, SIGKILL);
  EXPECT_EQ(end_of(first).code, killed + SIGKILL);
  EXPECT_EQ(run(of(fluid, "frames", 1, {"--resume"})).code, 0) << "the lock dies with its run";
}

// A run that was cut off between a frame and its state, or whose state is of an earlier frame.
TEST_F(Frames, AfterTheStateAreForgotten) {
  const std::string rigid = scene(two_balls, "rigid.toml");
  ASSERT_EQ(run(of(rigid, "frames", 4)).code, 0);
  const std::string state = read_bytes(path("frames/state.lockstep"));
  ASSERT_EQ(run(of(rigid, "frames", 9, {"--resume"})).code, 0);
  write_bytes(path("frames/state.lockstep"), state);
  ASSERT_EQ(run(of(rigid, "frames", 6, {"--resume"})).code, 0);
  ASSERT_EQ(run(of(rigid, "whole", 6)).code, 0);
  EXPECT_EQ(names_in("frames"), names_in("whole"));
  for (const std::string& name : names_in("whole"))
    EXPECT_TRUE(read_bytes(path("frames/" + name)) == read_bytes(path("whole/" + name))) << name;
}

TEST_F(Frames, HaveTheirTimes) {
  const std::string substeps = "substeps = 3\ntime_step = 0.02\n" + good_cloth;
  for (const auto& [text, step] : {std::pair{two_balls, .01}, {substeps, .02}, {good_scene, .001}}) {
    ASSERT_EQ(run(of(scene(text), "frames", 3, {"--force"})).code, 0);
    const nlohmann::json frames = series("frames/frame.vtk.series");
    EXPECT_EQ(frames["file-series-version"], "1.0");
    ASSERT_EQ(frames["files"].size(), 4u);
    for (int k = 0; k < 4; ++k) {
      EXPECT_EQ(frames["files"][k]["name"], "frame_0000" + std::to_string(k) + ".vtk");
      EXPECT_DOUBLE_EQ(frames["files"][k]["time"], k * step);
    }
  }
}

// At any moment, the series names whole files only.
TEST_F(Frames, HaveASeriesThatIsTrueWhenTheRunIsKilled) {
  const pid_t child = start(of(scene(good_cloth), "frames", 1000000));
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  wait_for("frames/frame.vtk.series");
  while (series("frames/frame.vtk.series")["files"].size() < 2 && std::chrono::steady_clock::now() < give_up)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  kill(child, SIGKILL);
  end_of(child);
  const nlohmann::json files = series("frames/frame.vtk.series")["files"];
  EXPECT_GT(files.size(), 1u);
  for (const auto& file : files) EXPECT_TRUE(names_in("frames").contains(file["name"])) << file;
}

}  // namespace
}  // namespace lockstep
