// Finds the impulses of the last step for the contacts of this one, by merging two lists in the same order.
//
// Each thread merges its share of this step's contacts. It finds its start in the last step's list by binary search.
//
// The contract stands in common/rigid/match_contacts.h.
#include "common/rigid/match_contacts.h"

#include <algorithm>

#include "common/real.h"
#include "openmp/share.h"

namespace lockstep::rigid::openmp {

void match_contacts(std::span<const Manifold<Real>> last, std::span<const Impulses<Real>> last_impulses,
                    std::span<const Manifold<Real>> manifolds, std::span<Impulses<Real>> impulses) {
  // Each contact of this step belongs to one thread.
#pragma omp parallel
  {
    const auto [begin, end] = lockstep::openmp::my_share(static_cast<int>(manifolds.size()));
    if (begin < end) {
      std::size_t j = std::ranges::lower_bound(last, pair_of(manifolds[begin]), {}, pair_of<Real>) - last.begin();
      for (int k = begin; k < end; ++k) {
        while (j < last.size() && pair_of(last[j]) < pair_of(manifolds[k])) ++j;
        const bool same = j < last.size() && pair_of(last[j]) == pair_of(manifolds[k]);
        impulses[k] = same ? matched(last[j], last_impulses[j], manifolds[k]) : Impulses<Real>{};
      }
    }
  }
}

}  // namespace lockstep::rigid::openmp
