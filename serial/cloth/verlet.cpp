// Verlet integration under gravity, wind and drag.
//
// Velocity is not stored: it is what a particle has moved since the step before. Constraints then only need to move positions, and
// velocities follow. Wind pushes triangles, which have a side to push on; then every particle collects a third of the force
// on each triangle that it is a corner of.
//
// Source: [Jakobsen 2001] section 2. The contract stands in common/cloth/verlet.h.
#include "common/cloth/verlet.h"

#include "common/math.h"
#include "common/real.h"

namespace lockstep::cloth::serial {
namespace {

// The force of the air on every triangle.
void blow(Cloth<Real>& cloth) {
  const Vectors<Real>&p = cloth.position, &q = cloth.previous;
  const Model<Real>& model = cloth.model;
  const Real per_corner_and_second = 1 / (3 * model.time_step), quarter_drag = model.drag / 4;
  const int triangles = static_cast<int>(cloth.triangles.size());
  for (int t = 0; t < triangles; ++t) {
    const auto [a, b, c] = cloth.triangles[t];
    const Real abx = p.x[b] - p.x[a], aby = p.y[b] - p.y[a], abz = p.z[b] - p.z[a];
    const Real acx = p.x[c] - p.x[a], acy = p.y[c] - p.y[a], acz = p.z[c] - p.z[a];
    const Real nx = aby * acz - abz * acy, ny = abz * acx - abx * acz, nz = abx * acy - aby * acx;
    const Real ux = model.wind.x - (p.x[a] - q.x[a] + (p.x[b] - q.x[b]) + (p.x[c] - q.x[c])) * per_corner_and_second;
    const Real uy = model.wind.y - (p.y[a] - q.y[a] + (p.y[b] - q.y[b]) + (p.y[c] - q.y[c])) * per_corner_and_second;
    const Real uz = model.wind.z - (p.z[a] - q.z[a] + (p.z[b] - q.z[b]) + (p.z[c] - q.z[c])) * per_corner_and_second;
    const Real n2 = nx * nx + ny * ny + nz * nz;
    const Real un = ux * nx + uy * ny + uz * nz;
    const Real s = select(n2 > 0, quarter_drag * abs(un) * un / n2, Real(0));
    cloth.force.x[t] = s * nx, cloth.force.y[t] = s * ny, cloth.force.z[t] = s * nz;
  }
}

}  // namespace

void verlet(Cloth<Real>& cloth) {
  Vectors<Real>&p = cloth.position, &q = cloth.previous;
  const Vectors<Real>& force = cloth.force;
  const Model<Real>& model = cloth.model;
  const Real dt2 = model.time_step * model.time_step;
  if (model.drag > 0) blow(cloth);
  for (int i = 0; i < cloth.count; ++i) {
    const Real w = cloth.inverse_mass[i];
    Real fx = 0, fy = 0, fz = 0;
    if (model.drag > 0)
      for (int k = cloth.corner_begin[i]; k < cloth.corner_begin[i + 1]; ++k) {
        const int t = cloth.corner[k];
        fx += force.x[t], fy += force.y[t], fz += force.z[t];
      }
    const Real third_w = w * Real(1. / 3);
    const Real ax = model.gravity.x + fx * third_w, ay = model.gravity.y + fy * third_w, az = model.gravity.z + fz * third_w;
    const Real next_x = p.x[i] + (p.x[i] - q.x[i]) * model.kept_velocity + ax * dt2;
    const Real next_y = p.y[i] + (p.y[i] - q.y[i]) * model.kept_velocity + ay * dt2;
    const Real next_z = p.z[i] + (p.z[i] - q.z[i]) * model.kept_velocity + az * dt2;
    q.x[i] = p.x[i], q.y[i] = p.y[i], q.z[i] = p.z[i];
    if (w > 0) p.x[i] = next_x, p.y[i] = next_y, p.z[i] = next_z;
  }
}

}  // namespace lockstep::cloth::serial
