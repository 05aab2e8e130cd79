// The forces of a strained body on its nodes, tetrahedron by tetrahedron.
//
// A tetrahedron pulls at its four corners with what its stress does across its faces. A node feels the sum of what the
// tetrahedra around it do.
//
// The contract stands in common/production_face/forces.h.
#include "common/production_face/forces.h"

#include <algorithm>

#include "common/real.h"

namespace lockstep::production_face::serial {
namespace {

Parts<Real> forces_of(const Body<Real>& body, const Strained<Real>& strained, int tetrahedron) {
  const auto field = [&](const Blocked<Real>& array, int k) { return array.at(tetrahedron, k); };
  return element_forces<Real>(body, strained, field);
}

}  // namespace

void forces(const Body<Real>& body, const Strained<Real>& strained, std::span<Real> force) {
  std::ranges::fill(force, Real(0));
  for (int tetrahedron = 0; tetrahedron < body.tetrahedra; ++tetrahedron) {
    const Parts<Real> part = forces_of(body, strained, tetrahedron);
    for (int a = 0; a < 4; ++a) add_to_node(force, body.corner.at(tetrahedron, a), part.of[a]);
  }
}

}  // namespace lockstep::production_face::serial
