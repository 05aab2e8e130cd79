// The stiffness matrix, tetrahedron by tetrahedron.
//
// The force of a node depends on the nodes of the tetrahedra around it alone. So each tetrahedron has a stiffness of
// its own, a 3x3 block for each two of its four corners, and the matrix is their sum: a block for each two nodes of a
// tetrahedron. Where the blocks stand has been found once (pattern.h), as poses do not change it. Where all nodes move
// alike no force changes, so that the diagonal is minus the sum of a row's other blocks.
//
// The contract stands in common/production_face/assemble.h.
#include "common/production_face/assemble.h"

#include <algorithm>

#include "common/real.h"

namespace lockstep::production_face::serial {
namespace {

ElementStiffness<Real> stiffness_of(const Body<Real>& body, const Strained<Real>& strained, int tetrahedron) {
  const auto field = [&](const Blocked<Real>& array, int k) { return array.at(tetrahedron, k); };
  const auto e = strained_element<Real>(body, strained, field);
  ElementStiffness<Real> k;
  set_flesh_stiffness(e, k);
  const int block = tetrahedron / lanes, lane = tetrahedron % lanes;
  for (int slot = body.first_fibre[block]; slot < body.first_fibre[block + 1]; ++slot) {
    const auto in_slot = [&](const Blocked<Real>& array, int k) { return array.at(slot * lanes + lane, k); };
    add_fibre_stiffness(e, strained_fibre<Real>(body, strained, in_slot), k);
  }
  set_first_corner(k);
  return k;
}

// The diagonal block of a row. Columns ascend.
void add_up_row(int row, linear::BlockRows<Real>& k) {
  Real left[9] = {}, right[9] = {}, diagonal[9];
  int own = 0;
  for (int place = k.begin[row]; place < k.begin[row + 1]; ++place) {
    if (k.column[place] == row) own = place;
    Real(&sum)[9] = k.column[place] < row ? left : right;
    for (int i = 0; i < 9; ++i) sum[i] += k.value[9 * static_cast<std::size_t>(place) + i];
  }
  set_diagonal(left, right, diagonal);
  std::ranges::copy(diagonal, &k.value[9 * static_cast<std::size_t>(own)]);
}

}  // namespace

void assemble(const Body<Real>& body, const Strained<Real>& strained, const Pattern& pattern,
              linear::BlockRows<Real>& k) {
  std::ranges::fill(k.value, Real(0));
  for (int tetrahedron = 0; tetrahedron < body.tetrahedra; ++tetrahedron) {
    const ElementStiffness<Real> e = stiffness_of(body, strained, tetrahedron);
    for (int a = 0; a < 4; ++a)
      for (int c = 0; c < 4; ++c) {
        const std::ptrdiff_t place = pattern.place[16 * static_cast<std::size_t>(tetrahedron) + 4 * a + c];
        if (a == c || place < 0) continue;
        for (int r = 0; r < 3; ++r)
          for (int s = 0; s < 3; ++s) k.value[9 * place + 3 * r + s] += e.at(a, c, r, s);
      }
  }
  for (int row = 0; row < k.rows; ++row)
    if (k.begin[row] < k.begin[row + 1]) add_up_row(row, k);
}

}  // namespace lockstep::production_face::serial
