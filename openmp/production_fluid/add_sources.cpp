// Pours liquid in.
//
// The algorithm and its serial form stand in serial/production_fluid/add_sources.cpp. Sixteen cells or faces along x at
// once, and sixteen particles; threads share the lines of a ball's box, and the particles.
//
// The contract stands in common/production_fluid/add_sources.h.
#include "common/production_fluid/add_sources.h"

#include "common/real.h"
#include "common/simd.h"

namespace lockstep::production_fluid::openmp {
namespace {

// Positions, m, of the elements of a line along x: element x is at `first` + x h.
struct Points {
  Vector3<Real> first;
  Real spacing;

  // Of x and the fifteen behind it.
  Vector3<floatv> operator()(int x) const {
    return {first.x + spacing * to_float(x + lane_index()), floatv(first.y), floatv(first.z)};
  }
};

void fill(const Ball<Real>& ball, const Points& points, const Range& cells, const Real* solid, Real* phi) {
  for (int x = cells.begin; x < cells.end; x += lanes) {
    const floatv least = min(load(&phi[x]), level_of(ball, points(x)));
    const maskv open = !is_solid(load(&solid[x]));
    store(&phi[x], least, open & first_lanes(cells.end - x));
  }
}

void push(const Ball<Real>& ball, const Points& points, const Range& faces, Real component, Real* velocity) {
  for (int x = faces.begin; x < faces.end; x += lanes)
    store(&velocity[x], floatv(component), (level_of(ball, points(x)) < 0.f) & first_lanes(faces.end - x));
}

void pour(const Source& source, Fluid<Real>& fluid) {
  const Ball<Real> ball = ball_of<Real>(source);
  const Real h = fluid.spacing;
  const auto points = [h](Real x, Real y, Real z) { return Points{{h * x, h * y, h * z}, h}; };
  const Real half = Real(.5);
  Field<Real>&u = fluid.velocity.u, &v = fluid.velocity.v, &w = fluid.velocity.w;
  const NearBall near = near_ball(source, fluid);
  // A line changes its own cells and faces, and reads no others.
#pragma omp parallel for collapse(2) schedule(static)
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
  const auto& [px, py, pz] = particles.position;
  const Real *const x = px.data(), *const y = py.data(), *const z = pz.data();
  const int count = particles.count;
  // An iteration writes the signs of its own sixteen particles.
#pragma omp parallel for schedule(static)
  for (int i = 0; i < count; i += lanes) {
    const floatv level = level_of(ball, Vector3<floatv>{load(x + i), load(y + i), load(z + i)});
    const maskv in = (level < 0.f) & first_lanes(count - i);
    if (any(in)) store(&particles.sign[i], floatv(-1.f), in);  // an empty store would still fetch the line
  }
}

}  // namespace

void add_sources(const std::vector<Source>& sources, double time, Fluid<Real>& fluid, Particles<Real>& particles) {
  for (const Source& source : sources) {
    if (source.until <= time) continue;
    pour(source, fluid);
    wet(source, particles);
  }
}

}  // namespace lockstep::production_fluid::openmp
