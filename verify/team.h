// How large the teams were that ran a kernel's parallel regions.
#pragma once

#include <string>
#include <vector>

namespace lockstep::verify {

struct TeamSizes {
  int least, most;  // threads; 0 where no region ran

  // Whether every region ran on as many threads as asked for. True where no region ran.
  bool are(int threads) const { return most == 0 || (least == threads && most == threads); }
};

// The sizes of the teams since the last call. They are seen from within the regions (record_wraps.cpp); regions inside
// other regions do not count. A build whose OpenMP runtime is not libgomp sees none.
TeamSizes take_team_sizes();

// To be called by a team's first thread in its region.
void note_team_size(int threads);

// 1, 2, 4, ... and `most`: the thread counts that show how a machine of `most` cores scales.
std::vector<int> doubling_to(int most);

// Why a row at `threads` threads does not count, such as "ran on 1 thread, not 2 (OMP_THREAD_LIMIT or OMP_DYNAMIC?)".
std::string other_team(const TeamSizes& teams, int threads);

}  // namespace lockstep::verify
