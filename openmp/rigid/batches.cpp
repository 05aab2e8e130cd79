// Contacts put into batches without conflicts.
//
// Which batch a contact joins depends on every earlier one at its bodies, and so on: a chain through the whole pile. Only reading the
// contacts is shared out (notes/batches.md: what choosing costs, and why it is not).
//
// Source: [LRB08] Figure 13. The contract stands in common/rigid/batches.h, the rule in common/batches.cpp.
#include "common/rigid/batches.h"

#include "common/real.h"

namespace lockstep::rigid::openmp {

Batches reorder_contacts(std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body, const Bodies<Real>& bodies) {
  const int contacts = static_cast<int>(manifolds.size());
  std::vector<std::int32_t> a(contacts), b(contacts);
  // Every contact is one thread's.
#pragma omp parallel for schedule(static)
  for (int k = 0; k < contacts; ++k) {
    a[k] = body[manifolds[k].a];
    b[k] = body[manifolds[k].b];
  }
  std::vector<char> movable(bodies.count);
  for (int i = 0; i < bodies.count; ++i) movable[i] = bodies.inverse_mass[i].w > 0;
  return make_batches(a, b, movable);
}

}  // namespace lockstep::rigid::openmp
