#include "verify/crew.h"

#include <omp.h>

#include "verify/team.h"

namespace lockstep::verify {

void Crew::Gate::open() {
  opened_.value.fetch_add(1);
  wake(opened_);
}

void Crew::Gate::wait(int before) {
  lockstep::wait(opened_, [before](int now) { return now != before; });
}

void Crew::run() {
  in_region_ = true;
  region_(data_);
  in_region_ = false;
  omp_set_num_threads(asked_for_);  // a region may have set another number for the regions that it opens
}

void Crew::parallel(void (*region)(void*), void* data) {
  note_team_size(size_);
  region_ = region, data_ = data;
  running_.store(size_ - 1);
  const int ended = end_.opened();
  begin_.open();
  run();
  if (size_ > 1) end_.wait(ended);
}

void Crew::serve() {
  for (int begun = 0;;) {
    begin_.wait(begun);
    begun = begin_.opened();  // it opens again only after this thread has run the region
    if (!region_) return;
    run();
    if (running_.fetch_sub(1) == 1) end_.open();
  }
}

void Crew::dismiss() {
  region_ = nullptr;
  begin_.open();
}

void Crew::barrier() {
  const int before = all_arrived_.opened();
  if (arrived_.fetch_add(1) + 1 < size_) return all_arrived_.wait(before);
  arrived_.store(0);
  all_arrived_.open();
}

}  // namespace lockstep::verify
