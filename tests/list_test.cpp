// What there is, by `lockstep list`, and what README says there is. Run from the root of the repository.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/cli.h"
#include "verify/domain.h"
#include "verify/kernel.h"

namespace lockstep {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST_F(Cli, ListsWhatReadmeSays) {
  const Outcome outcome = run({"list", "--markdown"});
  EXPECT_EQ(outcome.code, 0);
  const std::string readme = text_of("README.md"), begin = "<!-- build/lockstep list --markdown -->\n";
  const std::size_t at = readme.find(begin);
  ASSERT_NE(at, std::string::npos);
  const std::string table = readme.substr(at + begin.size(), readme.find("<!-- end -->", at) - at - begin.size());
  EXPECT_EQ(table, outcome.out) << "README's table is what build/lockstep list --markdown prints";
}

// A scene that FULL=1 adds is not one that `make verify` has, or the form would run on it twice.
TEST(List, NoFormHasASceneTwice) {
  for (const verify::Kernel& kernel : verify::kernels())
    for (const std::string& scene : kernel.more_scenes)
      EXPECT_EQ(std::ranges::count(kernel.scenes, scene), 0) << kernel.name << ' ' << kernel.form << ' ' << scene;
}

TEST_F(Cli, ListsNamesForLoopsOfAShell) {
  const auto listed = [&](const std::string& what) {
    const Outcome outcome = run({"list", what});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    std::vector<std::string> lines;
    std::istringstream text(outcome.out);
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    EXPECT_EQ(std::set(lines.begin(), lines.end()).size(), lines.size()) << what;
    return lines;
  };
  std::vector<std::string> names, forms;
  for (const verify::Kernel& kernel : verify::kernels()) {
    if (names.empty() || names.back() != kernel.name) names.push_back(kernel.name);
    forms.push_back(kernel.form.empty() ? kernel.name : kernel.name + ' ' + kernel.form);
  }
  EXPECT_EQ(listed("kernels"), names);
  EXPECT_EQ(listed("forms"), forms);
  const std::vector<std::string> scenes = listed("scenes");
  std::size_t files = 0;
  for (const verify::Domain& domain : verify::domains())
    for (const auto& entry : fs::directory_iterator("scenes/" + domain.name))
      if (entry.path().extension() == ".toml") {
        ++files;
        EXPECT_EQ(std::ranges::count(scenes, entry.path().stem().string()), 1) << entry.path();
      }
  EXPECT_EQ(scenes.size(), files);
  expect_refused({"list", "kernel"}, "kernels");
  expect_refused({"list", "kernels", "--json"}, "--json");
}

// serial/DOMAIN/KERNEL.cpp, openmp/DOMAIN/KERNEL.cpp and verify/DOMAIN/KERNEL.cpp hold a kernel.
TEST(List, EveryKernelHasItsFiles) {
  for (const verify::Kernel& kernel : verify::kernels())
    for (const std::string folder : {"serial/", "openmp/", "verify/"})
      EXPECT_TRUE(fs::exists(folder + kernel.name + ".cpp")) << folder << kernel.name;
}

TEST(List, EverySceneIsThereAndOfItsDomain) {
  for (const verify::Kernel& kernel : verify::kernels())
    for (const auto* scenes : {&kernel.scenes, &kernel.more_scenes, &kernel.bench_scenes, &kernel.tsan_scenes})
      for (const std::string& path : *scenes)
        EXPECT_TRUE(kernel.takes(path)) << kernel.name << ' ' << kernel.form << ": " << path;
}

// A form is looked at by the thread sanitizer, or says which other form runs its code.
TEST(List, NoFormEscapesTheSanitizer) {
  std::set<std::pair<std::string, std::string>> forms;
  for (const verify::Kernel& kernel : verify::kernels()) EXPECT_TRUE(forms.insert({kernel.name, kernel.form}).second);
  for (const verify::Kernel& kernel : verify::kernels()) {
    EXPECT_NE(kernel.tsan_scenes.empty(), kernel.covered_by.empty()) << kernel.name << ' ' << kernel.form;
    EXPECT_TRUE(kernel.covered_by.empty() || forms.contains({kernel.name, kernel.covered_by}))
        << kernel.name << ' ' << kernel.form;
  }
}

TEST(List, EveryDomainHasItsFolders) {
  for (const verify::Domain& domain : verify::domains()) {
    for (const std::string folder : {"common/", "serial/", "openmp/", "scenes/", "verify/"})
      EXPECT_TRUE(fs::is_directory(folder + domain.name)) << folder << domain.name;
    EXPECT_FALSE(domain.determinism.empty()) << domain.name;
    for (const std::string& scene : domain.determinism)
      EXPECT_TRUE(fs::exists("scenes/" + domain.name + '/' + scene + ".toml")) << scene;
  }
}

}  // namespace
}  // namespace lockstep
