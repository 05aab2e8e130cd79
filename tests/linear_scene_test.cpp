// Scenes of linear algebra and Matrix Market files: those of the repository load, a bad one is refused in one line that
// says where.
#include <filesystem>
#include <map>

#include "common/linear/make.h"
#include "common/linear/matrix_market.h"
#include "common/linear/scene.h"
#include "common/memory.h"
#include "tests/linear_matrices.h"
#include "tests/temporary_folder.h"

namespace lockstep::linear {
namespace {

struct LinearSceneTest : TemporaryFolder {
  Scene load(const std::string& toml) const {
    write_bytes(path("a.toml"), toml);
    return load_scene(path("a.toml"));
  }
  MarketMatrix read(const std::string& bytes) const {
    write_bytes(path("a.mtx"), bytes);
    return read_matrix_market(path("a.mtx"));
  }
  // The message without the folder.
  std::string without_folder(const std::string& message) const {
    EXPECT_EQ(message.rfind(folder, 0), 0u) << message;
    return message.substr(std::min(message.size(), folder.size() + 1));
  }
  std::string error(const std::string& toml) const {
    return without_folder(error_of([&] { load(toml); }));
  }
  std::string market_error(const std::string& bytes) const {
    return without_folder(error_of([&] { read(bytes); }));
  }
};

const std::string general = "%%MatrixMarket matrix coordinate real general\n";
const std::string symmetric = "%%MatrixMarket matrix coordinate real symmetric\n";

// --- Scenes. Run from the root of the repository, as `make test` does.

TEST(LinearScenes, OfTheRepositoryLoad) {
  const std::map<std::string, std::pair<int, bool>> expected{
      {"poisson_32", {32768, true}},    {"poisson_64", {244888, true}},    {"poisson_128", {1959776, true}},
      {"elasticity_24", {41472, true}}, {"elasticity_48", {331776, true}}, {"file_truss", {288, true}},
      {"file_general", {203, false}}};
  std::map<std::string, std::pair<int, bool>> found;
  for (const auto& file : std::filesystem::directory_iterator("scenes/linear")) {
    if (file.path().extension() != ".toml") continue;
    const Scene scene = load_scene(file.path().string());
    found[scene.name] = {scene.rows.rows, scene.solvable};
    EXPECT_EQ(scene.blocks.rows > 0, scene.name.starts_with("elasticity"));
    EXPECT_EQ(scene.b.size(), static_cast<std::size_t>(scene.rows.rows));
  }
  EXPECT_EQ(found, expected);
}

TEST(LinearScenes, FilesAreWhatTheirScriptWrites) {
  if (std::system("python3 -c '' 2>/dev/null") != 0) GTEST_SKIP() << "no python3";
  const std::string copy = testing::TempDir() + "linear_matrices";
  std::filesystem::create_directories(copy);
  std::filesystem::copy_file("scenes/linear/matrices.py", copy + "/matrices.py",
                             std::filesystem::copy_options::overwrite_existing);
  ASSERT_EQ(std::system(("python3 " + copy + "/matrices.py").c_str()), 0);
  for (const char* name : {"truss.mtx", "general.mtx"})
    EXPECT_TRUE(read_bytes(copy + "/" + name) == read_bytes(std::string("scenes/linear/") + name)) << name;
  std::filesystem::remove_all(copy);
}

TEST_F(LinearSceneTest, SaysWhatItSays) {
  const Scene scene =
      load("kind = \"linear\"\ntolerance = 1e-3\niterations = 7\ntau = 0.5\n[poisson]\ncells = 5\nhole = 0.2\n");
  EXPECT_EQ(scene.name, "a");
  EXPECT_EQ(scene.path, path("a.toml"));
  EXPECT_EQ(scene.stop.tolerance, 1e-3);
  EXPECT_EQ(scene.stop.iterations, 7);
  EXPECT_EQ(scene.modification.tau, .5);
  EXPECT_EQ(scene.rows.rows, 124);
  EXPECT_TRUE(scene.solvable);
}

TEST_F(LinearSceneTest, HasDefaults) {
  const Scene scene = load("kind = \"linear\"\n[elasticity]\npoints = 3\n");
  EXPECT_EQ(scene.stop.tolerance, 1e-6);
  EXPECT_EQ(scene.stop.iterations, 2000);
  EXPECT_EQ(scene.modification.tau, .97);
  EXPECT_EQ(scene.blocks.rows, 27);
  EXPECT_EQ(scene.rows.rows, 81);
  for (const float x : scene.b) EXPECT_LE(std::abs(x), 1);
}

TEST_F(LinearSceneTest, RefusesWhatIsWrong) {
  const std::string head = "kind = \"linear\"\n", tank = "[poisson]\ncells = 4\n";
  EXPECT_EQ(error(head), "a.toml:1:1: expected one of [poisson], [elasticity] and [file]");
  EXPECT_EQ(error(head + tank + "[elasticity]\npoints = 3\n"),
            "a.toml:1:1: expected one of [poisson], [elasticity] and [file]");
  EXPECT_EQ(error("kind = \"fluid\"\n" + tank), "a.toml:1:8: kind: expected \"linear\"");
  EXPECT_EQ(error(head + "tolerance = 0\n" + tank), "a.toml:2:13: tolerance: expected a number from 1e-12 to 0.1");
  EXPECT_EQ(error(head + "tau = nan\n" + tank), "a.toml:2:7: tau: expected a number from 0 to 1");
  EXPECT_NE(error(head + "iterations = 0\n" + tank).find("iterations"), std::string::npos);
  EXPECT_NE(error(head + "seed = 0\n" + tank).find("a.toml:2:1"), std::string::npos);
  EXPECT_NE(error(head + "[poisson]\ncells = 0\n").find("a.toml:3:9: cells: expected"), std::string::npos);
  EXPECT_NE(error(head + "[poisson]\ncells = 4\nhole = 0.5\n").find("a.toml:4:8: hole: expected"), std::string::npos);
  EXPECT_NE(error(head + "[elasticity]\npoints = 1\n").find("a.toml:3:10: points: expected"), std::string::npos);
  EXPECT_NE(error(head + "[file]\nmatrix = \"none.mtx\"\n").find("none.mtx: cannot be read"), std::string::npos);
}

TEST_F(LinearSceneTest, RefusesWhatDoesNotFitTheMemory) {
  limit_memory(1e9);
  EXPECT_NE(error("kind = \"linear\"\n[poisson]\ncells = 512\n").find("a matrix of 134217728 rows"), std::string::npos);
  EXPECT_NE(error("kind = \"linear\"\n[elasticity]\npoints = 128\n").find("a matrix of 6291456 rows"),
            std::string::npos);
  limit_memory(std::numeric_limits<double>::infinity());
}

// --- Matrix Market

TEST_F(LinearSceneTest, ReadsAGeneralMatrix) {
  const auto [a, is_symmetric] = read(
      "%%matrixmarket MATRIX coordinate Real general\r\n% a comment\n\n 2 3 3 \n2 3 -1.5e0\n%\n1 1\t+2\n2 1 .25\n\n");
  EXPECT_FALSE(is_symmetric);
  EXPECT_EQ(a.rows, 2);
  EXPECT_EQ(a.columns, 3);
  EXPECT_EQ(a.begin, (Array<std::int32_t>{0, 1, 3}));
  EXPECT_EQ(a.column, (Array<std::int32_t>{0, 0, 2}));
  EXPECT_EQ(a.value, (Array<float>{2, .25f, -1.5f}));
}

TEST_F(LinearSceneTest, ReadsASymmetricMatrix) {
  const auto [a, is_symmetric] =
      read("%%MatrixMarket matrix coordinate integer symmetric\n3 3 3\n3 1 -1\n1 1 4\n2 2 5\n");
  EXPECT_TRUE(is_symmetric);
  EXPECT_EQ(a.begin, (Array<std::int32_t>{0, 2, 3, 4}));
  EXPECT_EQ(a.column, (Array<std::int32_t>{0, 2, 1, 0}));
  EXPECT_EQ(a.value, (Array<float>{4, -1, 5, -1}));
  write_bytes(path("a.toml"), "kind = \"linear\"\n[file]\nmatrix = \"a.mtx\"\n");
  EXPECT_FALSE(load_scene(path("a.toml")).solvable);  // the last diagonal entry is missing
}

TEST_F(LinearSceneTest, RefusesWhatIsNoMatrix) {
  const std::string header =
      "expected %%MatrixMarket matrix coordinate, then real or integer, then general or symmetric, not ";
  EXPECT_EQ(market_error(""), "a.mtx:1: " + header + "the end of the file");
  EXPECT_EQ(market_error("1 1 1\n1 1 1\n"), "a.mtx:1: " + header + "\"1 1 1\"");
  EXPECT_EQ(market_error("%%MatrixMarket matrix array real general\n"),
            "a.mtx:1: " + header + "\"%%MatrixMarket matrix array real general\"");
  EXPECT_EQ(market_error("%%MatrixMarket matrix coordinate complex general\n").find("a.mtx:1: expected"), 0u);
  EXPECT_EQ(market_error("%%MatrixMarket matrix coordinate real skew-symmetric\n").find("a.mtx:1: expected"), 0u);
  const std::string sizes = "expected the numbers of rows, of columns and of entries, not ";
  EXPECT_EQ(market_error(general), "a.mtx:2: " + sizes + "the end of the file");
  EXPECT_EQ(market_error(general + "%\n2 2\n"), "a.mtx:3: " + sizes + "\"2 2\"");
  EXPECT_EQ(market_error(general + "0 2 1\n"), "a.mtx:2: " + sizes + "\"0 2 1\"");
  EXPECT_EQ(market_error(general + "3000000000 2 1\n"), "a.mtx:2: " + sizes + "\"3000000000 2 1\"");
  EXPECT_EQ(market_error(general + "2 2 -1\n"), "a.mtx:2: " + sizes + "\"2 2 -1\"");
  EXPECT_EQ(market_error(symmetric + "2 3 1\n").find("a.mtx:2: expected as many rows as columns"), 0u);
  const std::string entry = "expected row (1 .. 2), column (1 .. 3) and value";
  EXPECT_EQ(market_error(general + "2 3 2\n1 1 1\n"), "a.mtx:4: " + entry + " of entry 2, not the end of the file");
  for (const std::string line : {"0 1 1", "3 1 1", "1 4 1", "1 1", "1 1 1 1", "1 1 x", "1 1 1e999", "1.0 1 1"})
    EXPECT_EQ(market_error(general + "2 3 1\n" + line + "\n"), "a.mtx:3: " + entry + ", not \"" + line + "\"");
  for (const std::string line : {"1 1 nan", "1 1 inf", "1 1 1e39"})
    EXPECT_EQ(market_error(general + "2 3 1\n" + line + "\n"),
              "a.mtx:3: expected a value that a float can hold, not \"" + line + "\"");
  EXPECT_EQ(market_error(general + "2 3 1\n1 1 1\n1 2 1\n"), "a.mtx:4: expected no more than 1 entries, not \"1 2 1\"");
  EXPECT_EQ(market_error(general + "2 3 2\n2 1 1\n2 1 3\n"),
            "a.mtx:4: expected each entry once, not row 2, column 1 twice");
  EXPECT_EQ(market_error(symmetric + "2 2 1\n1 2 1\n").find("a.mtx:3: expected entries on or below the diagonal"), 0u);
}

TEST_F(LinearSceneTest, RefusesRowsThatDoNotFitTheMemory) {
  limit_memory(1e6);
  EXPECT_NE(market_error(general + "2000000000 1 0\n").find("2000000000 rows"), std::string::npos);
  limit_memory(std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace lockstep::linear
