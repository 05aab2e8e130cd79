// Continues the liquid's velocity into the air.
//
// For each component, the faces near the liquid that are not known are sorted by their distance from it, and visited in
// that order, as in fast marching: when it is a face's turn, every nearer face has had its own. A face takes a mean of
// its nearer neighbours.
//
// The contract stands in common/production_fluid/extrapolate.h.
#include "common/production_fluid/extrapolate.h"

#include <algorithm>
#include <vector>

#include "common/levelset/field.h"
#include "common/real.h"

namespace lockstep::production_fluid::serial {
namespace {

using levelset::far;

struct Face {
  Real distance;
  int x, y, z;
};

// Returns the distances of known faces, `far` elsewhere. Lists the faces that may become known, and sets the velocity
// of those too far away to 0.
Field<Real> find_known(const Fluid<Real>& fluid, const Lines<Real>& lines, int axis, Real distance,
                       Field<Real>& velocity, std::vector<Face>& unknown) {
  Field<Real> known = levelset::make_field<Real>(velocity.nx, velocity.ny, velocity.nz, velocity.spacing, far<Real>);
  for (int z = 0; z < velocity.nz; ++z)
    for (int y = 0; y < velocity.ny; ++y) {
      const auto [a, b] = beside(fluid, lines, axis, y, z);
      for (int x = 0; x < velocity.nx; ++x) {
        const Real of_face = distance_of_face(a.phi[x], a.solid[x], b.phi[x], b.solid[x]);
        if (is_known(a.phi[x], a.solid[x], b.phi[x], b.solid[x]))
          known(x, y, z) = of_face;
        else if (of_face <= distance)
          unknown.push_back({of_face, x, y, z});
        else
          velocity(x, y, z) = 0;
      }
    }
  return known;
}

void continue_component(const Fluid<Real>& fluid, const Lines<Real>& lines, int axis, Real distance,
                        Field<Real>& velocity) {
  std::vector<Face> unknown;
  Field<Real> known = find_known(fluid, lines, axis, distance, velocity, unknown);
  std::ranges::stable_sort(unknown, {}, &Face::distance);
  for (const auto& [of_face, x, y, z] : unknown) {
    const auto neighbour = [&](int x, int y, int z) -> Neighbour<Real> {
      if (y < 0 || y >= velocity.ny || z < 0 || z >= velocity.nz) return {far<Real>, 0};
      return {known(x, y, z), velocity(x, y, z)};  // known is far in the padding, too
    };
    Continued<Real> face;
    add_axis(of_face, neighbour(x - 1, y, z), neighbour(x + 1, y, z), face);
    add_axis(of_face, neighbour(x, y - 1, z), neighbour(x, y + 1, z), face);
    add_axis(of_face, neighbour(x, y, z - 1), neighbour(x, y, z + 1), face);
    velocity(x, y, z) = face.velocity;  // 0 where no axis counts
    if (face.weight > 0) known(x, y, z) = of_face;
  }
}

}  // namespace

void extrapolate(const Fluid<Real>& fluid, Real distance, Faces<Real>& faces) {
  const Lines<Real> lines(fluid);
  continue_component(fluid, lines, 0, distance, faces.u);
  continue_component(fluid, lines, 1, distance, faces.v);
  continue_component(fluid, lines, 2, distance, faces.w);
}

}  // namespace lockstep::production_fluid::serial
