// The forces of a strained body on its nodes.
//
// The algorithm and its serial form stand in serial/production_face/forces.cpp. Sixteen tetrahedra, a block, at once;
// threads share the blocks. Tetrahedra that share a node would write to it together. So they store their parts first,
// and each node adds up its own (corner_parts.h): the serial bits. Or a thread adds each part under the node's lock,
// as [ITJ07]'s does: the parts of a node then come in any order.
//
// The contract stands in common/production_face/forces.h.
#include "common/production_face/forces.h"

#include <algorithm>

#include "common/real.h"
#include "openmp/production_face/corner_parts.h"
#include "openmp/share.h"

namespace lockstep::production_face::openmp {
namespace {

Parts<floatv> forces_of(const Body<Real>& body, const Strained<Real>& strained, int block) {
  const auto field = [&](const Blocked<Real>& array, int k) { return load(array.vector(block, k)); };
  return element_forces<floatv>(body, strained, field);
}

}  // namespace

void forces(const Body<Real>& body, const Strained<Real>& strained, const Waves& waves, Array<Real>& parts,
            std::span<Real> force) {
  const auto parts_of = [&](int block) { return forces_of(body, strained, block); };
  add_up_parts(body, waves, parts_of, parts, force);
}

void forces_locks(const Body<Real>& body, const Strained<Real>& strained, std::span<Real> force) {
  std::ranges::fill(force, Real(0));
  lockstep::openmp::Locks locks(body.nodes);
  // A node is written under its lock.
#pragma omp parallel for schedule(static)
  for (int block = 0; block < body.blocks(); ++block) {
    Real part[lanes * lanes];
    store_parts(forces_of(body, strained, block), part);
    const int last = std::min((block + 1) * lanes, body.tetrahedra);
    for (int tetrahedron = block * lanes; tetrahedron < last; ++tetrahedron)
      for (int a = 0; a < 4; ++a) {
        const int node = body.corner.at(tetrahedron, a);
        const Real* const of = part + 4 * (4 * (tetrahedron % lanes) + a);
        const lockstep::openmp::Guard guard(locks, node);
        add_to_node(force, node, {of[0], of[1], of[2]});
      }
  }
}

}  // namespace lockstep::production_face::openmp
