// What there is, by `lockstep list`, and what README says there is. Run from the root of the repository.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

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
