#include "verify/record.h"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <vector>

#include "verify/recorder.h"

namespace lockstep::verify {

Record record(int cores, const std::function<void()>& work, double (*clock)(), double clock_ns, Locks locks) {
  Recorder mine(cores, clock, clock_ns);
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
      recorder_of_locks = locks == Locks::noted ? &mine : nullptr;
      made = mine.make(work);
      recorder = recorder_of_locks = nullptr;
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

void fit(Record& noted, const Record& whole) {
  const auto work_of = [](const std::vector<Event>& member) {
    double ns = 0;
    for (const Event& event : member) ns += event.ns;
    return ns;
  };
  for (std::size_t r = 0; r < noted.regions.size(); ++r)
    for (std::size_t m = 0; m < noted.regions[r].size(); ++m) {
      std::vector<Event>& member = noted.regions[r][m];
      const double had = work_of(member), has = work_of(whole.regions[r][m]);
      if (had == 0) continue;
      for (Event& event : member) event.ns *= has / had;
    }
}

}  // namespace lockstep::verify
