// The rules of the house: who may include whom, that every serial file has its parallel twin, and that twins read
// alike. Run from the root of the repository.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace lockstep {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> lines_of(const fs::path& path) {
  std::ifstream in(path);
  EXPECT_TRUE(in) << path;
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::vector<fs::path> sources_below(const std::string& folder) {
  std::vector<fs::path> sources;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".h" || entry.path().extension() == ".cpp") sources.push_back(entry.path());
  EXPECT_FALSE(sources.empty()) << folder;
  return sources;
}

// What a file includes of the repository, as a path from its root: by quotes or brackets, relative to the file or not.
std::vector<std::string> includes_of(const fs::path& path) {
  static const std::regex include("\\s*#\\s*include\\s*[\"<]([^\">]+)[\">].*");
  std::vector<std::string> includes;
  for (const std::string& line : lines_of(path))
    if (std::smatch match; std::regex_match(line, match, include)) {
      const fs::path beside = (path.parent_path() / match[1].str()).lexically_normal();
      includes.push_back(fs::exists(beside) ? beside.string() : fs::path(match[1].str()).lexically_normal().string());
    }
  return includes;
}

void expect_includes_none_of(const std::string& folder, const std::vector<std::string>& others) {
  for (const fs::path& path : sources_below(folder))
    for (const std::string& include : includes_of(path))
      for (const std::string& other : others)
        EXPECT_FALSE(include.starts_with(other + '/')) << path << " includes " << include;
}

TEST(House, CommonIncludesNoVersionAndNotTheVerifier) {
  expect_includes_none_of("common", {"serial", "openmp", "verify", "tests"});
}
TEST(House, SerialIncludesCommonAlone) { expect_includes_none_of("serial", {"openmp", "verify", "tests"}); }
TEST(House, OpenmpIncludesCommonAlone) { expect_includes_none_of("openmp", {"serial", "verify", "tests"}); }

TEST(House, SerialKnowsNoThreadsAndNoLanes) {
  for (const fs::path& path : sources_below("serial")) {
    for (const std::string& include : includes_of(path))
      EXPECT_TRUE(include != "omp.h" && include != "common/simd.h") << path;
    for (const std::string& line : lines_of(path)) EXPECT_EQ(line.find("#pragma omp"), std::string::npos) << path;
  }
}

TEST(House, EveryAlgorithmStandsTwice) {
  const auto algorithms = [](const std::string& folder) {
    std::set<std::string> names;
    for (const fs::path& path : sources_below(folder))
      if (path.extension() == ".cpp") names.insert(path.lexically_relative(folder));
    return names;
  };
  EXPECT_EQ(algorithms("serial"), algorithms("openmp"));
}

TEST(House, NumbersAreWhatTheTextSays) {
  const std::vector<std::string> makefile = lines_of("Makefile");
  const auto mentions = [&](const std::string& text) {
    return std::ranges::any_of(makefile, [&](const std::string& line) { return line.find(text) != std::string::npos; });
  };
  for (const char* flag : {"-ffast-math", "-Ofast", "-funsafe-math", "-fassociative-math", "-ffinite-math"})
    EXPECT_FALSE(mentions(flag)) << flag;
  EXPECT_TRUE(mentions("-ffp-contract=off"));
}

TEST(House, ReadmeCitesWhomTheCitationFileNames) {
  std::string readme;
  for (const std::string& line : lines_of("README.md")) readme += line + ' ';
  int authors = 0;
  for (const std::string& line : lines_of("CITATION.cff")) {
    std::smatch name;
    if (!std::regex_search(line, name, std::regex("family-names: ([^,]+), given-names: ([^}]+)"))) continue;
    ++authors;
    EXPECT_NE(readme.find(name[1].str() + ", " + name[2].str()), std::string::npos) << name[0];
  }
  EXPECT_EQ(authors, 17);
}

// A reduction over floats would answer differently at every thread count.
TEST(House, NoReductionInOpenmp) {
  for (const fs::path& path : sources_below("openmp"))
    for (const std::string& line : lines_of(path))
      EXPECT_FALSE(std::regex_search(line, std::regex("reduction\\s*\\(\\s*[+*-]"))) << path << ": " << line;
}

TEST(House, LinesAreShort) {
  constexpr std::size_t most_columns = 120;
  for (const std::string folder : {"common", "serial", "openmp", "verify", "tests", "notes"})
    for (const fs::path& path : sources_below(folder)) {
      int number = 0;
      for (const std::string& line : lines_of(path)) {
        ++number;
        const auto inside_a_character = [](char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; };
        const auto columns = line.size() - std::count_if(line.begin(), line.end(), inside_a_character);
        EXPECT_LE(columns, most_columns) << path << ", line " << number;
      }
    }
}

// What a reader can take in at one sitting. A file that is longer says why in its first lines.
TEST(House, FilesAreShort) {
  constexpr std::size_t most_lines = 350;
  for (const std::string folder : {"common", "serial", "openmp", "verify", "tests"})
    for (const fs::path& path : sources_below(folder)) {
      const std::vector<std::string> lines = lines_of(path);
      const auto says_why = [](const std::string& line) { return line.starts_with("// One file, because "); };
      EXPECT_TRUE(lines.size() <= most_lines || std::any_of(lines.begin(), lines.begin() + 30, says_why))
          << path << " has " << lines.size() << " lines";
    }
}

}  // namespace
}  // namespace lockstep
