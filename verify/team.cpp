#include "verify/team.h"

#include <algorithm>
#include <climits>

namespace lockstep::verify {
namespace {

// Regions outside other regions come one after another, so that one thread at a time writes these.
int least = INT_MAX, most = 0;

}  // namespace

void note_team_size(int threads) { least = std::min(least, threads), most = std::max(most, threads); }

TeamSizes take_team_sizes() {
  const TeamSizes sizes = {most == 0 ? 0 : least, most};
  least = INT_MAX, most = 0;
  return sizes;
}

std::vector<int> doubling_to(int most) {
  std::vector<int> counts;
  for (int count = 1; count < most; count *= 2) counts.push_back(count);
  counts.push_back(most);
  return counts;
}

std::string other_team(const TeamSizes& teams, int threads) {
  const int ran = teams.least == threads ? teams.most : teams.least;
  return "ran on " + std::to_string(ran) + (ran == 1 ? " thread" : " threads") + ", not " + std::to_string(threads) +
         " (OMP_THREAD_LIMIT or OMP_DYNAMIC?)";
}

}  // namespace lockstep::verify
