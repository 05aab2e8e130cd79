// Takes particles away that no longer help the level set; liquid that got away from it becomes spray.
//
// The algorithm and its serial form stand in serial/production_fluid/remove_particles.cpp. Sixteen particles at once;
// threads share chunks of particles, not blocks, most of which are empty. The fates of all are found first; then each
// chunk knows the places of the particles that it keeps (openmp/compaction.h).
//
// The contract stands in common/production_fluid/remove_particles.h.
#include "common/production_fluid/remove_particles.h"

#include <algorithm>
#include <bit>
#include <cstdint>

#include "common/real.h"
#include "common/simd.h"
#include "openmp/compaction.h"
#include "openmp/production_fluid/line_corners.h"
#include "openmp/vector_lanes.h"

namespace lockstep::production_fluid::openmp {
namespace {

using namespace lockstep::openmp;
using Index = intv;

template <class Number>
Vector3<Number> in_cells(const Fluid<Real>& fluid, const Vector3<Number>& position) {
  return (1 / fluid.spacing) * position;
}

// The value at the corner next to a position: that of the cell in which the position lies.
floatv nearest(const Corners<floatv>& c, const Vector3<floatv>& along) {
  const maskv right = along.x >= .5f, upper = along.y >= .5f, farther = along.z >= .5f;
  const auto along_x = [&](int line) { return select(right, c.value[2 * line + 1], c.value[2 * line]); };
  return select(farther, select(upper, along_x(3), along_x(2)), select(upper, along_x(1), along_x(0)));
}

// Of particles i .. i + 15.
Fate<maskv> fate_of(const Fluid<Real>& fluid, const Particles<Real>& particles, int i) {
  const Vector3<const Real*> position = {particles.position.x.data(), particles.position.y.data(),
                                         particles.position.z.data()};
  const Vector3<floatv> at =
      in_cells<floatv>(fluid, {load(position.x + i), load(position.y + i), load(position.z + i)});
  const floatv sign = load(&particles.sign[i]), radius = load(&particles.radius[i]);
  const Spot<floatv, Index> spot = spot_of<Index>(fluid.phi, first_centre, at);
  const auto corners_in = [&](const Field<Real>& field) {
    return LineCorners()(&field.value[field.index(0, 0, 0)], spot.cell);
  };
  const auto [x, y, z] = spot.along;
  const Corners<floatv> phi = corners_in(fluid.phi), solid = corners_in(fluid.solid);
  Fate<maskv> fate = production_fluid::fate_of(sign, radius, interpolate(phi, x, y, z), interpolate(solid, x, y, z),
                                               floatv(fluid.spacing));
  const maskv air = fate.keep & (sign > 0.f);
  if (none(air)) return fate;
  // Few particles are left that may be in a bubble, so they are looked at one by one.
  const floatv of_cell = nearest(phi, spot.along);
  const maskv may_be = air & (of_cell > 0.f) & (of_cell < fluid.spacing) &
                       reaches_centre<Index>(fluid.phi, at, (1 / fluid.spacing) * radius);
  for (std::uint32_t rest = bits(may_be); rest != 0; rest &= rest - 1) {
    const int k = i + std::countr_zero(rest);
    if (k < particles.count && is_in_bubble(fluid.phi, in_cells(fluid, load(particles.position, k))))
      fate.keep = fate.keep & !lanes_of(rest & -rest);
  }
  return fate;
}

void move(const Fluid<Real>& fluid, const Particles<Real>& from, int i, Spray<Real>& to, int k) {
  const Vector3<Real> position = load(from.position, i);
  store(to.position, k, position);
  store(to.velocity, k, velocity_at<std::int32_t>(fluid.velocity, in_cells(fluid, position)));
  to.radius[k] = from.radius[i];
}

// Where the kept ones of sixteen blocks begin. Mostly as many are left out before the first of these blocks as before
// the last.
void move_first(const Compaction& keep, const Array<std::int32_t>& first, int block, Array<std::int32_t>& kept) {
  const int count = std::min(lanes, static_cast<int>(first.size()) - block);
  const auto left_out = [&](int b) { return first[b] - keep.before_any(first[b]); };
  const int before = left_out(block);
  if (before == left_out(block + count - 1)) {
    const maskv there = first_lanes(count);
    store(&kept[block], load(&first[block], there) - before, there);
  } else {
    for (int b = block; b < block + count; ++b) kept[b] = keep.before_any(first[b]);
  }
}

}  // namespace

void remove_particles(const Fluid<Real>& fluid, const Particles<Real>& particles, Particles<Real>& kept,
                      Spray<Real>& spray) {
  const int firsts = static_cast<int>(particles.first.size()), sprayed = spray.count;
  Compaction keep(particles.count), fly(particles.count);
  // A chunk chooses among its own particles, from fields that none writes.
#pragma omp parallel for schedule(static)
  for (int chunk = 0; chunk < keep.chunks(); ++chunk)
    keep.for_each_sixteen(chunk, [&](int i) {
      const Fate<maskv> fate = fate_of(fluid, particles, i);
      keep.choose(i, fate.keep), fly.choose(i, fate.spray);
    });
  resize(kept, keep.add_up()), kept.first.resize(firsts);
  resize(spray, sprayed + fly.add_up());
  const Vectors<Real>& p = particles.position;
  Vectors<Real>& q = kept.position;
#pragma omp parallel
  {
    // A chunk's particles go to places of their own. The next loop does not read them, hence nowait.
#pragma omp for schedule(static) nowait
    for (int chunk = 0; chunk < keep.chunks(); ++chunk)
      keep.for_each_sixteen(chunk, [&](int i) {
        keep.move(i, {{p.x.data(), q.x.data()},
                      {p.y.data(), q.y.data()},
                      {p.z.data(), q.z.data()},
                      {particles.radius.data(), kept.radius.data()},
                      {particles.sign.data(), kept.sign.data()}});
        int k = sprayed + fly.before(i);
        for (std::uint32_t rest = fly.which(i); rest != 0; rest &= rest - 1)
          move(fluid, particles, i + std::countr_zero(rest), spray, k++);
      });
      // An iteration writes where the particles of sixteen blocks begin, from counts that are complete.
#pragma omp for schedule(static)
    for (int block = 0; block < firsts; block += lanes) move_first(keep, particles.first, block, kept.first);
  }
}

}  // namespace lockstep::production_fluid::openmp
