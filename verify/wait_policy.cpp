#include "verify/wait_policy.h"

#include <unistd.h>

#include <cstdlib>

namespace lockstep::verify {

void wait_calmly(char** argv) {
  constexpr char turns[] = "1000";
  if (std::getenv("GOMP_SPINCOUNT") || std::getenv("OMP_WAIT_POLICY")) return;
  if (setenv("GOMP_SPINCOUNT", turns, 0) == 0) execv("/proc/self/exe", argv);
}

}  // namespace lockstep::verify
