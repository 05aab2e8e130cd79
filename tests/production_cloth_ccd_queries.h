// Queries of continuous collision detection with exact verdicts, in the format of the public sets
// Continuous-Collision-Detection/Sample-Queries and Sample-Scalable-CCD-Data: eight lines a query, of seven columns: x,
// y, z each as numerator and denominator, and whether the pair meets. Lines of a point and a triangle: the point and
// the corners at the start, the same at the end; of two edges: a0, a1, b0, b1 at the start, the same at the end.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "common/production_cloth/ccd.h"

namespace lockstep::production_cloth {

struct CcdQuery {
  bool edges;
  std::array<Vector3<double>, 4> start, end;
  bool meets;
};

// What ccd says of one pair that stands alone in the world.
struct CcdAnswer {
  Contacts<double> impacts;
  bool meets() const { return impacts.count > 0; }
};
inline Topology lone_pair(bool edges) {
  Topology topology;
  topology.vertices = 4;
  if (edges)
    topology.edges = {{0, 1}, {2, 3}};
  else
    topology.triangles = {{1, 2, 3}};
  return topology;
}
inline CcdAnswer answer_of(const CcdQuery& query) {
  Vectors<double> start, end;
  start.resize(4), end.resize(4);
  for (int i = 0; i < 4; ++i) store(start, i, query.start[i]), store(end, i, query.end[i]);
  ElementPairs pairs;
  if (query.edges)
    pairs.edge_edge = {{0, 1}};
  else
    pairs.point_triangle = {{0, 0}};
  CcdAnswer answer;
  serial::ccd(lone_pair(query.edges), pairs, start, end, answer.impacts);
  return answer;
}

// A quotient of integers of any length, rounded a few times: the sets are of doubles, whose quotients are exact.
inline double number_of(const std::string& numerator, const std::string& denominator) {
  return static_cast<double>(std::strtold(numerator.c_str(), nullptr) / std::strtold(denominator.c_str(), nullptr));
}

// `verdicts`: of the queries in order, where the file has no seventh column.
inline std::vector<CcdQuery> read_queries(const std::string& path, bool edges, const std::vector<bool>& verdicts = {}) {
  std::ifstream in(path);
  EXPECT_TRUE(in) << path;
  std::vector<CcdQuery> queries;
  std::string line;
  for (int row = 0; std::getline(in, line); row = (row + 1) % 8) {
    std::vector<std::string> column;
    std::istringstream words(line);
    for (std::string word; std::getline(words, word, ',');) column.push_back(word);
    if (column.size() < 6) {
      ADD_FAILURE() << path << ": " << line;
      return {};
    }
    if (row == 0)
      queries.push_back({edges, {}, {}, verdicts.empty() ? std::stoi(column.at(6)) != 0 : verdicts.at(queries.size())});
    CcdQuery& query = queries.back();
    (row < 4 ? query.start : query.end)[row % 4] = {number_of(column[0], column[1]), number_of(column[2], column[3]),
                                                    number_of(column[4], column[5])};
  }
  return queries;
}

// A list of true and false, of any punctuation.
inline std::vector<bool> read_verdicts(const std::string& path) {
  std::ifstream in(path);
  EXPECT_TRUE(in) << path;
  std::string text((std::istreambuf_iterator<char>(in)), {});
  std::vector<bool> verdicts;
  const std::regex word("true|false|[01]");
  for (std::sregex_iterator it(text.begin(), text.end(), word), end; it != end; ++it)
    verdicts.push_back(it->str() == "true" || it->str() == "1");
  return verdicts;
}

struct CcdCount {
  int queries = 0, meet = 0, missed = 0, false_alarms = 0;
};
inline void count_answers(const std::vector<CcdQuery>& queries, CcdCount& count) {
  for (const CcdQuery& query : queries) {
    const bool meets = answer_of(query).meets();
    ++count.queries, count.meet += query.meets;
    count.missed += query.meets && !meets, count.false_alarms += !query.meets && meets;
  }
}

}  // namespace lockstep::production_cloth
