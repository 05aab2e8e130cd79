// Verlet integration under gravity, wind and drag.
//
// Velocity is not stored: it is what a particle has moved since the step before. Constraints then only need to move positions, and
// velocities follow. Wind pushes triangles, which have a side to push on; then every particle collects a third of the force
// on each triangle that it is a corner of.
//
// Sixteen triangles, then sixteen particles at once. On a sheet both are unit stride: the upper triangles of a row of squares have
// their corners side by side, the lower ones too, and a particle collects from six neighbours in two rows of squares. On a mesh
// corners are gathered. Particles collect in the order of their triangles, so the bits are those of serial/.
//
// Source: [Jakobsen 2001] section 2. The contract stands in common/cloth/verlet.h.
#include "common/cloth/verlet.h"

#include <algorithm>

#include "common/real.h"
#include "common/simd.h"

namespace lockstep::cloth::openmp {
namespace {

struct Lanes3 {
  floatv x, y, z;
};

// A corner: where it is, and what it has moved.
struct Corner {
  Lanes3 p, moved;
};

struct Particles {
  float *px, *py, *pz, *qx, *qy, *qz;
  const float* w;
};

Particles particles_of(Cloth<Real>& cloth) {
  Vectors<Real>&p = cloth.position, &q = cloth.previous;
  return {p.x.data(), p.y.data(), p.z.data(), q.x.data(), q.y.data(), q.z.data(), cloth.inverse_mass.data()};
}

LOCKSTEP_INLINE Corner corner(const Particles& s, int i) {
  const Lanes3 p = {load(s.px + i), load(s.py + i), load(s.pz + i)};
  return {p, {p.x - load(s.qx + i), p.y - load(s.qy + i), p.z - load(s.qz + i)}};
}
LOCKSTEP_INLINE Corner corner(const Particles& s, intv i) {
  const Lanes3 p = {gather(s.px, i), gather(s.py, i), gather(s.pz, i)};
  return {p, {p.x - gather(s.qx, i), p.y - gather(s.qy, i), p.z - gather(s.qz, i)}};
}

// The force of the air on sixteen triangles.
LOCKSTEP_INLINE Lanes3 blow(const Model<Real>& model, const Corner& a, const Corner& b, const Corner& c) {
  const Real per_corner_and_second = 1 / (3 * model.time_step), quarter_drag = model.drag / 4;
  const floatv abx = b.p.x - a.p.x, aby = b.p.y - a.p.y, abz = b.p.z - a.p.z;
  const floatv acx = c.p.x - a.p.x, acy = c.p.y - a.p.y, acz = c.p.z - a.p.z;
  const floatv nx = aby * acz - abz * acy, ny = abz * acx - abx * acz, nz = abx * acy - aby * acx;
  const floatv ux = model.wind.x - (a.moved.x + b.moved.x + c.moved.x) * per_corner_and_second;
  const floatv uy = model.wind.y - (a.moved.y + b.moved.y + c.moved.y) * per_corner_and_second;
  const floatv uz = model.wind.z - (a.moved.z + b.moved.z + c.moved.z) * per_corner_and_second;
  const floatv n2 = nx * nx + ny * ny + nz * nz;
  const floatv un = ux * nx + uy * ny + uz * nz;
  const floatv s = select(n2 > 0.f, quarter_drag * abs(un) * un / n2, 0.f);
  return {s * nx, s * ny, s * nz};
}

// Moves sixteen particles.
LOCKSTEP_INLINE void integrate(const Model<Real>& model, const Particles& s, int i, const Lanes3& force) {
  const Real dt2 = model.time_step * model.time_step;
  const auto [p, moved] = corner(s, i);
  const floatv w = load(s.w + i);
  const floatv third_w = w * Real(1. / 3);
  const floatv ax = model.gravity.x + force.x * third_w, ay = model.gravity.y + force.y * third_w, az = model.gravity.z + force.z * third_w;
  const floatv next_x = p.x + moved.x * model.kept_velocity + ax * dt2;
  const floatv next_y = p.y + moved.y * model.kept_velocity + ay * dt2;
  const floatv next_z = p.z + moved.z * model.kept_velocity + az * dt2;
  store(s.qx + i, p.x), store(s.qy + i, p.y), store(s.qz + i, p.z);
  const maskv moves = w > 0.f;
  store(s.px + i, select(moves, next_x, p.x)), store(s.py + i, select(moves, next_y, p.y)), store(s.pz + i, select(moves, next_z, p.z));
}

// Of a sheet, cloth.force holds the upper triangles of all squares and then the lower ones: that of square (r, c) at
// (r + 1) * (pitch + 16) + c + 16, so that the squares that are not there, above, below, to the left and to the right of the sheet, have
// places of their own, and are zero.
void verlet_sheet(Cloth<Real>& cloth) {
  const Model<Real> model = cloth.model;  // a copy of our own: stores cannot change it
  const int rows = cloth.sheet.rows, columns = cloth.sheet.columns, pitch = cloth.sheet.pitch;
  const int square_pitch = pitch + lanes, lower = (rows + 1) * square_pitch;
  const Particles s = particles_of(cloth);
  float *const fx = cloth.force.x.data(), *const fy = cloth.force.y.data(), *const fz = cloth.force.z.data();
  const auto square = [=](int r, int c) { return (r + 1) * square_pitch + c + lanes; };
  const auto store_force = [=](int i, const Lanes3& f) { store(fx + i, f.x), store(fy + i, f.y), store(fz + i, f.z); };
  const auto add_force = [=](Lanes3& sum, int i) { sum.x += load(fx + i), sum.y += load(fy + i), sum.z += load(fz + i); };

#pragma omp parallel
  {
    if (model.drag > 0) {
      // A row of squares writes its own forces alone; the loop's barrier ends it before any is collected.
#pragma omp for schedule(static)
      for (int r = -1; r < rows; ++r)
        for (int c = -lanes; c < columns; c += lanes) {
          Lanes3 up = {0.f, 0.f, 0.f}, low = up;
          if (r >= 0 && r < rows - 1 && c >= 0) {
            const int i = r * pitch + c;
            const Corner top_left = corner(s, i), top_right = corner(s, i + 1);
            const Corner bottom_left = corner(s, i + pitch), bottom_right = corner(s, i + pitch + 1);
            up = blow(model, top_left, top_right, bottom_left), low = blow(model, bottom_right, bottom_left, top_right);
            const maskv there = first_lanes(columns - 1 - c);
            for (floatv* f : {&up.x, &up.y, &up.z, &low.x, &low.y, &low.z}) *f = select(there, *f, 0.f);
          }
          store_force(square(r, c), up);
          store_force(lower + square(r, c), low);
        }
    }
    // A row of particles writes its own positions alone.
#pragma omp for schedule(static)
    for (int r = 0; r < rows; ++r)
      for (int c = 0; c < columns; c += lanes) {
        Lanes3 force = {0.f, 0.f, 0.f};
        if (model.drag > 0) {
          add_force(force, lower + square(r - 1, c - 1));
          add_force(force, square(r - 1, c)), add_force(force, lower + square(r - 1, c));
          add_force(force, square(r, c - 1)), add_force(force, lower + square(r, c - 1));
          add_force(force, square(r, c));
        }
        integrate(model, s, r * pitch + c, force);
      }
  }
}

void verlet_mesh(Cloth<Real>& cloth) {
  const Model<Real> model = cloth.model;
  const Particles s = particles_of(cloth);
  Vectors<Real>& force = cloth.force;
  const int triangles = static_cast<int>(cloth.triangles.size());
  const std::int32_t* const corners = triangles > 0 ? &cloth.triangles[0].a : nullptr;

#pragma omp parallel
  {
    if (model.drag > 0) {
      // Every triangle is one thread's; the loop's barrier ends it before any force is collected.
#pragma omp for schedule(static)
      for (int t = 0; t < triangles; t += lanes) {
        const maskv there = first_lanes(triangles - t);
        const intv first = (lane_index() + t) * 3;
        const intv a = gather(corners, first, there), b = gather(corners, first + 1, there), c = gather(corners, first + 2, there);
        const Lanes3 f = blow(model, corner(s, a), corner(s, b), corner(s, c));
        store(&force.x[t], f.x), store(&force.y[t], f.y), store(&force.z[t], f.z);
      }
    }
    // Every particle is one thread's.
#pragma omp for schedule(static)
    for (int i = 0; i < cloth.count; i += lanes) {
      float fx[lanes] = {}, fy[lanes] = {}, fz[lanes] = {};
      if (model.drag > 0)
        for (int l = 0; l < std::min(lanes, cloth.count - i); ++l)
          for (int k = cloth.corner_begin[i + l]; k < cloth.corner_begin[i + l + 1]; ++k) {
            const int t = cloth.corner[k];
            fx[l] += force.x[t], fy[l] += force.y[t], fz[l] += force.z[t];
          }
      integrate(model, s, i, {load(fx), load(fy), load(fz)});
    }
  }
}

}  // namespace

void verlet(Cloth<Real>& cloth) {
  if (cloth.sheet.rows > 0)
    verlet_sheet(cloth);
  else
    verlet_mesh(cloth);
}

}  // namespace lockstep::cloth::openmp
