// Relaxation: every constraint is projected in turn, iteration after iteration. Gauss-Seidel, without a matrix.
//
// Projecting one constraint disturbs its neighbours; iterations spread the error until it is gone. The order is free.
// The original order goes through the sheet as one reads, particle by particle: each constraint sees all corrections
// before it. The papers' passes take all constraints of one direction at a time, so that many are independent: down the
// columns, along the rows, along the diagonals. In colours, neighbours along a line come in different halves of a pass,
// and no two constraints of a half share a particle. Batches do the same for constraints without a pattern.
//
// Source: [Jakobsen 2001] section 3; [LRB08] Figure 11. The contract stands in common/cloth/relax.h.
#include "common/cloth/relax.h"

#include <algorithm>

#include "common/cloth/project.h"
#include "common/real.h"

namespace lockstep::cloth::serial {
namespace {

Point<Real> read(const Cloth<Real>& cloth, int i) {
  return {cloth.position.x[i], cloth.position.y[i], cloth.position.z[i], cloth.inverse_mass[i]};
}

void write(Cloth<Real>& cloth, int i, const Point<Real>& p) {
  cloth.position.x[i] = p.x, cloth.position.y[i] = p.y, cloth.position.z[i] = p.z;
}

void enforce(Cloth<Real>& cloth, int i, int j, Real rest_2) {
  Point<Real> a = read(cloth, i), b = read(cloth, j);
  project(a, b, rest_2);
  write(cloth, i, a);
  write(cloth, j, b);
}

// The constraints of a family that begin in one row, at every column or, of a family along the row, at those of one
// colour.
void enforce_row(Cloth<Real>& cloth, const Family<Real>& family, int row, int colour) {
  const Sheet& sheet = cloth.sheet;
  const auto [down, right, rest_2] = family;
  for (int c = std::max(0, -right); c < sheet.columns - std::max(0, right); ++c)
    if (colour == every_colour || down > 0 || c / right % 2 == colour)
      enforce(cloth, sheet.index(row, c), sheet.index(row + down, c + right), rest_2);
}

// One pass, or the half of it that has one colour. A line is walked top to bottom or left to right.
void enforce_family(Cloth<Real>& cloth, const Family<Real>& family, int colour) {
  for (int r = 0; r + family.down < cloth.sheet.rows; ++r)
    if (colour == every_colour || family.down == 0 || r / family.down % 2 == colour)
      enforce_row(cloth, family, r, colour);
}

void enforce_list(Cloth<Real>& cloth, const Constraints<Real>& list) {
  for (int k = 0; k < list.count; ++k) enforce(cloth, list.a[k], list.b[k], list.rest_2[k]);
}

}  // namespace

void relax_original(Cloth<Real>& cloth, int iterations) {
  for (int iteration = 0; iteration < iterations; ++iteration) enforce_list(cloth, cloth.constraints);
}

void relax_chains(Cloth<Real>& cloth, int iterations) {
  for (int iteration = 0; iteration < iterations; ++iteration)
    for (const Family<Real>& family : cloth.families) enforce_family(cloth, family, every_colour);
}

void relax_colours(Cloth<Real>& cloth, int iterations) {
  for (int iteration = 0; iteration < iterations; ++iteration)
    for (const Family<Real>& family : cloth.families)
      for (const int colour : {0, 1}) enforce_family(cloth, family, colour);
}

void relax_batches(Cloth<Real>& cloth, int iterations) {
  for (int iteration = 0; iteration < iterations; ++iteration) enforce_list(cloth, cloth.batched);
}

}  // namespace lockstep::cloth::serial
