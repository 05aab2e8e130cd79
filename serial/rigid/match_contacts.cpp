// The impulses of the last step, for the contacts of this one: a merge of two lists in the same order.
//
// The contract stands in common/rigid/match_contacts.h.
#include "common/rigid/match_contacts.h"

#include "common/real.h"

namespace lockstep::rigid::serial {
namespace {

Impulses<Real> matched(const Manifold<Real>& last, const Impulses<Real>& from, const Manifold<Real>& m) {
  Impulses<Real> impulses{};
  bool taken[most_points] = {}, matched[most_points] = {};
  const auto take = [&](int k, int j) {
    impulses.normal[k] = from.normal[j];
    impulses.tangent[k] = from.tangent[j];
    impulses.bitangent[k] = from.bitangent[j];
    taken[j] = matched[k] = true;
  };
  for (int k = 0; k < m.count; ++k)
    for (int j = 0; j < last.count; ++j)
      if (!taken[j] && last.feature[j] == m.feature[k] && !matched[k]) take(k, j);
  for (int k = 0; k < m.count; ++k) {
    if (matched[k]) continue;
    int nearest = -1;
    Real least = static_cast<Real>(same_place * same_place);
    for (int j = 0; j < last.count; ++j) {
      const Vector3<Real> off = m.point[k].position - last.point[j].position;
      if (!taken[j] && dot(off, off) < least) nearest = j, least = dot(off, off);
    }
    if (nearest >= 0) take(k, nearest);
  }
  return impulses;
}

}  // namespace

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
