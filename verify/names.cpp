#include "verify/names.h"

#include <fnmatch.h>

#include <algorithm>
#include <filesystem>
#include <numeric>

#include "common/input_error.h"
#include "verify/domain.h"

namespace lockstep::verify {
namespace {

// The least number of edits that turn `word` into a beginning of `candidate`.
std::size_t edits(const std::string& word, const std::string& candidate) {
  std::vector<std::size_t> row(candidate.size() + 1);  // [n]: of the word so far and the candidate's first n letters
  std::iota(row.begin(), row.end(), 0);
  for (const char letter : word) {
    std::size_t diagonal = row[0]++;
    for (std::size_t n = 1; n < row.size(); ++n) {
      const std::size_t replaced = diagonal + (letter != candidate[n - 1]);
      diagonal = row[n];
      row[n] = std::min({replaced, row[n] + 1, row[n - 1] + 1});
    }
  }
  return *std::ranges::min_element(row);
}

}  // namespace

bool names_kernel(const std::string& named, const std::string& kernel) {
  const std::size_t slash = kernel.find('/');
  return named == kernel.substr(0, slash) || named == kernel.substr(slash + 1) ||
         fnmatch(named.c_str(), kernel.c_str(), 0) == 0;
}

std::string joined(const std::vector<std::string>& words, const std::string& between) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : between) + word;
  return all;
}

std::string did_you_mean(const std::string& word, const std::vector<std::string>& candidates) {
  constexpr std::size_t most = 4;
  std::size_t least = word.size() / 3 + 1;  // more edits than these make another word
  std::vector<std::string> nearest;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edits(word, candidate);
    if (distance > least || std::ranges::find(nearest, candidate) != nearest.end()) continue;
    if (distance < least) nearest.clear();
    least = distance;
    if (nearest.size() < most) nearest.push_back(candidate);
  }
  return nearest.empty() ? "" : "; did you mean " + joined(nearest, ", ") + "?";
}

std::string scenes_folder() {
  std::error_code error;
  if (std::filesystem::is_directory("scenes", error)) return "scenes";
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  return program.parent_path().parent_path().parent_path() / "scenes";
}

std::string scene_file(const std::string& named) {
  std::error_code error;
  if (std::filesystem::exists(named, error)) return named;
  std::vector<std::string> names;
  for (const Domain& domain : domains())
    for (const auto& entry : std::filesystem::directory_iterator(scenes_folder() + '/' + domain.name, error))
      if (entry.path().extension() == ".toml") {
        if (entry.path().stem() == named) return entry.path();
        names.push_back(entry.path().stem());
      }
  std::ranges::sort(names);
  throw InputError(named + ": cannot be read: No such file or directory" +
                   did_you_mean(std::filesystem::path(named).stem(), names));
}

}  // namespace lockstep::verify
