// Finds the impulses of the last step for the contacts of this one, by merging two lists in the same order.
//
// The contract stands in common/rigid/match_contacts.h.
#include "common/rigid/match_contacts.h"

#include "common/real.h"

namespace lockstep::rigid::serial {

void match_contacts(std::span<const Manifold<Real>> last, std::span<const Impulses<Real>> last_impulses,
                    std::span<const Manifold<Real>> manifolds, std::span<Impulses<Real>> impulses) {
  std::size_t j = 0;
  for (std::size_t k = 0; k < manifolds.size(); ++k) {
    while (j < last.size() && pair_of(last[j]) < pair_of(manifolds[k])) ++j;
    const bool same = j < last.size() && pair_of(last[j]) == pair_of(manifolds[k]);
    impulses[k] = same ? matched(last[j], last_impulses[j], manifolds[k]) : Impulses<Real>{};
  }
}

}  // namespace lockstep::rigid::serial
