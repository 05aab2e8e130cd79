// Puts contacts into batches without conflicts.
//
// Which batch a contact joins depends on every earlier contact at its bodies, and so on: a chain through the whole
// pile. `batches` and `batches_folded` read and order contacts in parallel and choose in sequence. `batches_parallel`
// makes the choice in parallel, too (openmp/batches.h). Its slabs lie across x, because piles are numbered layer by
// layer upwards, and chains climb with the numbers. Costs, and where it would pay: notes/batches.md.
//
// Source: [LRB08] Figure 13. The contract stands in common/rigid/batches.h, the rule in common/batches.cpp.
#include "common/rigid/batches.h"

#include "common/real.h"
#include "openmp/batches.h"
#include "openmp/spatial/radix_sort.h"

namespace lockstep::rigid::openmp {
namespace {

using lockstep::openmp::make_batches, lockstep::openmp::make_folded_levels;

struct Constraints {
  std::vector<std::int32_t> a, b;  // bodies
  std::vector<char> movable;       // [body]
};

// The calling thread's own, kept from call to call (openmp/spatial/workspace.h says why).
const Constraints& constraints_of(std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                                  const Bodies<Real>& bodies) {
  const int contacts = static_cast<int>(manifolds.size());
  thread_local Constraints kept;
  Constraints& mine = kept;  // the team's threads would each see their own `kept`
  std::vector<std::int32_t>&a = mine.a, &b = mine.b;
  std::vector<char>& movable = mine.movable;
  a.resize(contacts), b.resize(contacts), movable.resize(bodies.count);
#pragma omp parallel
  {
    // Each contact belongs to one thread, and each body.
#pragma omp for schedule(static) nowait
    for (int k = 0; k < contacts; ++k) {
      a[k] = body[manifolds[k].a];
      b[k] = body[manifolds[k].b];
    }
#pragma omp for schedule(static)
    for (int i = 0; i < bodies.count; ++i) movable[i] = bodies.inverse_mass[i].w > 0;
  }
  return mine;
}

}  // namespace

Batches batches(std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                const Bodies<Real>& bodies) {
  const auto& [a, b, movable] = constraints_of(manifolds, body, bodies);
  return make_batches(a, b, movable);
}

Batches batches_folded(std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                       const Bodies<Real>& bodies) {
  const auto& [a, b, movable] = constraints_of(manifolds, body, bodies);
  return make_folded_levels(a, b, movable);
}

Batches batches_parallel(std::span<const Manifold<Real>> manifolds, std::span<const std::int32_t> body,
                         const Bodies<Real>& bodies) {
  const auto& [a, b, movable] = constraints_of(manifolds, body, bodies);
  return lockstep::openmp::make_batches_in_parallel(a, b, movable, [&](int i) {
    return static_cast<std::uint32_t>(spatial::openmp::key_of(bodies.pose[i].position.x));
  });
}

}  // namespace lockstep::rigid::openmp
