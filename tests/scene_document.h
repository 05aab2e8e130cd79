// scenes/README.md as tables: of each domain and each table of its scenes, the rows with its keys.
#pragma once

#include <fstream>
#include <map>
#include <regex>
#include <string>
#include <vector>

namespace lockstep {

struct Row {
  std::string key, range, otherwise;  // without its brackets and quotes
};
using Section = std::vector<Row>;
using Document = std::map<std::string, std::map<std::string, Section>>;  // by domain and table; "" is the top level

inline std::string without(const std::string& cell, const std::string& what) {
  return std::regex_replace(cell, std::regex(what), "");
}
inline std::string bare(const std::string& cell) { return without(cell, "`"); }

inline Document read_document() {
  std::ifstream in("scenes/README.md");
  Document document;
  std::string domain, section;
  const std::regex heading("(##|###) (.+)"), row("\\| `([^|]*)` \\|[^|]*\\|[^|]*\\|([^|]*)\\|([^|]*)\\|");
  for (std::string line; std::getline(in, line);) {
    std::smatch match;
    if (std::regex_match(line, match, heading)) {
      (match[1] == "##" ? domain : section) = without(match[2], "[`\\[\\]]");
      if (match[1] == "##") section = "";
    } else if (std::regex_match(line, match, row)) {
      const std::string ends = "^ +| +$";
      document[domain][section].push_back(
          {without(match[1], "[\\[\\]]"), without(match[2], ends), without(match[3], ends)});
    }
  }
  return document;
}

}  // namespace lockstep
