// Names on the command line: kernels by domain, last part or pattern; scenes by name from any directory; and the
// nearest names to one that is unknown.
#include <nlohmann/json.hpp>
#include <set>

#include "tests/cli.h"
#include "verify/names.h"

namespace lockstep {
namespace {

TEST(Names, AreNearByTheirEdits) {
  EXPECT_EQ(verify::did_you_mean("dambreak", {"dam_break_5k", "castle", "dam_break_35k"}),
            "; did you mean dam_break_5k, dam_break_35k?");
  EXPECT_EQ(verify::did_you_mean("benhc", {"verify", "bench", "scale"}), "; did you mean bench?");
  EXPECT_EQ(verify::did_you_mean("castle", {"verify", "bench"}), "");
  EXPECT_EQ(verify::did_you_mean("", {"verify"}), "; did you mean verify?");
  EXPECT_EQ(verify::did_you_mean("x", {}), "");
}

TEST(Names, OfKernels) {
  for (const char* named : {"fluid/forces", "fluid", "forces", "*/forces", "fluid/*", "fluid/f?rces"})
    EXPECT_TRUE(verify::names_kernel(named, "fluid/forces")) << named;
  for (const char* named : {"fluid/force", "cloth", "f", "", "*/step"})
    EXPECT_FALSE(verify::names_kernel(named, "fluid/forces")) << named;
}

struct NamedKernels : Cli {
  std::set<std::string> verified(const std::string& kernel, const std::string& scene) const {
    const Outcome outcome =
        run({"verify", "--kernel", kernel, "--scene", scene, "--threads", "1", "--json", path("v.json")});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    std::set<std::string> names;
    const nlohmann::json report = nlohmann::json::parse(read_bytes(path("v.json")));
    for (const auto& row : report["rows"]) names.insert(row["kernel"]);
    return names;
  }
};

TEST_F(NamedKernels, AreADomainALastPartOrAPattern) {
  EXPECT_EQ(verified("collide", "rope"), std::set<std::string>{"cloth/collide"});
  EXPECT_EQ(verified("*/step", "single"), std::set<std::string>{"fluid/step"});
  EXPECT_EQ(verified("fluid", "single").size(), 6u);
  EXPECT_EQ(verified("cloth/collide,verlet", "rope"), (std::set<std::string>{"cloth/collide", "cloth/verlet"}));
}

TEST_F(NamedKernels, RefusesUnknownOnesWithTheNearest) {
  expect_refused({"verify", "--kernel", "fluid/density"},
                 "no kernel fluid/density, see `lockstep list`; did you mean fluid/densities?");
  expect_refused({"verify", "--kernel", "fluid/forces,fluid/density"}, "no kernel fluid/density,");
  expect_refused({"bench", "--kernel", "forces", "--form", "sub_girds"},
                 "no form sub_girds of forces, expected one of: owner_gather, pair_lists, sub_grid, cell_locks");
  expect_refused({"verify", "--kernel", "advance", "--scene", "castle"},
                 "castle: is a scene of rigid, which fluid/advance does not take");
  expect_refused({"run", "--scene", "dambreak", "--out", path("frames")}, "did you mean dam_break_100k,");
  expect_refused({"benhc"}, "benhc is not known; did you mean bench?");
  expect_refused({"run", "--scen", "x"}, "--scen is not known; did you mean --scene?");
}

TEST_F(NamedKernels, ScenesHaveNamesInAnyDirectory) {
  const Outcome outcome = end_of(start({"run", "--scene", "rope", "--frames", "1", "--out", path("frames")},
                                       [] { [[maybe_unused]] const int at_root = chdir("/"); }));
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("rope: "), std::string::npos) << outcome.out;
}

TEST_F(NamedKernels, VersionNamesTheBuild) {
  const Outcome outcome = run({"--version"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.out.find("lockstep "), 0u) << outcome.out;
}

}  // namespace
}  // namespace lockstep
