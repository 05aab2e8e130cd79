// Particles are pushed out of solid bodies, with friction.
//
// A body says of a point how deep it is inside and which way is out; all else is the same for all bodies. Since velocity is what
// a particle has moved in the last step, moving it is all that collision has to do: pushing it out stops it, and taking
// back what it slid is friction.
//
// Sixteen particles at once. A lane stays active from round to round as long as its particle was inside something.
//
// Source: [Jakobsen 2001] sections 3 and 6. The contract stands in common/cloth/collide.h.
#include "common/cloth/collide.h"

#include "common/math.h"
#include "common/real.h"
#include "common/simd.h"

namespace lockstep::cloth::openmp {
namespace {

// The nearest way out of a body for points: how far it is, positive where a point is inside, and a direction of length 1.
struct WayOut {
  floatv depth, x, y, z;
};

LOCKSTEP_INLINE WayOut way_out(const Plane<Real>& plane, floatv x, floatv y, floatv z) {
  const auto [nx, ny, nz] = plane.normal;
  return {plane.offset - (nx * x + ny * y + nz * z), nx, ny, nz};
}

LOCKSTEP_INLINE WayOut way_out(const Capsule<Real>& capsule, floatv x, floatv y, floatv z) {
  const Real lx = capsule.to.x - capsule.from.x, ly = capsule.to.y - capsule.from.y, lz = capsule.to.z - capsule.from.z;
  const Real l2 = lx * lx + ly * ly + lz * lz;
  const Real per_l2 = l2 > 0 ? 1 / l2 : Real(0);
  // From the nearest point of the capsule's axis to the particle.
  const floatv fx = x - capsule.from.x, fy = y - capsule.from.y, fz = z - capsule.from.z;
  const floatv along = min(max((fx * lx + fy * ly + fz * lz) * per_l2, Real(0)), Real(1));
  const floatv dx = fx - along * lx, dy = fy - along * ly, dz = fz - along * lz;
  const floatv d = sqrt(dx * dx + dy * dy + dz * dz);
  // On the axis every way is as good; up is one.
  const floatv per_d = select(d > 0.f, 1.f / d, 0.f);
  return {capsule.radius - d, dx * per_d, select(d > 0.f, dy * per_d, 1.f), dz * per_d};
}

LOCKSTEP_INLINE WayOut way_out(const Box<Real>& box, floatv x, floatv y, floatv z) {
  const floatv dx = x - box.centre.x, dy = y - box.centre.y, dz = z - box.centre.z;
  const auto& [u, v, w] = box.axis;
  const floatv along_u = dx * u.x + dy * u.y + dz * u.z, along_v = dx * v.x + dy * v.y + dz * v.z, along_w = dx * w.x + dy * w.y + dz * w.z;
  // Inside, the nearest face is the way out; outside, one of the depths is negative, and so is the least.
  const floatv depth_u = box.half.x - abs(along_u), depth_v = box.half.y - abs(along_v), depth_w = box.half.z - abs(along_w);
  const floatv depth = min(depth_u, min(depth_v, depth_w));
  const floatv sign_u = select(along_u < 0.f, floatv(-1.f), floatv(1.f)), sign_v = select(along_v < 0.f, floatv(-1.f), floatv(1.f)),
               sign_w = select(along_w < 0.f, floatv(-1.f), floatv(1.f));
  const maskv by_u = depth == depth_u, by_v = depth == depth_v;
  return {depth,  //
          select(by_u, sign_u * u.x, select(by_v, sign_v * v.x, sign_w * w.x)),
          select(by_u, sign_u * u.y, select(by_v, sign_v * v.y, sign_w * w.y)),
          select(by_u, sign_u * u.z, select(by_v, sign_v * v.z, sign_w * w.z))};
}

struct Points {
  floatv x, y, z;
};

// Pushes the active ones of particles p out of the body and says which were inside. q is where they were when the step began.
template <class Body>
LOCKSTEP_INLINE maskv push_out(const Body& body, Real friction, Points& p, const Points& q, maskv active) {
  const auto [depth, nx, ny, nz] = way_out(body, p.x, p.y, p.z);
  const maskv inside = active & (depth > 0.f);
  if (none(inside)) return inside;
  const floatv x = p.x + depth * nx, y = p.y + depth * ny, z = p.z + depth * nz;
  const floatv mx = x - q.x, my = y - q.y, mz = z - q.z;
  const floatv m = mx * nx + my * ny + mz * nz;
  const floatv sx = mx - m * nx, sy = my - m * ny, sz = mz - m * nz;  // what it slid
  const floatv slid = sqrt(sx * sx + sy * sy + sz * sz), most = friction * depth;
  const floatv back = select(slid > most, most / slid, 1.f);
  where(inside, p.x) = x - back * sx, where(inside, p.y) = y - back * sy, where(inside, p.z) = z - back * sz;
  return inside;
}

}  // namespace

void collide(Cloth<Real>& cloth) {
  const auto& bodies = cloth.bodies;
  if (bodies.planes.empty() && bodies.capsules.empty() && bodies.boxes.empty()) return;
  Vectors<Real>&p = cloth.position, &q = cloth.previous;
  const Real friction = bodies.friction;

  // Every particle is one thread's.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < cloth.count; i += lanes) {
    Points at = {load(&p.x[i]), load(&p.y[i]), load(&p.z[i])};
    const Points before = {load(&q.x[i]), load(&q.y[i]), load(&q.z[i])};
    maskv was_inside = load(&cloth.inverse_mass[i]) > 0.f;
    for (int round = 0; round < most_rounds && any(was_inside); ++round) {
      const maskv active = was_inside;
      was_inside = first_lanes(0);
      for (const Plane<Real>& plane : bodies.planes) was_inside |= push_out(plane, friction, at, before, active);
      for (const Capsule<Real>& capsule : bodies.capsules) was_inside |= push_out(capsule, friction, at, before, active);
      for (const Box<Real>& box : bodies.boxes) was_inside |= push_out(box, friction, at, before, active);
    }
    store(&p.x[i], at.x), store(&p.y[i], at.y), store(&p.z[i], at.z);
  }
}

}  // namespace lockstep::cloth::openmp
