// Pours liquid in: the cells about each source's ball, the faces in it and the particles in it become the source's.
//
// Only the box about a ball is visited, line by line: its cells, and the faces before and behind them.
//
// The contract stands in common/production_fluid/add_sources.h.
#include "common/production_fluid/add_sources.h"

#include "common/real.h"

namespace lockstep::production_fluid::serial {
namespace {

// Positions, m, of the elements of a line along x: element x is at `first` + x h.
struct Points {
  Vector3<Real> first;
  Real spacing;

  Vector3<Real> operator()(int x) const { return {first.x + spacing * static_cast<Real>(x), first.y, first.z}; }
};

void fill(const Ball<Real>& ball, const Points& points, const Range& cells, const Real* solid, Real* phi) {
  for (int x = cells.begin; x < cells.end; ++x) {
    const Real least = min(phi[x], level_of(ball, points(x)));
    where(!is_solid(solid[x]), phi[x]) = least;
  }
}

void push(const Ball<Real>& ball, const Points& points, const Range& faces, Real component, Real* velocity) {
  for (int x = faces.begin; x < faces.end; ++x) where(level_of(ball, points(x)) < 0, velocity[x]) = component;
}

void pour(const Source& source, Fluid<Real>& fluid) {
  const Ball<Real> ball = ball_of<Real>(source);
  const Real h = fluid.spacing;
  const auto points = [h](Real x, Real y, Real z) { return Points{{h * x, h * y, h * z}, h}; };
  const Real half = Real(.5);
  Field<Real>&u = fluid.velocity.u, &v = fluid.velocity.v, &w = fluid.velocity.w;
  const NearBall near = near_ball(source, fluid);
  for (int z = near.z.begin; z <= near.z.end; ++z)
    for (int y = near.y.begin; y <= near.y.end; ++y) {
      const Real py = static_cast<Real>(y), pz = static_cast<Real>(z);
      const bool cells_along_y = y < near.y.end, cells_along_z = z < near.z.end;
      if (cells_along_y && cells_along_z) {
        fill(ball, points(half, py + half, pz + half), near.x, &fluid.solid(0, y, z), &fluid.phi(0, y, z));
        push(ball, points(0, py + half, pz + half), {near.x.begin, near.x.end + 1}, ball.velocity.x, &u(0, y, z));
      }
      if (cells_along_z) push(ball, points(half, py, pz + half), near.x, ball.velocity.y, &v(0, y, z));
      if (cells_along_y) push(ball, points(half, py + half, pz), near.x, ball.velocity.z, &w(0, y, z));
    }
}

void wet(const Source& source, Particles<Real>& particles) {
  const Ball<Real> ball = ball_of<Real>(source);
  for (int i = 0; i < particles.count; ++i)
    where(level_of(ball, load(particles.position, i)) < 0, particles.sign[i]) = -1;
}

}  // namespace

void add_sources(const std::vector<Source>& sources, double time, Fluid<Real>& fluid, Particles<Real>& particles) {
  for (const Source& source : sources) {
    if (source.until <= time) continue;
    pour(source, fluid);
    wet(source, particles);
  }
}

}  // namespace lockstep::production_fluid::serial
