// Particles are pushed out of solid bodies, with friction.
//
// A body says of a point how deep it is inside and which way is out; all else is the same for all bodies. Since velocity is what
// a particle has moved in the last step, moving it is all that collision has to do: pushing it out stops it, and taking
// back what it slid is friction.
//
// Source: [Jakobsen 2001] sections 3 and 6. The contract stands in common/cloth/collide.h.
#include "common/cloth/collide.h"

#include "common/math.h"
#include "common/real.h"

namespace lockstep::cloth::serial {
namespace {

// The nearest way out of a body for a point: how far it is, positive where the point is inside, and a direction of length 1.
struct WayOut {
  Real depth, x, y, z;
};

WayOut way_out(const Plane<Real>& plane, Real x, Real y, Real z) {
  const auto [nx, ny, nz] = plane.normal;
  return {plane.offset - (nx * x + ny * y + nz * z), nx, ny, nz};
}

WayOut way_out(const Capsule<Real>& capsule, Real x, Real y, Real z) {
  const Real lx = capsule.to.x - capsule.from.x, ly = capsule.to.y - capsule.from.y, lz = capsule.to.z - capsule.from.z;
  const Real l2 = lx * lx + ly * ly + lz * lz;
  const Real per_l2 = l2 > 0 ? 1 / l2 : Real(0);
  // From the nearest point of the capsule's axis to the particle.
  const Real fx = x - capsule.from.x, fy = y - capsule.from.y, fz = z - capsule.from.z;
  const Real along = min(max((fx * lx + fy * ly + fz * lz) * per_l2, Real(0)), Real(1));
  const Real dx = fx - along * lx, dy = fy - along * ly, dz = fz - along * lz;
  const Real d = sqrt(dx * dx + dy * dy + dz * dz);
  // On the axis every way is as good; up is one.
  const Real per_d = select(d > 0, 1 / d, Real(0));
  return {capsule.radius - d, dx * per_d, select(d > 0, dy * per_d, Real(1)), dz * per_d};
}

WayOut way_out(const Box<Real>& box, Real x, Real y, Real z) {
  const Real dx = x - box.centre.x, dy = y - box.centre.y, dz = z - box.centre.z;
  const auto& [u, v, w] = box.axis;
  const Real along_u = dx * u.x + dy * u.y + dz * u.z, along_v = dx * v.x + dy * v.y + dz * v.z, along_w = dx * w.x + dy * w.y + dz * w.z;
  // Inside, the nearest face is the way out; outside, one of the depths is negative, and so is the least.
  const Real depth_u = box.half.x - abs(along_u), depth_v = box.half.y - abs(along_v), depth_w = box.half.z - abs(along_w);
  const Real depth = min(depth_u, min(depth_v, depth_w));
  const Real sign_u = select(along_u < 0, Real(-1), Real(1)), sign_v = select(along_v < 0, Real(-1), Real(1)),
             sign_w = select(along_w < 0, Real(-1), Real(1));
  const bool by_u = depth == depth_u, by_v = depth == depth_v;
  return {depth,  //
          select(by_u, sign_u * u.x, select(by_v, sign_v * v.x, sign_w * w.x)),
          select(by_u, sign_u * u.y, select(by_v, sign_v * v.y, sign_w * w.y)),
          select(by_u, sign_u * u.z, select(by_v, sign_v * v.z, sign_w * w.z))};
}

// Pushes particle i out of the body and says whether it was inside.
template <class Body>
bool push_out(const Body& body, Real friction, Cloth<Real>& cloth, int i) {
  Vectors<Real>&p = cloth.position, &q = cloth.previous;
  const auto [depth, nx, ny, nz] = way_out(body, p.x[i], p.y[i], p.z[i]);
  if (!(depth > 0)) return false;
  const Real x = p.x[i] + depth * nx, y = p.y[i] + depth * ny, z = p.z[i] + depth * nz;
  const Real mx = x - q.x[i], my = y - q.y[i], mz = z - q.z[i];
  const Real m = mx * nx + my * ny + mz * nz;
  const Real sx = mx - m * nx, sy = my - m * ny, sz = mz - m * nz;  // what it slid
  const Real slid = sqrt(sx * sx + sy * sy + sz * sz), most = friction * depth;
  const Real back = select(slid > most, most / slid, Real(1));
  p.x[i] = x - back * sx, p.y[i] = y - back * sy, p.z[i] = z - back * sz;
  return true;
}

}  // namespace

void collide(Cloth<Real>& cloth) {
  const auto& [planes, capsules, boxes, friction] = cloth.bodies;
  for (int i = 0; i < cloth.count; ++i) {
    if (cloth.inverse_mass[i] == 0) continue;
    bool was_inside = true;
    for (int round = 0; round < most_rounds && was_inside; ++round) {
      was_inside = false;
      for (const Plane<Real>& plane : planes) was_inside |= push_out(plane, friction, cloth, i);
      for (const Capsule<Real>& capsule : capsules) was_inside |= push_out(capsule, friction, cloth, i);
      for (const Box<Real>& box : boxes) was_inside |= push_out(box, friction, cloth, i);
    }
  }
}

}  // namespace lockstep::cloth::serial
