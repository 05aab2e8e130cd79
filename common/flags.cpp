#include "common/flags.h"

namespace lockstep {

void lockstep_post(Flag* flag, int value) {
  flag->value.store(value);
  wake(*flag);
}

void lockstep_await(const Flag* flag, int value) {
  wait(*flag, [value](int now) { return now >= value; });
}

}  // namespace lockstep
