// `lockstep run` from the command line: every form, the files that it writes, and --help.
#include <gtest/gtest.h>

#include <filesystem>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "common/fluid/file.h"
#include "tests/cli.h"

namespace lockstep {
namespace {

TEST_F(Cli, Helps) {
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"--help"}, {"run", "--help"}, {"verify", "--help"}, {"bench", "--help"}}) {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.code, 0);
    EXPECT_NE(outcome.out.find("--help"), std::string::npos);
    EXPECT_EQ(outcome.err, "");
  }
}

TEST_F(Cli, RunsAFluidFileInEveryForm) {
  // One step of the scene gives a .fluid file to start from.
  ASSERT_EQ(run({"run", "--scene", scene(good_scene), "--frames", "1", "--out", path("start.fluid")}).code, 0);
  const fluid::FluidFile start = fluid::read_fluid(path("start.fluid"));
  ASSERT_GT(start.particles.count, 100);

  const auto result = [&](const std::string& variant, const std::string& form) {
    const std::string out = path(variant + form + ".fluid");
    const Outcome outcome = run({"run", "--scene", path("start.fluid"), "--variant", variant, "--form", form,
                                 "--threads", "2", "--frames", "5", "--out", out});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    return fluid::read_fluid(out);
  };
  const fluid::FluidFile serial = result("serial", "symmetric");
  EXPECT_EQ(serial.particles_per_metre, start.particles_per_metre);
  for (const auto& [variant, form] : {std::pair{"serial", "owner_gather"},
                                      {"openmp", "owner_gather"},
                                      {"openmp", "sub_grid"},
                                      {"openmp", "cell_locks"}}) {
    SCOPED_TRACE(std::string(variant) + ' ' + form);
    const fluid::FluidFile other = result(variant, form);
    ASSERT_EQ(other.particles.count, start.particles.count);
    // Files hold the particles in the order of their ids, so elements with the same index correspond.
    for (int i = 0; i < start.particles.count; ++i) {
      ASSERT_NEAR(other.particles.position.x[i], serial.particles.position.x[i], 1e-6);
      ASSERT_NEAR(other.particles.position.y[i], serial.particles.position.y[i], 1e-6);
      ASSERT_NEAR(other.particles.velocity.z[i], serial.particles.velocity.z[i], 1e-3);
    }
  }
  EXPECT_NE(serial.particles.position.x, start.particles.position.x);
}

TEST_F(Cli, WritesFramesForParaView) {
  const Outcome outcome =
      run({"run", "--scene", scene(good_scene), "--frames", "2", "--threads", "2", "--out", path("deep/frames")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  std::set<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(path("deep/frames"))) {
    names.insert(entry.path().filename());
    if (!entry.path().filename().string().starts_with("frame_")) continue;
    const std::string frame = read_bytes(entry.path());
    EXPECT_EQ(frame.rfind("# vtk DataFile Version 3.0\n", 0), 0u);
    for (const char* part : {"\nPOINTS ", "\nVECTORS velocity ", "\nSCALARS density "})
      EXPECT_NE(frame.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(names, (std::set<std::string>{"frame_00000.vtk", "frame_00001.vtk", "frame_00002.vtk", "frame.vtk.series",
                                          "box.vtk", "state.lockstep"}));
}

// Frames of a cloth have the same bits in serial and openmp.
// tests/view_test.py makes the page itself.
TEST_F(Cli, RefusesToGoOnWithAPage) {
  const Outcome outcome = run({"run", "--scene", scene(good_scene), "--out", path("x.html"), "--resume"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("only what writes frames to a folder can go on"), std::string::npos) << outcome.err;
}

TEST_F(Cli, WritesFramesOfAClothInEveryForm) {
  write_bytes(path("cloth.obj"), good_obj);
  const auto frames = [&](const std::string& scene, const std::string& variant, const std::string& form,
                          const std::string& polygons) {
    SCOPED_TRACE(variant + ' ' + form);
    const std::string out = path(scene.substr(folder.size() + 1) + variant + form);
    const Outcome outcome = run({"run", "--scene", scene, "--variant", variant, "--form", form, "--threads", "2",
                                 "--frames", "2", "--out", out});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    EXPECT_NE(outcome.out.find(variant + ' ' + form), std::string::npos) << outcome.out;
    std::vector<std::string> frames;
    for (const char* name : {"/frame_00000.vtk", "/frame_00001.vtk", "/frame_00002.vtk"}) {
      frames.push_back(read_bytes(out + name));
      EXPECT_EQ(frames.back().rfind("# vtk DataFile Version 3.0\nLockstep cloth\n", 0), 0u) << name;
      for (const std::string& part :
           {std::string("\nPOINTS "), "\nPOLYGONS " + polygons + '\n', std::string("\nVECTORS velocity ")})
        EXPECT_NE(frames.back().find(part), std::string::npos) << name << part;
    }
    EXPECT_FALSE(std::filesystem::exists(out + "/frame_00003.vtk"));
    EXPECT_NE(frames[0], frames[1]);
    EXPECT_NE(frames[1], frames[2]);
    return frames;
  };
  const std::string sheet = scene(good_cloth, "sheet.toml"), mesh = scene(good_mesh, "mesh.toml");
  frames(sheet, "serial", "original", "48 192");
  for (const char* form : {"chains", "colours", "batches"}) {
    const auto serial = frames(sheet, "serial", form, "48 192"), openmp = frames(sheet, "openmp", form, "48 192");
    EXPECT_TRUE(serial == openmp) << form;
  }
  frames(mesh, "serial", "original", "2 8");
  const auto serial = frames(mesh, "serial", "batches", "2 8"), openmp = frames(mesh, "openmp", "batches", "2 8");
  EXPECT_TRUE(serial == openmp);
}

// The defaults: openmp, chains for a sheet, batches for a mesh.
TEST_F(Cli, RunsAClothInItsFirstForm) {
  write_bytes(path("cloth.obj"), good_obj);
  for (const auto& [text, particles, form] : {std::tuple{good_cloth, "35", "chains"}, {good_mesh, "4", "batches"}}) {
    const Outcome outcome = run({"run", "--scene", scene(text), "--out", path(form)});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_NE(outcome.out.find(std::string(particles) + " particles, 3 frames, openmp " + form), std::string::npos)
        << outcome.out;
    EXPECT_TRUE(std::filesystem::exists(path(form) + "/frame_00003.vtk"));
  }
}

// The steps of face_6k free blocks into the cache that malloc keeps for each thread. `endure` disables that cache
// whether the environment asks for it or not: otherwise, it takes such blocks for a leak.
TEST_F(Cli, EnduresWithoutCountingBlocksInThreadsCaches) {
  for (const char* given : {"", "glibc.malloc.hugetlb=0"}) {
    const Outcome outcome =
        end_of(start({"endure", "--scene", "face_6k", "--steps", "60"}, [&] { setenv("GLIBC_TUNABLES", given, 1); }));
    EXPECT_EQ(outcome.code, 0) << outcome.out << outcome.err;
    EXPECT_NE(outcome.out.find(" 0  endures\n"), std::string::npos) << outcome.out;
  }
}

}  // namespace
}  // namespace lockstep
