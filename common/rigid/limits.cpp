#include "common/rigid/limits.h"

#include <cstdint>
#include <cstdio>
#include <string>

#include "common/memory.h"
#include "common/rigid/contact_constraint.h"
#include "common/rigid/contact_solver.h"
#include "common/rigid/manifold.h"
#include "common/rigid/pairs.h"

namespace lockstep::rigid {

double bytes_per_pair() {
  return 5 * sizeof(Pair) + sizeof(std::int32_t) + 3 * sizeof(Manifold<float>) + 2 * sizeof(Impulses<float>) +
         sizeof(ContactConstraint<float>) + 2 * sizeof(std::int32_t);
}

void require_contacts_fit(double pairs, double room) {
  constexpr double surely_fits = 1e8;  // bytes: asking the system takes longer than finding so few pairs
  const double bytes = bytes_per_pair() * pairs;
  if (pairs <= room || bytes < surely_fits) return;
  char text[64];
  std::snprintf(text, sizeof text, "%.10g", pairs);
  require_memory(bytes, "a crowd of " + std::string(text) + " pairs of colliders whose boxes overlap");
}

}  // namespace lockstep::rigid
