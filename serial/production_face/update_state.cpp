// What a pose makes of each tetrahedron.
//
// Every tetrahedron is strained alike in all of it, so one matrix F says how. Its singular values are how much it is
// stretched along three axes, and the flesh's stress acts along the same axes. Muscles pull along their fibres. All of
// it depends on the tetrahedron's own corners alone.
//
// The contract stands in common/production_face/update_state.h.
#include "common/production_face/update_state.h"

#include "common/real.h"

namespace lockstep::production_face::serial {
namespace {

Matrix3<Real> deformation_of(const Body<Real>& body, const Pose<Real>& pose, int tetrahedron) {
  Vector3<Real> u[4], gradient[3];
  for (int a = 0; a < 4; ++a) u[a] = load(pose.displacement, body.corner.at(tetrahedron, a));
  for (int a = 0; a < 3; ++a)
    gradient[a] = {body.gradient.at(tetrahedron, 3 * a), body.gradient.at(tetrahedron, 3 * a + 1),
                   body.gradient.at(tetrahedron, 3 * a + 2)};
  return deformation(u, gradient);
}

void store(Blocked<Real>& to, int tetrahedron, const Matrix3<Real>& m) {
  const Real values[] = {m.x.x, m.x.y, m.x.z, m.y.x, m.y.y, m.y.z, m.z.x, m.z.y, m.z.z};
  for (int k = 0; k < 9; ++k) to.at(tetrahedron, k) = values[k];
}

void store(Blocked<Real>& to, int tetrahedron, const StressDerivative<Real>& d) {
  const Real values[] = {d.xx,      d.yy,      d.zz,      d.xy,     d.yz,     d.zx,
                         d.alpha.x, d.alpha.y, d.alpha.z, d.beta.x, d.beta.y, d.beta.z};
  for (int k = 0; k < 12; ++k) to.at(tetrahedron, k) = values[k];
}

void make_definite(StressDerivative<Real>& d) {
  const ScaledBlock<Real> scaled = scaled_block(d);
  if (is_definite(scaled)) return;
  const auto [xx, yy, zz, xy, zx, yz] = definite_block(scaled);
  d = {xx, yy, zz, xy, yz, zx, d.alpha, d.beta};
}

// Adds what the fibres of a tetrahedron pull.
void add_fibres(const Body<Real>& body, const Pose<Real>& pose, const Matrix3<Real>& f, bool definite, int tetrahedron,
                Element<Real>& e, Strained<Real>& strained) {
  const int block = tetrahedron / lanes, lane = tetrahedron % lanes;
  for (int slot = body.first_fibre[block]; slot < body.first_fibre[block + 1]; ++slot) {
    const int place = slot * lanes + lane, muscle = body.muscle.at(place, 0);
    const Vector3<Real> w = {body.fibre.at(place, 0), body.fibre.at(place, 1), body.fibre.at(place, 2)};
    const Real activation = muscle >= 0 ? pose.activation[muscle] * body.fibre.at(place, 3) : 0;
    const Pull<Real> pull = add_pull(f, w, activation, body.fibre.at(place, 4), definite, e);
    const Real values[] = {pull.along.x, pull.along.y, pull.along.z, pull.per_stretch, pull.stiffness};
    for (int k = 0; k < 5; ++k) strained.pull.at(place, k) = values[k];
  }
}

}  // namespace

void update_state(const Body<Real>& body, const Flesh& flesh, const Pose<Real>& pose, bool definite,
                  Strained<Real>& strained) {
  for (int tetrahedron = 0; tetrahedron < body.padded_tetrahedra(); ++tetrahedron) {
    const Matrix3<Real> f = deformation_of(body, pose, tetrahedron);
    Element<Real> e = element(f, flesh);
    if (definite) make_pairs_definite(e.derivative), make_definite(e.derivative);
    add_fibres(body, pose, f, definite, tetrahedron, e, strained);
    store(strained.stress, tetrahedron, e.stress);
    store(strained.u, tetrahedron, e.strain.u), store(strained.v, tetrahedron, e.strain.v);
    store(strained.derivative, tetrahedron, e.derivative);
    strained.energy.at(tetrahedron, 0) = e.energy;
  }
}

}  // namespace lockstep::production_face::serial
