// Records what every thread of a team of any size does in a kernel's parallel regions, one at a time.
//
// The kernel runs as it is: its calls to the OpenMP runtime are answered by a team that is not there (record.cpp). Each member of the
// team runs the region on a stack of its own until it meets a barrier or asks for a chunk of a loop, then the one that has worked least
// so far goes on. Members are spread over the machine's cores, of which one works while the others wait. So a kernel that divides its work
// by omp_get_num_threads() divides it as it would on that many cores, chunks of dynamic loops go to whoever would be free first, what
// others wrote comes from another core's cache, and the results are those of such a run. What is lost: no two ask for memory at once, and
// members share as many caches as the machine has (notes/scaling.md).
#pragma once

#include <functional>
#include <vector>

namespace lockstep::verify {

struct Event {
  enum Kind { work, lock, unlock, dispatch, barrier } kind;
  double ns = 0;               // work: how long
  const void* what = nullptr;  // lock, unlock: which; dispatch: a chunk of which loop
};

// What each thread of the team did in one region, in order. The region ends when the last of them does.
using Region = std::vector<std::vector<Event>>;

struct Record {
  int cores;
  std::vector<Region> regions;
  std::vector<double> serial_ns;  // before each region, and after the last
};

// Runs `work` once. `clock` gives the time in ns; `clock_ns` is what reading it costs, which is taken from every stretch of work.
// omp_get_max_threads() is `cores` for `work`. Regions within regions have one thread, as by default in OpenMP. Not for two threads at
// once. Locks are taken in any case, though no one else asks: what that costs is work.
enum class Locks { noted, left_out };
Record record(int cores, const std::function<void()>& work, double (*clock)(), double clock_ns, Locks locks);

bool has_locks(const Record& record);

// Gives each region of `noted` as much work as it has in `whole`, of the same work with locks left out. To read the clock at each of a
// million locks takes time that nothing tells from the kernel's own: a processor does much of both at once. So the one record says how work
// is spread over the locks, the other how much it is.
void fit(Record& noted, const Record& whole);

}  // namespace lockstep::verify
