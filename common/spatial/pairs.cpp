#include "common/spatial/pairs.h"

#include <cstdio>
#include <string>

#include "common/input_error.h"
#include "common/memory.h"

namespace lockstep::spatial {

void require_pairs_fit(double pairs, double room) {
  constexpr double surely_fits = 1e7;  // bytes: to ask the system takes longer than to find so few pairs
  const double bytes = sizeof(Pair) * pairs;
  if (pairs <= room || bytes < surely_fits) return;
  char text[64];
  std::snprintf(text, sizeof text, "%.10g", pairs);
  const std::string what = "room for " + std::string(text) + " pairs of boxes that overlap";
  if (pairs > max_pairs) throw InputError(what + ": expected at most " + std::to_string(static_cast<int>(max_pairs)));
  require_memory(bytes, what);
}

}  // namespace lockstep::spatial
