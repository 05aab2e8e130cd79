#include "verify/record.h"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <vector>

#include "verify/recorder.h"

namespace lockstep::verify {

Record record(int cores, const std::function<void()>& work, double (*clock)(), double clock_ns, Locks locks) {
  Recorder mine(cores, clock, clock_ns, locks);
  std::atomic<bool> all_done = false;
  Record made;
  // One thread makes the record, the others serve it as hosts. `recorder` is set after the barrier, when no thread
  // calls OpenMP for itself any more.
#pragma omp parallel num_threads(mine.hosts())
  {
    const int thread = omp_get_thread_num();
#pragma omp barrier
    if (thread == 0) {
      recorder = &mine;
      made = mine.make(work);
      recorder = nullptr;
      all_done.store(true, std::memory_order_release);
    } else {
      mine.host(thread).serve(all_done);
    }
  }
  return made;
}

bool has_locks(const Record& record) {
  for (const Region& region : record.regions)
    for (const std::vector<Event>& events : region)
      if (std::ranges::find(events, Event::lock, &Event::kind) != events.end()) return true;
  return false;
}

namespace {

double work_in(const Region& region) {
  double ns = 0;
  for (const std::vector<Event>& events : region)
    for (const Event& event : events) ns += event.ns;
  return ns;
}

}  // namespace

void fit(Record& noted, const Record& whole) {
  for (std::size_t r = 0; r < noted.regions.size(); ++r) {
    const double had = work_in(noted.regions[r]), has = work_in(whole.regions[r]);
    if (had == 0) continue;
    for (std::vector<Event>& events : noted.regions[r])
      for (Event& event : events) event.ns *= has / had;
  }
}

}  // namespace lockstep::verify
