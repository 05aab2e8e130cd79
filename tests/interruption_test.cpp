// Interrupted runs: however a run ends, it leaves whole frames, and --resume continues with the same bits as an
// uninterrupted run.
#include <gtest/gtest.h>
#include <sched.h>
#include <signal.h>
#include <sys/mount.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "tests/cli.h"
#include "verify/run_state.h"

namespace lockstep {
namespace {

const std::string a_ball_falls_on_boxes =
    "kind = \"rigid\"\nframes = 3\n[[body]]\nplane = [0, 1, 0]\n"
    "[[body]]\nbox = [0.5, 0.5, 0.5]\nposition = [0, 0.5, 0]\nmass = 1\n"
    "[[body]]\nbox = [0.5, 0.5, 0.5]\nposition = [0.3, 1.5, 0.1]\nmass = 1\n"
    "[[body]]\nsphere = 0.3\nposition = [0.4, 2.4, 0.2]\nvelocity = [0, -2, 0]\nmass = 1\n";

struct Interruption : Cli {
  // The files of a folder of frames, by name. A file whose writing was interrupted ends in ~ and is left out.
  static std::map<std::string, std::string> files_of(const std::string& folder) {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.path().extension() != ".tmp~") files[entry.path().filename()] = read_bytes(entry.path());
    return files;
  }

  // The number of the last frame in a folder, in which all of its frames must be.
  static int last_frame(const std::map<std::string, std::string>& files) {
    const long frames = std::ranges::count_if(files, [](const auto& file) { return file.first.starts_with("frame_"); });
    char name[32];
    std::snprintf(name, sizeof name, "frame_%05ld.vtk", frames - 1);
    EXPECT_TRUE(files.contains(name)) << name;
    return static_cast<int>(frames) - 1;
  }

  std::vector<std::string> of(const std::string& scene, const std::string& out, int frames, int threads,
                              bool resume = false) const {
    // clang-format off
    std::vector<std::string> arguments = {"run", "--scene", scene, "--out", path(out),
                                          "--frames", std::to_string(frames), "--threads", std::to_string(threads)};
    // clang-format on
    if (resume) arguments.push_back("--resume");
    return arguments;
  }

  std::vector<std::string> scenes() const {
    write_bytes(path("cloth.obj"), good_obj);
    return {scene(good_scene, "fluid.toml"), scene(good_cloth, "sheet.toml"), scene(good_mesh, "mesh.toml"),
            scene(a_ball_falls_on_boxes, "rigid.toml")};
  }
};

TEST_F(Interruption, GoesOnBitForBit) {
  for (const std::string& scene : scenes()) {
    SCOPED_TRACE(scene);
    const std::string name = std::filesystem::path(scene).stem(), whole = name + "_whole", parts = name + "_parts";
    ASSERT_EQ(run(of(scene, whole, 60, 1)).code, 0);
    ASSERT_EQ(run(of(scene, parts, 20, 2)).code, 0);
    for (const int frames : {41, 60}) {
      const Outcome outcome = run(of(scene, parts, frames, 3, true));
      EXPECT_EQ(outcome.code, 0) << outcome.err;
    }
    EXPECT_TRUE(files_of(path(whole)) == files_of(path(parts)));
    EXPECT_EQ(last_frame(files_of(path(parts))), 60);
    EXPECT_NE(files_of(path(parts))["frame_00059.vtk"], files_of(path(parts))["frame_00060.vtk"]);
  }
}

// Resuming a finished run changes nothing.
TEST_F(Interruption, HasNothingToGoOnWith) {
  const std::string fluid = scene(good_scene);
  ASSERT_EQ(run(of(fluid, "frames", 3, 1)).code, 0);
  const auto before = files_of(path("frames"));
  const Outcome outcome = run(of(fluid, "frames", 3, 1, true));
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(files_of(path("frames")) == before);
}

TEST_F(Interruption, StopsAfterAWholeFrame) {
  const std::string fluid = scene(good_scene);
  for (const int signal : {SIGINT, SIGTERM}) {
    const std::string out = "stopped_by_" + std::to_string(signal);
    const pid_t child = start(of(fluid, out, 1000000, 1));
    wait_for(out + "/frame_00003.vtk");
    kill(child, signal);
    const Outcome outcome = end_of(child);
    EXPECT_EQ(outcome.code, 128 + signal);
    EXPECT_EQ(outcome.error_lines(), 1) << outcome.err;
    const int last = last_frame(files_of(path(out)));
    EXPECT_NE(outcome.err.find("stopped after frame " + std::to_string(last) + " of 1000000; --resume"),
              std::string::npos)
        << outcome.err;

    ASSERT_EQ(run(of(fluid, out, last + 2, 1, true)).code, 0);
    ASSERT_EQ(run(of(fluid, out + "_whole", last + 2, 1)).code, 0);
    EXPECT_TRUE(files_of(path(out)) == files_of(path(out + "_whole")));
  }
}

// The run is killed without warning, again and again, at random moments.
TEST_F(Interruption, LeavesWholeFramesHoweverItEnds) {
  const std::string cloth = scene(good_cloth);
  constexpr int frames = 400;
  const pid_t first = start(of(cloth, "killed", frames, 1));
  wait_for("killed/state.lockstep");
  kill(first, SIGKILL);
  end_of(first);
  int code = killed, kills = 1;
  for (; code >= killed; ++kills) {
    const pid_t child = start(of(cloth, "killed", frames, 1, true));
    std::this_thread::sleep_for(std::chrono::microseconds(2000 + 700 * kills));
    kill(child, SIGKILL);
    code = end_of(child).code;
  }
  EXPECT_EQ(code, 0);
  EXPECT_GT(kills, 3);
  ASSERT_EQ(run(of(cloth, "whole", frames, 1)).code, 0);
  EXPECT_TRUE(files_of(path("killed")) == files_of(path("whole")));
}

TEST_F(Interruption, GoesOnWithNoOtherRun) {
  const std::string fluid = scene(good_scene, "fluid.toml");
  ASSERT_EQ(run(of(fluid, "frames", 3, 1)).code, 0);
  expect_refused(of(fluid, "none", 5, 1, true), "none: cannot be opened");
  expect_refused(of(scene(good_scene + " ", "other.toml"), "frames", 5, 1, true), "of another run");
  for (const char* form : {"owner_gather", "sub_grid"}) {
    std::vector<std::string> arguments = of(fluid, "frames", 5, 1, true);
    arguments.insert(arguments.end(), {"--form", form});
    expect_refused(arguments, "of another run");
  }
  expect_refused({"run", "--scene", fluid, "--out", path("out.fluid"), "--resume"}, "--resume");
  expect_refused({"run", "--scene", "scenes/levelset/slab_33.toml", "--out", path("level"), "--resume"}, "--resume");

  const std::string state = path("frames/state.lockstep"), good = read_bytes(state),
                    run_of_it = verify::run_of_state(state);
  for (const std::size_t size :
       {std::size_t(0), std::size_t(10), std::size_t(17), std::size_t(20), good.size() / 2, good.size() - 1}) {
    write_bytes(state, good.substr(0, size));
    expect_refused(of(fluid, "frames", 5, 1, true), "state.lockstep");
  }
  for (std::size_t k = 17; k < good.size(); k += good.size() / 20) {
    std::string flipped = good;
    flipped[k] = static_cast<char>(flipped[k] ^ 4);
    write_bytes(state, flipped);
    expect_refused(of(fluid, "frames", 5, 1, true), "damaged");
  }
  // As by a version of other arrays.
  std::vector<char> one(8);
  verify::write_state(state, run_of_it, 3, {verify::keep(one)});
  expect_refused(of(fluid, "frames", 5, 1, true), "of a version of lockstep that kept other arrays");
}

// The child gets its own file system of 64 KB.
TEST_F(Interruption, SaysThatTheDiskIsFull) {
  const std::string fluid = scene(good_scene), small = path("small");
  std::filesystem::create_directory(small);
  const std::vector<std::string> arguments = {"run",      "--scene", fluid,       "--out", small + "/frames",
                                              "--frames", "1000",    "--threads", "1"};
  const Outcome outcome = end_of(start(arguments, [&] {
    if (unshare(CLONE_NEWNS) != 0 || mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        mount("tmpfs", small.c_str(), "tmpfs", 0, "size=64k") != 0)
      _exit(not_started);
  }));
  if (outcome.code == not_started) GTEST_SKIP() << "may not mount a file system";
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(outcome.error_lines(), 1) << outcome.err;
  EXPECT_NE(outcome.err.find("No space left on device"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace lockstep
