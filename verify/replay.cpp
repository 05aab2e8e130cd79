#include "verify/replay.h"

#include <algorithm>
#include <queue>
#include <unordered_map>

namespace lockstep::verify {
namespace {

struct Lock {
  int holder = -1, last = -1;
  std::vector<int> queue;  // waiting cores, in the order of arrival
};

struct Flag {
  std::vector<std::pair<int, double>> posts;  // the value, and when it was posted; both rise
  std::vector<std::pair<int, int>> waiting;   // the value, and the core that waits for it

  // The first post of the value or of a greater one.
  auto post_of(int value) const { return std::ranges::lower_bound(posts, value, {}, &std::pair<int, double>::first); }
};

struct Loop {
  double free_from = 0;  // when the next chunk can be fetched
  int last = -1;         // the core that fetched last
  std::size_t next = 0;  // chunk
};

struct Core {
  double now = 0;
  const Events* events;    // its own, or those of a chunk
  std::size_t next = 0;    // of its events
  int loop = -1;           // of the chunk
  std::size_t behind = 0;  // its next own event, behind the loop
};

// Replays one region. Adds its times to `spent`. Returns the time from its fork until the first core goes on behind it.
// waited, ns: for how long each core has waited for the region; then, when the region ends, for its end.
double replay_region(const Region& region, const Costs& costs, std::vector<double>& waited, Replayed& spent) {
  const int cores = static_cast<int>(region.members.size());
  std::vector<Core> core(cores);
  for (int c = 0; c < cores; ++c) core[c].events = &region.members[c];
  // The first core opens the region.
  for (int c = 1; c < cores; ++c) {
    const Waking::Late late = costs.waking.after(waited[c]);
    core[c].now = late.waiting;
    core[0].now = std::max(core[0].now, late.waker);
  }
  for (const Core& each : core) spent.waiting += each.now;
  std::unordered_map<const void*, Lock> lock;
  std::vector<Loop> loops(region.chunks.size());
  std::unordered_map<const void*, Flag> flag;
  std::vector<int> at_barrier;

  // Cores that can go on, ordered by their clocks. The earliest acts first, so locks are granted in the order of
  // asking.
  using Turn = std::pair<double, int>;
  std::priority_queue<Turn, std::vector<Turn>, std::greater<>> turns;
  for (int c = 0; c < cores; ++c) turns.push({core[c].now, c});

  const auto take = [&](Lock& g, int c) {
    const double cost = g.last < 0 || g.last == c ? 0 : costs.lock_moved;
    g.holder = g.last = c;
    core[c].now += cost;
    spent.locks += cost;
    turns.push({core[c].now, c});
  };

  // Core c goes on with a loop's next chunk, or, if none is left, behind the loop.
  const auto fetch = [&](int c, int which) {
    Core& me = core[c];
    Loop& loop = loops[which];
    const bool is_again = loop.last < 0 || loop.last == c;
    const double done = std::max(me.now, loop.free_from) + (is_again ? costs.dispatch.again : costs.dispatch.moved);
    spent.dispatch += done - me.now;
    me.now = loop.free_from = done;
    loop.last = c;
    const bool has_chunk = loop.next < region.chunks[which].size();
    me.loop = has_chunk ? which : -1;
    me.events = has_chunk ? &region.chunks[which][loop.next++] : &region.members[c];
    me.next = has_chunk ? 0 : me.behind;
    turns.push({me.now, c});
  };

  // Core c awaits what was posted at `time`.
  const auto see = [&](int c, double time) {
    const double seen = std::max(core[c].now + costs.flag.read, time + costs.flag.seen);
    spent.waiting += seen - core[c].now;
    core[c].now = seen;
    turns.push({seen, c});
  };

  while (!turns.empty()) {
    const int c = turns.top().second;
    turns.pop();
    Core& me = core[c];
    if (me.next == me.events->size()) {
      if (me.loop >= 0) fetch(c, me.loop);
      continue;
    }
    const Event& event = (*me.events)[me.next++];
    switch (event.kind) {
      case Event::work:
        me.now += event.ns;
        spent.work += event.ns;
        turns.push({me.now, c});
        break;
      case Event::lock: {
        Lock& g = lock[event.what];
        if (g.holder < 0)
          take(g, c);
        else
          g.queue.push_back(c);
        break;
      }
      case Event::unlock: {
        Lock& g = lock[event.what];
        g.holder = -1;
        turns.push({me.now, c});
        if (!g.queue.empty()) {
          const int first = g.queue.front();
          g.queue.erase(g.queue.begin());
          spent.locks += me.now - core[first].now;
          core[first].now = me.now;
          take(g, first);
        }
        break;
      }
      case Event::dispatch:
        me.behind = me.next;
        fetch(c, event.value);
        break;
      case Event::single: turns.push({me.now, c}); break;
      case Event::post: {
        Flag& f = flag[event.what];
        f.posts.push_back({event.value, me.now});
        const auto has_come = [&](const auto& waiting) { return waiting.first <= event.value; };
        for (const auto& waiting : f.waiting)
          if (has_come(waiting)) see(waiting.second, me.now);
        std::erase_if(f.waiting, has_come);
        turns.push({me.now, c});
        break;
      }
      case Event::await: {
        Flag& f = flag[event.what];
        if (const auto post = f.post_of(event.value); post != f.posts.end())
          see(c, post->second);
        else
          f.waiting.push_back({event.value, c});
        break;
      }
      case Event::barrier: {
        at_barrier.push_back(c);
        if (static_cast<int>(at_barrier.size()) < cores) break;
        const double opened = me.now;
        double waker = 0;
        for (const int other : at_barrier) {
          const double waits = opened - core[other].now;
          const Waking::Late late = costs.waking.after(waits);
          spent.waiting += waits + late.waiting;
          spent.together += costs.barrier.at(cores);
          core[other].now = opened + costs.barrier.at(cores) + late.waiting;
          waker = std::max(waker, late.waker);
        }
        me.now += waker;
        spent.waiting += waker;
        for (const int any : at_barrier) turns.push({core[any].now, any});
        at_barrier.clear();
        break;
      }
    }
  }

  // The core that ends last may wake the first one. What that costs it is not counted: it has nothing more to do here.
  double end = std::ranges::max_element(core, {}, &Core::now)->now;
  end += costs.waking.after(end - core[0].now).waiting;
  for (int c = 0; c < cores; ++c) {
    waited[c] = end - core[c].now;
    spent.waiting += waited[c];
  }
  return end;
}

}  // namespace

Replayed replay(const Record& record, const Costs& costs, double bytes) {
  Replayed spent;
  const int cores = record.cores;
  for (const double ns : record.serial_ns) {
    spent.total += ns;
    spent.work += ns;
    spent.serial += (cores - 1) * ns;
  }
  std::vector<double> waited(cores, 0.);
  for (std::size_t r = 0; r < record.regions.size(); ++r) {
    for (double& ns : waited) ns += record.serial_ns[r];
    spent.total += costs.fork_join.at(cores) + replay_region(record.regions[r], costs, waited, spent);
    spent.together += cores * costs.fork_join.at(cores);
  }
  spent.compute = spent.total;
  if (costs.bytes_per_ns > 0) spent.total = std::max(spent.total, bytes / costs.bytes_per_ns);
  return spent;
}

}  // namespace lockstep::verify
