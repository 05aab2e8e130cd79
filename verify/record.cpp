#include "verify/record.h"

#include <omp.h>

#include <algorithm>
#include <atomic>
#include <numeric>
#include <utility>
#include <vector>

#include "verify/recorder.h"

namespace lockstep::verify {

Record record(int cores, const std::function<void()>& work, double (*clock)(), double clock_ns, Waits waits) {
  Recorder mine(cores, clock, clock_ns, waits);
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
      recorder_of_locks = waits == Waits::noted ? &mine : nullptr;
      made = mine.make(work);
      recorder = recorder_of_locks = nullptr;
      all_done.store(true, std::memory_order_release);
    } else {
      mine.host(thread).serve(all_done);
    }
  }
  return made;
}

bool has_waits(const Record& record) {
  const auto is_wait = [](const Event& event) { return event.kind == Event::lock || event.kind == Event::await; };
  bool found = false;
  for (const Region& region : record.regions)
    for_each_list(region, [&](const Events& events) { found = found || std::ranges::any_of(events, is_wait); });
  return found;
}

namespace {

double work_of(const Events& events) {
  double ns = 0;
  for (const Event& event : events) ns += event.ns;
  return ns;
}
double work_of(const Region& region) {
  double ns = 0;
  for_each_list(region, [&](const Events& events) { ns += work_of(events); });
  return ns;
}
double work_of(const Record& record) {
  double ns = std::accumulate(record.serial_ns.begin(), record.serial_ns.end(), 0.);
  for (const Region& region : record.regions) ns += work_of(region);
  return ns;
}

void scale(Events& events, double factor) {
  for (Event& event : events) event.ns *= factor;
}

// Calls f(events of a, events of b) for all lists, as far as both regions have them.
template <class A, class B, class F>
void for_each_list_of_both(A& a, B& b, const F& f) {
  std::vector<decltype(a.members.data())> of_a;
  for_each_list(a, [&](auto& events) { of_a.push_back(&events); });
  std::size_t k = 0;
  for_each_list(b, [&](auto& events) {
    if (k < of_a.size()) f(*of_a[k++], events);
  });
}

// Whether threads and chunks do the same things in the same order, for however long.
bool are_alike(const Region& a, const Region& b) {
  const auto sizes = [](const Region& region) {
    std::vector<std::size_t> all = {region.members.size()};
    for (const auto& loop : region.chunks) all.push_back(loop.size());
    return all;
  };
  bool alike = sizes(a) == sizes(b);
  const auto same = [](const Event& x, const Event& y) { return x.kind == y.kind && x.value == y.value; };
  for_each_list_of_both(a, b,
                        [&](const Events& x, const Events& y) { alike = alike && std::ranges::equal(x, y, same); });
  return alike;
}

}  // namespace

void fit(Record& noted, const Record& whole) {
  for (std::size_t r = 0; r < noted.regions.size(); ++r)
    for_each_list_of_both(noted.regions[r], whole.regions[r], [](Events& events, const Events& has) {
      if (const double had = work_of(events); had > 0) scale(events, work_of(has) / had);
    });
}

void Records::add(Record record) {
  const double work_ns = work_of(record);
  const bool is_first = spread_.serial_ns.empty();
  // Kernels that threads race in may take another number of rounds each time.
  if (is_first || record.regions.size() != spread_.regions.size()) {
    if (is_first || work_ns < work_ns_) spread_ = std::move(record), work_ns_ = work_ns;
    return;
  }
  work_ns_ = std::min(work_ns_, work_ns);
  for (std::size_t k = 0; k < record.serial_ns.size(); ++k)
    spread_.serial_ns[k] = std::min(spread_.serial_ns[k], record.serial_ns[k]);
  for (std::size_t r = 0; r < record.regions.size(); ++r) {
    Region &least = spread_.regions[r], &region = record.regions[r];
    if (are_alike(least, region))
      for_each_list_of_both(least, region, [](Events& events, const Events& others) {
        for (std::size_t k = 0; k < events.size(); ++k) events[k].ns = std::min(events[k].ns, others[k].ns);
      });
    else if (work_of(region) < work_of(least))
      least = std::move(region);
  }
}

Record Records::least() const {
  Record record = spread_;
  const double spread_ns = work_of(record);
  if (spread_ns == 0) return record;
  const double factor = work_ns_ / spread_ns;
  for (double& ns : record.serial_ns) ns *= factor;
  for (Region& region : record.regions) for_each_list(region, [&](Events& events) { scale(events, factor); });
  return record;
}

}  // namespace lockstep::verify
