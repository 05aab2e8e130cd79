// Puts contacts into batches without conflicts.
//
// The rule is first fit, a greedy graph colouring. It looks at each contact once. Piles of bodies that touch d others
// need at most 2 d - 1 batches. Early batches are full, late ones small.
//
// `batches_folded` keeps more of the original order: it goes round a ring of batches, so that a contact comes after
// those before it at its bodies wherever a chain of contacts is shorter than the ring.
//
// Source: [LRB08] Figure 13. The contract stands in common/rigid/batches.h, the rule in common/batches.cpp.
#include "common/rigid/batches.h"

#include "common/real.h"

namespace lockstep::rigid::serial {
namespace {

struct Constraints {
  std::vector<std::int32_t> a, b;  // bodies
  std::vector<char> movable;       // [body]
};

Constraints constraints_of(std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                           const Bodies<Real>& bodies) {
  const int contacts = static_cast<int>(manifolds.size());
  Constraints mine;
  std::vector<std::int32_t>&a = mine.a, &b = mine.b;
  std::vector<char>& movable = mine.movable;
  a.resize(contacts), b.resize(contacts), movable.resize(bodies.count);
  for (int k = 0; k < contacts; ++k) {
    a[k] = body[manifolds[k].a];
    b[k] = body[manifolds[k].b];
  }
  for (int i = 0; i < bodies.count; ++i) movable[i] = bodies.inverse_mass[i].w > 0;
  return mine;
}

}  // namespace

Batches batches(std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                const Bodies<Real>& bodies) {
  const auto [a, b, movable] = constraints_of(manifolds, body, bodies);
  return make_batches(a, b, movable);
}

Batches batches_folded(std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                       const Bodies<Real>& bodies) {
  const auto [a, b, movable] = constraints_of(manifolds, body, bodies);
  return make_folded_levels(a, b, movable);
}

}  // namespace lockstep::rigid::serial
