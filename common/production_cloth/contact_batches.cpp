#include "common/production_cloth/contact_batches.h"

#include <bit>
#include <cstdint>

namespace lockstep::production_cloth {

template <class Real>
Batches make_contact_batches(const Contacts<Real>& contacts, const Array<Real>& inverse_mass) {
  constexpr int most = 64;
  const int count = static_cast<int>(contacts.count);
  Array<std::uint64_t> taken(inverse_mass.size());  // [vertex]: a bit a batch
  std::vector<std::uint8_t> batch_of(count);        // `most`: none
  std::int32_t size[most + 1] = {};
  for (int k = 0; k < count; ++k) {
    const std::int32_t* const corner = &contacts.corner[4 * static_cast<std::size_t>(k)];
    std::uint64_t all = 0;
    for (int i = 0; i < 4; ++i)
      if (inverse_mass[corner[i]] > 0) all |= taken[corner[i]];
    const int batch = std::countr_one(all);
    batch_of[k] = static_cast<std::uint8_t>(batch);
    ++size[batch];
    if (batch < most)
      for (int i = 0; i < 4; ++i) taken[corner[i]] |= std::uint64_t(1) << batch;
  }

  Batches batches;
  batches.begin = {0};
  std::int32_t next[most + 1] = {};
  for (int batch = 0; batch < most; ++batch) {
    next[batch + 1] = next[batch] + size[batch];
    if (size[batch] > 0) batches.begin.push_back(next[batch + 1]);
  }
  for (int k = next[most]; k < count; ++k) batches.begin.push_back(k + 1);
  batches.order.resize(count);
  for (int k = 0; k < count; ++k) batches.order[next[batch_of[k]]++] = k;
  return batches;
}

template Batches make_contact_batches(const Contacts<float>&, const Array<float>&);
template Batches make_contact_batches(const Contacts<double>&, const Array<double>&);

}  // namespace lockstep::production_cloth
