// Memory near the threads that work on it.
//
// A machine of several memory nodes gives a page to the node of the thread that first writes to it. One thread makes
// the inputs of a kernel, so all of them would be on its node.
#pragma once

namespace lockstep::verify {

// As long as it lives, each page of a new large array (common/array.h) is first written by a team: the first thread
// takes the first share of the pages, and so on, as loops with a static schedule share an array. Outside parallel
// regions; one at a time.
class PagesOfTeam {
 public:
  explicit PagesOfTeam(int threads);
  ~PagesOfTeam();
  PagesOfTeam(const PagesOfTeam&) = delete;
  PagesOfTeam& operator=(const PagesOfTeam&) = delete;
};

}  // namespace lockstep::verify
