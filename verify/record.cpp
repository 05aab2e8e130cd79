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

bool have_same_events(const Region& a, const Region& b) {
  return std::ranges::equal(a, b, [](const std::vector<Event>& x, const std::vector<Event>& y) {
    return std::ranges::equal(x, y, {}, &Event::kind, &Event::kind);
  });
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

void keep_less_disturbed(Record& kept, Record other) {
  if (kept.regions.size() != other.regions.size()) return;
  for (std::size_t s = 0; s < kept.serial_ns.size(); ++s)
    kept.serial_ns[s] = std::min(kept.serial_ns[s], other.serial_ns[s]);
  for (std::size_t r = 0; r < kept.regions.size(); ++r) {
    Region &less = kept.regions[r], &more = other.regions[r];
    if (work_in(more) < work_in(less)) less.swap(more);
    if (!have_same_events(less, more)) continue;
    for (std::size_t core = 0; core < less.size(); ++core)
      for (std::size_t e = 0; e < less[core].size(); ++e)
        if (less[core][e].ns >= more[core][e].ns + interruption) less[core][e].ns = more[core][e].ns;
  }
}

}  // namespace lockstep::verify
