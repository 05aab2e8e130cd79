#include "verify/busy.h"

#include <chrono>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>

namespace lockstep::verify {
namespace {

struct Ticks {
  double busy = 0, all = 0;  // of all cores since the system started
};

Ticks ticks() {
  std::ifstream stat("/proc/stat");
  std::string name;
  stat >> name;
  Ticks sum;
  double x;
  // user, nice, system, idle, iowait, irq, softirq, steal; guests' time is part of user's.
  for (int field = 0; field < 8 && stat >> x; ++field) {
    sum.all += x;
    if (field != 3 && field != 4) sum.busy += x;
  }
  return sum;
}

}  // namespace

double busy_cores() {
  const Ticks before = ticks();
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const Ticks after = ticks();
  if (after.all <= before.all) return 0;
  const unsigned cores = std::thread::hardware_concurrency();
  const double busy = cores * (after.busy - before.busy) / (after.all - before.all);
  if (busy >= .5)
    std::fprintf(stderr, "lockstep: other programs keep %.1f of %u cores busy: times will be disturbed\n", busy, cores);
  return busy;
}

}  // namespace lockstep::verify
