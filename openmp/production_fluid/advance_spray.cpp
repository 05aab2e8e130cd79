// Drops of spray fly for one step; those that reach the liquid become particles again.
//
// The algorithm and its serial form stand in serial/production_fluid/advance_spray.cpp. Sixteen drops at once; threads
// share chunks of drops. Drops move to other arrays first: in place, a thread could overwrite a drop that another has
// yet to read. When all have moved, each chunk knows the places of its own (openmp/compaction.h).
//
// The contract stands in common/production_fluid/advance_spray.h.
#include "common/production_fluid/advance_spray.h"

#include <bit>

#include "common/real.h"
#include "common/simd.h"
#include "openmp/compaction.h"
#include "openmp/production_fluid/scattered_corners.h"
#include "openmp/vector_lanes.h"

namespace lockstep::production_fluid::openmp {
namespace {

using namespace lockstep::openmp;
using Index = intv;

Vector3<floatv> in_cells(const Fluid<Real>& fluid, const Vector3<floatv>& position) {
  return (1 / fluid.spacing) * position;
}

// Moves a drop out of obstacles and into the box, and stops it there.
void stop(const Fluid<Real>& fluid, const floatv& radius, Drop<floatv>& drop) {
  const Field<Real>& field = fluid.solid;
  const auto [cell, along] = spot_of<Index>(field, first_centre, in_cells(fluid, drop.position));
  const Corners<floatv> corners = ScatteredCorners()(&field.value[field.index(0, 0, 0)], cell);
  const floatv solid = interpolate(corners, along.x, along.y, along.z);
  if (any(solid < radius)) drop = stopped_by_obstacle(drop, radius, solid, slope(corners, along.x, along.y, along.z));
  stop_at_sides(fluid, radius, drop);
}

// Moves the chosen ones of drops i .. i + 15 of one spray to another.
void move(const Compaction& chosen, int i, const Spray<Real>& from, Spray<Real>& to) {
  const Vectors<Real>&x = from.position, &v = from.velocity;
  chosen.move(i, {{x.x.data(), to.position.x.data()},
                  {x.y.data(), to.position.y.data()},
                  {x.z.data(), to.position.z.data()},
                  {v.x.data(), to.velocity.x.data()},
                  {v.y.data(), to.velocity.y.data()},
                  {v.z.data(), to.velocity.z.data()},
                  {from.radius.data(), to.radius.data()}});
}

// The same to particles; the first goes to place `k`.
void move(const Compaction& chosen, int i, const Spray<Real>& from, Particles<Real>& to, int k) {
  const Vectors<Real>& x = from.position;
  chosen.move(i, {{x.x.data(), &to.position.x[k]},
                  {x.y.data(), &to.position.y[k]},
                  {x.z.data(), &to.position.z[k]},
                  {from.radius.data(), &to.radius[k]}});
  const int count = std::popcount(chosen.which(i));
  store(&to.sign[k + chosen.before(i)], -1.f, first_lanes(count));
}

}  // namespace

void advance_spray(const Fluid<Real>& fluid, const Vector3<Real>& gravity, Real dt, Spray<Real>& spray,
                   Particles<Real>& particles) {
  if (spray.count == 0) return;
  const int before = particles.count;
  Compaction fly(spray.count), come_back(spray.count);
  Spray<Real> all;
  resize(all, spray.count);
  const Vector3<Real*> position = pointers(spray.position), velocity = pointers(spray.velocity),
                       new_position = pointers(all.position), new_velocity = pointers(all.velocity);
  // A chunk moves its own drops, through fields that none writes.
#pragma omp parallel for schedule(static)
  for (int chunk = 0; chunk < fly.chunks(); ++chunk)
    fly.for_each_sixteen(chunk, [&](int i) {
      Drop<floatv> drop = flown<floatv>({load(position, i), load(velocity, i)}, gravity, dt);
      const maskv here = !has_left(fluid, drop);
      const floatv radius = load(&spray.radius[i]);
      stop(fluid, radius, drop);
      const maskv flies =
          sample<Index>(fluid.phi, first_centre, in_cells(fluid, drop.position), ScatteredCorners()) > radius;
      store(new_position, i, drop.position), store(new_velocity, i, drop.velocity), store(&all.radius[i], radius);
      fly.choose(i, here & flies), come_back.choose(i, here & !flies);
    });
  resize(spray, fly.add_up()), resize(particles, before + come_back.add_up());
  // A chunk's drops go to places of their own.
#pragma omp parallel for schedule(static)
  for (int chunk = 0; chunk < fly.chunks(); ++chunk)
    fly.for_each_sixteen(chunk, [&](int i) {
      move(fly, i, all, spray);
      move(come_back, i, all, particles, before);
    });
}

}  // namespace lockstep::production_fluid::openmp
