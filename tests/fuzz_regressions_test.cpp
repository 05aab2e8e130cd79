// The fuzzer's inputs as a test: every input of tests/fuzz/corpus and tests/fuzz/found is read and valid, or refused in
// one line (tests/fuzz/loaders.h). Also inputs that are too long for the fuzzer to find. Run from the root of the
// repository.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <limits>
#include <string>

#include "common/cloth/scene.h"
#include "common/rigid/scene.h"
#include "common/toml.h"
#include "tests/fuzz/loaders.h"
#include "tests/temporary_folder.h"

namespace lockstep {
namespace {

struct MemoryLimit {
  explicit MemoryLimit(double bytes) { limit_memory(bytes); }
  ~MemoryLimit() { limit_memory(std::numeric_limits<double>::infinity()); }
};

struct FuzzRegressions : TemporaryFolder {
  const MemoryLimit limit{fuzz::memory};

  FuzzRegressions() { fuzz::write_neighbours(folder); }

  int try_all(const std::string& inputs) const {
    int tried = 0;
    for (const fuzz::Loader& loader : fuzz::loaders()) {
      const std::string kind = inputs + '/' + std::string(loader.name);
      if (!std::filesystem::exists(kind)) continue;
      for (const auto& input : std::filesystem::directory_iterator(kind)) {
        EXPECT_NO_THROW(fuzz::try_bytes(loader, folder, read_bytes(input.path()))) << input.path();
        ++tried;
      }
    }
    return tried;
  }
};

TEST_F(FuzzRegressions, Corpus) { EXPECT_GT(try_all("tests/fuzz/corpus"), 0); }
TEST_F(FuzzRegressions, Found) { EXPECT_GT(try_all("tests/fuzz/found"), 0); }

// --- The message of each finding, now that it is refused

struct FuzzFindings : TemporaryFolder {
  // The message without the folder.
  std::string toml_error(const std::string& toml) const {
    write_bytes(path("a.toml"), toml);
    return error_of([&] { parse_toml(path("a.toml")); }).substr(folder.size() + 1);
  }
  Mesh read(const std::string& obj) const {
    write_bytes(path("a.obj"), obj);
    return read_obj(path("a.obj"));
  }
  std::string obj_error(const std::string& obj) const {
    return error_of([&] { read(obj); }).substr(folder.size() + 1);
  }
  std::string rigid_error(const std::string& bodies) const {
    write_bytes(path("a.toml"), "kind = \"rigid\"\nframes = 1\n" + bodies);
    return error_of([&] { rigid::load_scene(path("a.toml")); }).substr(folder.size() + 1);
  }
};

TEST_F(FuzzFindings, KeysThatTomlAsserts) {
  EXPECT_EQ(toml_error("a = 1\n[$b]\n"),
            "a.toml:2:2: Error while parsing key: expected bare key starting character or string delimiter, saw '$'");
}

TEST_F(FuzzFindings, LettersBeyondAscii) {
  EXPECT_EQ(toml_error("a = 1  # \xc3\xa4\nb = \xc3\xa4\n"),
            "a.toml:2:5: expected ASCII, which all but comments must be in");
  EXPECT_EQ(toml_error("a = \"# \xc3\xa4\"\n"), "a.toml:1:8: expected ASCII, which all but comments must be in");
  EXPECT_EQ(toml_error("a = \"\"\"\n\"\"\"\"\" # \xc3\xa4\nb = '\\' # \xc3\xa4\nc = \"\\\"# \xc3\xa4\"\n"),
            "a.toml:4:10: expected ASCII, which all but comments must be in");
  EXPECT_EQ(toml_error("a = 1\n\xff"), "a.toml:2:1: expected ASCII, which all but comments must be in");
  write_bytes(path("a.toml"),
              "\xef\xbb\xbf"
              "a = \"b\"  # \xe2\x80\xa6 \xff\n");
  EXPECT_EQ(parse_toml(path("a.toml"))["a"].value<std::string>(), "b");
}

// Each part of a key is a table in a table; their destructors call each other, one level a part.
TEST_F(FuzzFindings, KeysOfManyParts) {
  std::string dots;
  for (int i = 0; i < 1'000'000; ++i) dots += "a.";
  EXPECT_EQ(toml_error("b = 1\n[" + dots + "a]\n"), "a.toml:2:33: a key of more than 16 parts");
  EXPECT_EQ(toml_error(dots + "a = 1\n"), "a.toml:1:32: a key of more than 16 parts");
  EXPECT_EQ(toml_error("b = [\"\"\"c\"\"\"\"\", {" + dots + "a = 1}]\n"), "a.toml:1:49: a key of more than 16 parts");
  std::string numbers;
  for (int i = 0; i < 100; ++i) numbers += "1.5, ";
  write_bytes(path("a.toml"), "a = [" + numbers + "1.5]\n");
  EXPECT_EQ(parse_toml(path("a.toml"))["a"].as_array()->size(), 101u);
}

TEST_F(FuzzFindings, ControlCharactersInMessages) {
  write_bytes(path("a.toml"), "\"a\\u001b[2J\\n\" = 1\nb = \"\\u001b\"\n");
  const toml::table table = parse_toml(path("a.toml"));
  EXPECT_EQ(error_of([&] { check_keys(table, {}, {"b"}); }),
            path("a.toml") + ":1:1: unknown key a?[2J?, expected one of: b");
  EXPECT_EQ(error_of([&] { text(table, "b"); }),
            path("a.toml") + ":2:5: b: expected at most 255 characters, none of them a control character");
  EXPECT_EQ(obj_error("v 0 0 0\nf 1 \x1b[2J\n"),
            "a.obj:2: f: ?[2J is no point, expected a number from 1, or from -1 downwards, back from the last");
}

TEST_F(FuzzFindings, NumbersThatTheObjLibraryTakesForOthers) {
  EXPECT_EQ(obj_error("v 0 0 +-1\n"), "a.obj:1: v: expected three numbers from -1e9 to 1e9, in m");
  const std::string long_one = '1' + std::string(400, '0') + "e-400";
  const Mesh mesh = read("v 0.123456789012345678 0 " + long_one + "\nv 1e-310 1 0\nv 1 0 0\nf 1 2 3\n");
  EXPECT_EQ(mesh.points[0].x, 0.123456789012345678);
  EXPECT_EQ(mesh.points[0].z, 1);
  EXPECT_EQ(mesh.points[1].x, 1e-310);
}

TEST_F(FuzzFindings, PolygonsThatCannotBeCut) {
  EXPECT_EQ(obj_error("v 0 2 0\nv 2 1 0\nv 0 3 0\nv 3 1 0\nv 0 1 0\nf 1 2 3 4 5\n"),
            "a.obj:6: f: cannot be cut into triangles, expected a flat polygon without loops");
  std::string many;
  for (int i = 0; i < 256; ++i) many += "v " + std::to_string(i) + " 0 0\n";
  many += 'f';
  for (int i = 0; i < 256; ++i) many += ' ' + std::to_string(i + 1);
  EXPECT_EQ(obj_error(many), "a.obj:257: f: more than 255 points");
}

TEST_F(FuzzFindings, PinsThatComeTwice) {
  write_bytes(
      path("a.toml"),
      "kind = \"cloth\"\n[sheet]\nrows = 3\ncolumns = 3\norigin = [0, 0, 0]\nwidth = [1, 0, 0]\nheight = [0, 1, 0]\n"
      "mass = 1\npins = [\"left\", [0, 0], [0, 0], \"left\"]\n");
  EXPECT_EQ(error_of([&] { cloth::load_scene(path("a.toml")); }),
            path("a.toml") + ":9:33: pins: expected \"left\" once");
}

// The memory check counts the bodies of all generators together.
TEST_F(FuzzFindings, MemoryOfAllBodiesTogether) {
  const MemoryLimit limit(8e6);
  const std::string dominoes = "[[dominoes]]\ncount = 4000\n", pit = "[[pit]]\nof = \"hulls\"\ncount = 1\n";
  const std::string bodies = rigid_error(dominoes + dominoes), hulls = rigid_error(pit + pit + pit + pit + pit);
  EXPECT_EQ(bodies.rfind("a.toml:5:1: 4000 bodies, after 4000 bodies, needs ", 0), 0u) << bodies;
  EXPECT_NE(hulls.find(": 6 bodies, after "), std::string::npos) << hulls;
}

}  // namespace
}  // namespace lockstep
