// Verlet integration under gravity, wind and drag.
//
// Velocity is not stored: it is what a particle has moved since the step before. Constraints then only need to move
// positions, and velocities follow. Wind pushes triangles, which have a side to push on; then every particle collects a
// third of the force on each triangle that it is a corner of.
//
// Sixteen triangles, then sixteen particles at once. On a sheet both are unit stride: the upper triangles of a row of
// squares have their corners side by side, the lower ones too, and a particle collects from six neighbours in two rows
// of squares. On a mesh corners are gathered. Particles collect in the order of their triangles, so the bits are those
// of serial/.
//
// Source: [Jakobsen 2001] section 2. The contract stands in common/cloth/verlet.h, the formulas in common/cloth/aero.h.
#include "common/cloth/verlet.h"

#include <algorithm>

#include "common/cloth/aero.h"
#include "common/real.h"
#include "common/simd.h"
#include "openmp/vector_lanes.h"

namespace lockstep::cloth::openmp {
namespace {

using Pointers = Vector3<float*>;

// Index is int for sixteen particles side by side, or intv for any sixteen.
template <class Index>
LOCKSTEP_INLINE Particle<floatv> particle(const Pointers& p, const Pointers& q, Index i) {
  const Vector3<floatv> position = load(p, i);
  return {position, position - load(q, i)};
}

// Moves particles i, i + 1, ... i + 15.
LOCKSTEP_INLINE void move(const Model<Real>& model, const Pointers& p, const Pointers& q, const float* inverse_mass,
                          int i, const Vector3<floatv>& force) {
  const Vector3<floatv> position = load(p, i), moved = position - load(q, i);
  store(q, i, position);
  store(p, i, next_position(model, position, moved, load(inverse_mass + i), force));
}

// cloth.force holds the upper triangles of all squares and then the lower ones: that of square (r, c) at (r + 1) *
// (pitch + 16) + c + 16. The squares just outside of the sheet (above, below, left, right) thus have places of their
// own, and are zero.
void verlet_sheet(Cloth<Real>& cloth) {
  const Model<Real> model = cloth.model;  // a local copy: stores cannot change it
  const int rows = cloth.sheet.rows, columns = cloth.sheet.columns, pitch = cloth.sheet.pitch;
  const int square_pitch = pitch + lanes, lower = (rows + 1) * square_pitch;
  const Pointers p = pointers(cloth.position), q = pointers(cloth.previous), forces = pointers(cloth.force);
  const float* const inverse_mass = cloth.inverse_mass.data();
  const auto square = [=](int r, int c) { return (r + 1) * square_pitch + c + lanes; };

#pragma omp parallel
  {
    if (model.drag > 0) {
      // A row of squares writes its own forces alone; the barrier at the loop's end precedes all reads of forces.
#pragma omp for schedule(static)
      for (int r = -1; r < rows; ++r)
        for (int c = -lanes; c < columns; c += lanes) {
          const Vector3<floatv> none = {0.f, 0.f, 0.f};
          const int upper_place = square(r, c), lower_place = lower + upper_place;
          if (r < 0 || r >= rows - 1 || c < 0) {
            store(forces, upper_place, none), store(forces, lower_place, none);
            continue;
          }
          const int i = r * pitch + c;
          const maskv there = first_lanes(columns - 1 - c);
          const Particle<floatv> top_right = particle(p, q, i + 1), bottom_left = particle(p, q, i + pitch);
          store(forces, upper_place, select(there, air_force(model, particle(p, q, i), top_right, bottom_left), none));
          const Particle<floatv> bottom_right = particle(p, q, i + pitch + 1);
          store(forces, lower_place, select(there, air_force(model, bottom_right, bottom_left, top_right), none));
        }
    }
    // A row of particles writes its own positions alone.
#pragma omp for schedule(static)
    for (int r = 0; r < rows; ++r)
      for (int c = 0; c < columns; c += lanes) {
        Vector3<floatv> force = {0.f, 0.f, 0.f};
        const auto collect = [&](int triangle) { force = force + load(forces, triangle); };
        if (model.drag > 0) {
          collect(lower + square(r - 1, c - 1));
          collect(square(r - 1, c)), collect(lower + square(r - 1, c));
          collect(square(r, c - 1)), collect(lower + square(r, c - 1));
          collect(square(r, c));
        }
        move(model, p, q, inverse_mass, r * pitch + c, force);
      }
  }
}

void verlet_mesh(Cloth<Real>& cloth) {
  const Model<Real> model = cloth.model;
  const Pointers p = pointers(cloth.position), q = pointers(cloth.previous), forces = pointers(cloth.force);
  const float* const inverse_mass = cloth.inverse_mass.data();
  const int triangles = static_cast<int>(cloth.triangles.size());
  const std::int32_t* const corners = triangles > 0 ? &cloth.triangles[0].a : nullptr;

#pragma omp parallel
  {
    if (model.drag > 0) {
      // Every triangle is one thread's; the barrier at the loop's end precedes all reads of forces.
#pragma omp for schedule(static)
      for (int t = 0; t < triangles; t += lanes) {
        const maskv there = first_lanes(triangles - t);
        const intv first = (lane_index() + t) * 3;
        const intv a = gather(corners, first, there), b = gather(corners, first + 1, there),
                   c = gather(corners, first + 2, there);
        store(forces, t, air_force(model, particle(p, q, a), particle(p, q, b), particle(p, q, c)));
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
            fx[l] += forces.x[t], fy[l] += forces.y[t], fz[l] += forces.z[t];
          }
      move(model, p, q, inverse_mass, i, {load(fx), load(fy), load(fz)});
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
