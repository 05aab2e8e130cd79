// The stiffness matrix times a vector of the nodes, without the matrix.
//
// The algorithm and its serial form stand in serial/production_face/multiply.cpp. Sixteen tetrahedra, a block, at once
// store their parts, then each node adds up its own (corner_parts.h).
//
// The contract stands in common/production_face/multiply.h.
#include "common/production_face/multiply.h"

#include "common/real.h"
#include "openmp/production_face/corner_parts.h"

namespace lockstep::production_face::openmp {
namespace {

Moved<floatv> moved_corners(const Body<Real>& body, std::span<const Real> x, int block) {
  Vector3<floatv> corner[4];
  for (int a = 0; a < 4; ++a) {
    const intv at = load(body.corner.vector(block, a)) * intv(3);
    corner[a] = {gather(x.data(), at), gather(x.data() + 1, at), gather(x.data() + 2, at)};
  }
  return {{corner[1] - corner[0], corner[2] - corner[0], corner[3] - corner[0]}};
}

Parts<floatv> product_of(const Body<Real>& body, const Strained<Real>& strained, std::span<const Real> x, int block) {
  const auto field = [&](const Blocked<Real>& array, int k) { return load(array.vector(block, k)); };
  const auto e = strained_element<floatv>(body, strained, field);
  const Moved<floatv> moved = moved_corners(body, x, block);
  Parts<floatv> part;
  set_flesh_product(e, moved, part);
  for (int slot = body.first_fibre[block]; slot < body.first_fibre[block + 1]; ++slot) {
    const auto in_slot = [&](const Blocked<Real>& array, int k) { return load(array.vector(slot, k)); };
    add_fibre_product(e, strained_fibre<floatv>(body, strained, in_slot), moved, part);
  }
  set_first_corner(part);
  return part;
}

}  // namespace

void multiply_matrix_free(const Body<Real>& body, const Strained<Real>& strained, std::span<const Real> x,
                          const Waves& waves, Array<Real>& parts, std::span<Real> y) {
  const auto parts_of = [&](int block) { return product_of(body, strained, x, block); };
  add_up_parts(body, waves, parts_of, parts, y);
  clear_nodes(y, body.held);
}

}  // namespace lockstep::production_face::openmp
