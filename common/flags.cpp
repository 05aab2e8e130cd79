#include "common/flags.h"

#include <sched.h>

namespace lockstep {

void lockstep_post(Flag* flag, int value) { flag->value.store(value, std::memory_order_release); }

void lockstep_await(const Flag* flag, int value) {
  // After so many turns (a choice, not measured against others) the thread gives its core to others. There may be more
  // threads than cores, and the one that must post may have none.
  constexpr int turns = 50;
  for (int turn = 0; flag->value.load(std::memory_order_acquire) < value; ++turn) {
    if (turn >= turns) {
      sched_yield();
      continue;
    }
#if defined(__x86_64__)
    __builtin_ia32_pause();
#endif
  }
}

}  // namespace lockstep
