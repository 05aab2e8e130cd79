// Bad input and bad usage on the command line: exit code 2, one line that says what is wrong, and no file left behind.
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "common/fluid/limits.h"
#include "common/memory.h"
#include "tests/cli.h"

namespace lockstep {
namespace {

constexpr int usage_lines = 2;  // CLI11 prints the error, then a hint at --help

template <class T>
void append(std::string& bytes, T x) {
  bytes.append(reinterpret_cast<const char*>(&x), sizeof x);
}

std::string fluid_bytes(float particles_per_metre, std::int32_t n, const std::vector<float>& numbers) {
  std::string bytes;
  append(bytes, particles_per_metre);
  append(bytes, n);
  for (float x : numbers) append(bytes, x);
  return bytes;
}

// --- Files, scenes and usage

TEST_F(Cli, RefusesBadFluidFiles) {
  const std::vector<float> record = {.01f, .02f, .03f, 0, 0, 0, 0, 0, 0};
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<float> with_nan = record;
  with_nan[4] = nan;
  const std::string file = path("bad.fluid");
  const auto expect = [&](const std::string& bytes, const std::string& about) {
    write_bytes(file, bytes);
    expect_run_refused(file, about);
  };
  const std::string good = fluid_bytes(204, 1, record);
  expect("", "expected at least a header");
  expect(good.substr(0, 7), "expected at least a header");
  expect(good.substr(0, good.size() - 1), "expected 44 bytes");
  expect(good + "x", "expected 44 bytes");
  expect(fluid_bytes(204, -1, {}), "number of particles is -1");
  expect(fluid_bytes(204, std::numeric_limits<std::int32_t>::max(), record), "2147483647 particles");
  expect(fluid_bytes(204, 1, with_nan), "half_velocity.y is nan");
  for (const float particles_per_metre : {0.f, -204.f, nan, std::numeric_limits<float>::infinity()})
    expect(fluid_bytes(particles_per_metre, 1, record), "particles per metre is ");
}

// Sparse files of the size that the header announces: more particles than memory holds, and more than the limit.
TEST_F(Cli, RefusesWhatDoesNotFitMemory) {
  const double bytes_per_particle = fluid::simulation_bytes<float>(1, 0) - fluid::simulation_bytes<float>(0, 0);
  const double too_many = available_memory() / bytes_per_particle * 1.5 + 1e6;
  const std::string file = path("big.fluid");
  const auto make = [&](std::int32_t n) {
    write_bytes(file, fluid_bytes(204, n, {}));
    std::filesystem::resize_file(file, 8 + 36 * static_cast<std::uintmax_t>(n));
  };
  make(std::numeric_limits<std::int32_t>::max());
  expect_run_refused(file, "2147483647 particles, expected at most");
  if (too_many > fluid::max_particles) GTEST_SKIP() << "as many particles as are allowed fit this machine";
  make(static_cast<std::int32_t>(too_many));
  expect_run_refused(file, "of memory");
}

TEST_F(Cli, RefusesWhatIsNoFile) {
  expect_run_refused(folder, "is a directory");
  expect_run_refused(path("none.toml"), "No such file");
  expect_run_refused(path("none.fluid"), "No such file");
  expect_run_refused("/dev/null", "not a regular file");
  for (const char* command : {"verify", "bench"})
    expect_refused({command, "--kernel", "fluid/advance", "--threads", "1", "--scene", path("none.toml"), "--json",
                    path("a.json")},
                   "none.toml");
}

TEST_F(Cli, RefusesWhatItMayNotRead) {
  for (const char* name : {"a.toml", "a.fluid"}) {
    scene(good_scene, name);
    std::filesystem::permissions(path(name), std::filesystem::perms::none);
    expect_refused({"run", "--scene", path(name), "--out", path("out.fluid")}, "Permission denied", 1, true);
  }
}

TEST_F(Cli, RefusesBadScenes) {
  const auto expect = [&](const std::string& text, const std::string& about) {
    expect_run_refused(scene(text), "scene.toml:" + about);
  };
  expect("frmes = 3\n" + good_scene, "1:1: unknown key frmes");
  expect(good_scene + "spacng = 1\n", "9:1: unknown key spacng");
  expect("kind = \"fluid\"\nparticles_per_metre = \"many\"\n", "");
  expect("kind = \"fluid\"\nparticles_per_metre = nan\n", "");
  expect("kind = ", "1:");
}

TEST_F(Cli, RefusesBadUsage) {
  const std::string good = scene(good_scene), out = path("out.fluid");
  expect_refused({}, "subcommand", usage_lines);
  expect_refused({"simulate"}, "", usage_lines);
  expect_refused({"run"}, "--", usage_lines);
  expect_refused({"run", "--scene", good}, "--out", usage_lines);
  expect_refused({"run", "--out", out}, "--scene", usage_lines);
  expect_refused({"run", "--scene", good, "--out", out, "--colour"}, "--colour", usage_lines);
  expect_refused({"run", "--scene", good, "--out", out, "--variant", "cuda"}, "--variant", usage_lines);
  for (const char* threads : {"0", "-1", "two", "1.5", "1000000", "99999999999"}) {
    expect_refused({"run", "--scene", good, "--out", out, "--threads", threads}, "--threads", usage_lines);
    expect_refused({"verify", "--threads", threads}, "--threads", usage_lines);
    expect_refused({"bench", "--threads", std::string("1,") + threads}, "--threads", usage_lines);
  }
  for (const char* frames : {"0", "-1", "many"})
    expect_refused({"run", "--scene", good, "--out", out, "--frames", frames}, "--frames", usage_lines);
}

TEST_F(Cli, RefusesUnknownKernelsAndForms) {
  for (const char* command : {"verify", "bench"}) {
    expect_refused({command, "--kernel", "fluid/advanse", "--threads", "1"}, "fluid/advance");
    expect_refused({command, "--kernel", "fluid/forces", "--form", "owner", "--threads", "1"}, "owner_gather");
  }
  for (const char* variant : {"serial", "openmp"})
    expect_refused(
        {"run", "--scene", scene(good_scene), "--out", path("out.fluid"), "--variant", variant, "--form", "owner"},
        "owner_gather");
}

TEST_F(Cli, RefusesToWriteWhereItCannot) {
  const std::string good = scene(good_scene);
  write_bytes(path("file"), "as it was");
  for (const std::string& out :
       {path("none/out.fluid"), path("file/out.fluid"), path("file"), path("file/frames"), std::string("/dev/null/x")})
    expect_refused({"run", "--scene", good, "--out", out}, out);
  expect_refused(
      {"verify", "--kernel", "fluid/advance", "--scene", "single", "--threads", "1", "--json", path("none/a.json")},
      "none/a.json");
  EXPECT_EQ(read_bytes(path("file")), "as it was");

  std::filesystem::permissions(folder, std::filesystem::perms(0555));
  for (const char* out : {"out.fluid", "frames"})
    expect_refused({"run", "--scene", good, "--out", path(out)}, out, 1, true);
  std::filesystem::permissions(folder, std::filesystem::perms(0755));
}

// --- Cloth, and scenes of another kind

TEST_F(Cli, RefusesAFluidFileOfACloth) {
  write_bytes(path("cloth.obj"), good_obj);
  for (const std::string& good : {scene(good_cloth, "sheet.toml"), scene(good_mesh, "mesh.toml")})
    for (const char* variant : {"serial", "openmp"})
      expect_refused({"run", "--scene", good, "--variant", variant, "--out", path("x.fluid")},
                     "--out " + path("x.fluid"));
}

TEST_F(Cli, RefusesFormsThatAClothCannotHave) {
  write_bytes(path("cloth.obj"), good_obj);
  const std::string sheet = scene(good_cloth, "sheet.toml"), mesh = scene(good_mesh, "mesh.toml"), out = path("frames");
  const auto run_in = [&](const std::string& scene, const char* variant, const char* form, const std::string& about) {
    expect_refused({"run", "--scene", scene, "--variant", variant, "--form", form, "--out", out}, about);
  };
  for (const char* form : {"chains", "colours"}) {
    run_in(mesh, "openmp", form, "--form " + std::string(form) + ": expected one of: batches\n");
    run_in(mesh, "serial", form, "expected one of: batches, original\n");
    for (const char* command : {"verify", "bench"})
      for (const char* kernel : {"cloth/relax", "cloth/step"})
        expect_refused({command, "--kernel", kernel, "--form", form, "--threads", "1", "--scene", mesh}, "mesh.toml");
  }
  run_in(sheet, "openmp", "original", "expected one of: chains, colours, batches\n");
  for (const char* variant : {"serial", "openmp"}) run_in(sheet, variant, "chain", "chains, colours, batches");
  expect_refused({"verify", "--kernel", "cloth/relax", "--form", "chain", "--threads", "1"},
                 "no form chain of cloth/relax, expected one of: chains, ");
}

TEST_F(Cli, RefusesScenesOfAnotherKind) {
  const std::string sheet = scene(good_cloth, "sheet.toml"), fluid = scene(good_scene, "fluid.toml");
  for (const char* command : {"verify", "bench"}) {
    for (const std::string& cloth :
         {sheet, std::string("scenes/cloth/tiny.toml"), std::string("scenes/cloth/garment.toml")})
      expect_refused(
          {command, "--kernel", "fluid/forces", "--threads", "1", "--scene", cloth, "--json", path("a.json")}, cloth);
    for (const char* kernel : {"cloth/verlet", "cloth/relax", "cloth/step"})
      expect_refused({command, "--kernel", kernel, "--threads", "1", "--scene", fluid, "--json", path("a.json")},
                     fluid);
    // The name of a scene that this kernel does not register.
    expect_refused({command, "--kernel", "fluid/forces", "--threads", "1", "--scene", "flag_33"}, "flag_33");
  }
}

TEST_F(Cli, RefusesScenesOfNoKind) {
  for (const auto& [text, about] : {std::pair{"kind = \"sand\"\n", ":1:8: kind: "},
                                    {"kind = 1\n", ":1:8: kind: "},
                                    {"frames = 1\n", ":1:1: kind is missing"}}) {
    const std::string of_no_kind = scene(text);
    expect_run_refused(of_no_kind, of_no_kind + about);
    for (const char* command : {"verify", "bench"})
      for (const char* kernel : {"fluid/advance", "cloth/verlet"})
        expect_refused({command, "--kernel", kernel, "--threads", "1", "--scene", of_no_kind}, of_no_kind + about);
  }
}

TEST_F(Cli, RefusesBadMeshes) {
  const std::string mesh = scene(good_mesh), obj = path("cloth.obj");
  const auto expect = [&](const std::string& about) {
    expect_run_refused(mesh, obj + about);
    expect_refused({"verify", "--kernel", "cloth/verlet", "--threads", "1", "--scene", mesh, "--json", path("a.json")},
                   obj + about);
  };
  const auto expect_of = [&](const std::string& bytes, const std::string& about) {
    write_bytes(obj, bytes);
    expect(about);
  };
  expect(": cannot be read: No such file");
  std::filesystem::create_directory(obj);
  expect(": is a directory");
  std::filesystem::remove(obj);
  expect_of("", ": no triangle");
  expect_of(good_obj.substr(0, good_obj.find('f')), ": no triangle");
  expect_of(good_obj.substr(0, good_obj.rfind('f')), ": point 4 is in no triangle");
  expect_of(good_obj.substr(0, good_obj.size() - 3), ":6: f: ");
  expect_of("v nan 0 0\n" + good_obj, ":1: v: ");
  expect_of("v 0 inf 0\n" + good_obj, ":1: v: ");
  expect_of(good_obj + "f 1 2 5\n", ":7: f: point 5 of 4");

  write_bytes(obj, good_obj);
  std::filesystem::permissions(obj, std::filesystem::perms::none);
  expect_refused({"run", "--scene", mesh, "--out", path("frames")}, obj + ": cannot be read: Permission denied", 1,
                 true);
}

}  // namespace
}  // namespace lockstep
