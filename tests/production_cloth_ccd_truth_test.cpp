// Continuous collision detection against exact verdicts of public sets of queries. A few of the sets stand in
// tests/data/production_cloth_ccd; whole sets are read from the folder that the variable CCD_DATA names, if it is
// there.
#include <algorithm>
#include <cstdio>
#include <map>

#include "tests/production_cloth_ccd_queries.h"

namespace lockstep::production_cloth {
namespace {

namespace fs = std::filesystem;

TEST(ProductionClothCcdTruth, NoneOfTheSamplesIsMissed) {
  CcdCount count;
  count_answers(read_queries("tests/data/production_cloth_ccd/vertex_face.csv", false), count);
  count_answers(read_queries("tests/data/production_cloth_ccd/edge_edge.csv", true), count);
  EXPECT_GT(count.queries, 0);
  EXPECT_GT(count.meet, 0);
  EXPECT_LT(count.meet, count.queries);
  EXPECT_EQ(count.missed, 0);
}

// Sample-Queries: SET/vertex-face/*.csv, SET/edge-edge/*.csv. Sample-Scalable-CCD-Data: SET/queries/227vf.csv, with
// SET/mma_bool/227vf_mma_bool.json.
TEST(ProductionClothCcdTruth, NoneOfTheWholeSetsIsMissed) {
  const char* folder = std::getenv("CCD_DATA");
  if (folder == nullptr) GTEST_SKIP() << "CCD_DATA names no folder of queries";
  std::map<std::string, CcdCount> counts;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const fs::path& path = entry.path();
    if (path.extension() != ".csv") continue;
    const std::string kind = path.parent_path().filename().string(), stem = path.stem().string();
    const std::string set = path.parent_path().parent_path().filename().string();
    std::vector<CcdQuery> queries;
    if (kind == "queries") {
      const fs::path verdicts = path.parent_path().parent_path() / "mma_bool" / (stem + "_mma_bool.json");
      queries = read_queries(path.string(), stem.ends_with("ee"), read_verdicts(verdicts.string()));
    } else if (kind == "vertex-face" || kind == "edge-edge") {
      queries = read_queries(path.string(), kind == "edge-edge");
    }
    if (!queries.empty()) count_answers(queries, counts[set + (queries[0].edges ? " edges" : " points")]);
  }
  CcdCount all;
  std::printf("%-40s %8s %6s %7s %13s\n", "set", "queries", "meet", "missed", "false alarms");
  const auto print = [](const std::string& name, const CcdCount& c) {
    std::printf("%-40s %8d %6d %7d %13d\n", name.c_str(), c.queries, c.meet, c.missed, c.false_alarms);
  };
  for (const auto& [name, c] : counts) {
    print(name, c);
    all.queries += c.queries, all.meet += c.meet, all.missed += c.missed, all.false_alarms += c.false_alarms;
  }
  print("all", all);
  EXPECT_GT(all.queries, 0);
  EXPECT_EQ(all.missed, 0);
}

}  // namespace
}  // namespace lockstep::production_cloth
