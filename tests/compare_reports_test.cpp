// `lockstep compare`: made-up reports of bench.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <string>

#include "tests/cli.h"

namespace lockstep {
namespace {

using Json = nlohmann::json;

Json row(const std::string& form, int threads, double ms, const Json& spread, bool whole_cores = true) {
  return {{"kernel", "fluid/step"}, {"form", form}, {"scene", "single"}, {"variant", "openmp"},
          {"threads", threads},     {"ms", ms},     {"spread", spread},  {"whole_cores", whole_cores}};
}

struct Compare : Cli {
  std::string report(const std::string& name, const Json& rows, const std::string& commit = "abc") const {
    const Json machine = {{"cpu", "a cpu"}, {"cores", 2}, {"isa", "avx2"}, {"compiler", "g++"}, {"commit", commit}};
    write_bytes(path(name), Json{{"quick", false}, {"machine", machine}, {"rows", rows}}.dump());
    return path(name);
  }
};

TEST_F(Compare, SaysWhatIsBeyondBothSpreads) {
  const std::string before =
      report("old.json", {row("a", 1, 10, .02), row("a", 2, 10, .02), row("b", 1, 10, .1), row("c", 1, 10, nullptr),
                          row("d", 1, 10, .01), row("gone", 1, 10, .01)});
  const std::string after =
      report("new.json", {row("a", 1, 11, .01), row("a", 2, 8, .03), row("b", 1, 10.9, .01), row("c", 1, 20, .1),
                          row("d", 1, 20, .01, false), row("come", 1, 10, .01)});
  const Outcome outcome = run({"compare", before, after});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const auto has = [&](const std::string& pattern) {
    EXPECT_TRUE(std::regex_search(outcome.out, std::regex(pattern))) << pattern << '\n' << outcome.out;
  };
  has("fluid/step +a +single +openmp +1 +10 +11 +1.100  slower\n");
  has("fluid/step +a +single +openmp +2 +10 +8 +0.800  faster\n");
  has("fluid/step +b +single +openmp +1 +10 +10.9 +1.090  within\n");
  has("fluid/step +c .* 2.000  spread unknown\n");
  has("fluid/step +d .* 2.000  no whole cores\n");
  has("fluid/step +gone .*only in the old report\n");
  has("fluid/step +come .*only in the new report\n");
  has("\n1 faster, 1 slower, 1 within the spreads, 2 unknown\n$");
  EXPECT_EQ(outcome.out.find("not the same"), std::string::npos);
}

TEST_F(Compare, SaysThatMachineOrCommitDiffer) {
  const Json rows = Json::array({row("a", 1, 10, .02)});
  const Outcome outcome = run({"compare", report("old.json", rows), report("new.json", rows, "def")});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_NE(outcome.out.find("not the same: old on \"a cpu\", 2, \"avx2\", \"g++\", \"abc\"; new on"),
            std::string::npos)
      << outcome.out;
}

TEST_F(Compare, RefusesWhatIsNoReport) {
  const std::string good = report("good.json", Json::array({row("a", 1, 10, .02)}));
  expect_refused({"compare", good, path("none.json")}, "none.json: cannot be read");
  write_bytes(path("bad.json"), "{");
  expect_refused({"compare", path("bad.json"), good}, "bad.json: is no report of bench");
  write_bytes(path("other.json"), R"({"machine": {}, "rows": []})");
  expect_refused({"compare", good, path("other.json")}, "other.json: is no report of bench");
  expect_refused({"compare", good}, "new");
}

}  // namespace
}  // namespace lockstep
