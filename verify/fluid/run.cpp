#include "verify/fluid/run.h"

#include <algorithm>
#include <cmath>

#include "common/fluid/convert.h"
#include "common/fluid/densities.h"
#include "common/fluid/id_order.h"
#include "common/fluid/rebuild_grid.h"
#include "verify/arrays.h"
#include "verify/compare.h"
#include "verify/fluid/bounds.h"

namespace lockstep::verify {
namespace {

using namespace fluid;
// How long a free run is: enough frames for chaos to show, few enough to wait for.
constexpr double particle_frames = 1e6;
constexpr int max_free_frames = 200;

std::vector<float> state_by_id(const Particles<float>& p) {
  std::vector<float> by_id(6 * static_cast<std::size_t>(p.count));
  for (int i = 0; i < p.count; ++i) {
    float* to = &by_id[6 * static_cast<std::size_t>(p.id[i])];
    to[0] = p.position.x[i], to[1] = p.position.y[i], to[2] = p.position.z[i];
    to[3] = p.velocity.x[i], to[4] = p.velocity.y[i], to[5] = p.velocity.z[i];
  }
  return by_id;
}

struct Distance {
  double positions, velocities;  // rms
};

Distance distance(const std::vector<float>& a, const std::vector<float>& b) {
  double positions = 0, velocities = 0;
  for (std::size_t k = 0; k < a.size(); ++k)
    (k % 6 < 3 ? positions : velocities) += (double(a[k]) - b[k]) * (double(a[k]) - b[k]);
  const double count = std::max<double>(a.size() / 6, 1);
  return {std::sqrt(positions / count), std::sqrt(velocities / count)};
}

double particle_mass(const Model<float>& model) {
  return .5 * model.twice_rest_density / std::pow(double(model.particles_per_metre), 3);
}

std::string frame_name(const char* what, std::size_t frame) {
  return std::string(what) + " after frame " + std::to_string(frame + 1);
}

// A fact that holds or does not: what it is, what was found and what was allowed.
void check(Judgement& judgement, bool holds, const std::string& what, double found, double allowed) {
  if (holds) return;
  if (judgement.passed) judgement.error = found, judgement.bound = allowed, judgement.worst_at = what;
  judgement.passed = false;
}

}  // namespace

double energy(const Fluid<float>& fluid) {
  const Particles<float>& p = fluid.particles;
  const Vector3<float>&g = fluid.model.gravity, &floor = fluid.model.domain_min;
  double sum = 0;
  for (int i = 0; i < p.count; ++i) {
    const double vx = p.velocity.x[i], vy = p.velocity.y[i], vz = p.velocity.z[i];
    sum += .5 * (vx * vx + vy * vy + vz * vz);
    sum -= double(g.x) * (p.position.x[i] - floor.x) + double(g.y) * (p.position.y[i] - floor.y) +
           double(g.z) * (p.position.z[i] - floor.z);
  }
  return particle_mass(fluid.model) * sum;
}

bool inside_domain(const Fluid<float>& fluid) {
  const Vectors<float>& p = fluid.particles.position;
  const Vector3<float>&low = fluid.model.domain_min, &high = fluid.model.domain_max;
  for (int i = 0; i < fluid.particles.count; ++i)
    if (!(p.x[i] >= low.x && p.x[i] <= high.x && p.y[i] >= low.y && p.y[i] <= high.y && p.z[i] >= low.z &&
          p.z[i] <= high.z))
      return false;
  return true;
}

Vector3<double> momentum(const Fluid<float>& fluid) {
  const Particles<float>& p = fluid.particles;
  Vector3<double> sum = {0, 0, 0};
  for (int i = 0; i < p.count; ++i)
    sum.x += p.half_velocity.x[i], sum.y += p.half_velocity.y[i], sum.z += p.half_velocity.z[i];
  const double mass = particle_mass(fluid.model);
  return {mass * sum.x, mass * sum.y, mass * sum.z};
}

double momentum_rounding(const Fluid<float>& after_step) {
  // Each particle's acceleration is off by force_rounding at the most, and hv + a dt rounds twice.
  Fluid<double> fluid = convert<double>(after_step);
  serial::rebuild_grid(fluid.grid, fluid.particles, fluid.sorted);
  serial::densities_symmetric(fluid.model, fluid.grid, fluid.particles, fluid.neighbours, fluid.density);
  const Vectors<double> a = force_rounding(fluid, fluid.density, std::vector<double>(fluid.particles.count, 0));
  const Vectors<double>& hv = fluid.particles.half_velocity;
  double sum = 0;
  for (int i = 0; i < fluid.particles.count; ++i)
    sum += fluid.model.time_step * std::max({a.x[i], a.y[i], a.z[i]}) +
           2 * unit_roundoff * std::max({std::abs(hv.x[i]), std::abs(hv.y[i]), std::abs(hv.z[i])});
  return particle_mass(after_step.model) * sum;
}

double bytes_of(const FreeRuns& runs) {
  double bytes = 0;
  for (const FreeRuns::Frame& frame : runs.frames) bytes += sizeof(float) * frame.serial.size();
  return bytes;
}

FreeRuns run_freely(const Fluid<float>& start, int scene_frames) {
  const int affordable = static_cast<int>(particle_frames / std::max(start.particles.count, 1));
  const int frames = std::clamp(affordable, 5, std::max(5, std::min(scene_frames, max_free_frames)));
  FreeRuns runs;
  Fluid<float> fluid = start;
  for (int frame = 0; frame < frames; ++frame) {
    serial::step_symmetric(fluid);
    runs.frames.push_back({state_by_id(fluid.particles), energy(fluid), 0, 0, 0});
  }

  // Rounding disturbs all three axes: to first order its effect is the sum of theirs.
  for (auto axis : {&Vectors<float>::x, &Vectors<float>::y, &Vectors<float>::z}) {
    Fluid<float> moved = start;
    for (int i = 0; i < moved.particles.count; ++i) {
      float& p = (moved.particles.position.*axis)[i];
      p = std::nextafter(p, i % 2 ? 1e30f : -1e30f);
    }
    Distance farthest = {0, 0};
    for (FreeRuns::Frame& frame : runs.frames) {
      serial::step_symmetric(moved);
      const Distance now = distance(state_by_id(moved.particles), frame.serial);
      farthest = {std::max(farthest.positions, now.positions), std::max(farthest.velocities, now.velocities)};
      frame.positions += farthest.positions;
      frame.velocities += farthest.velocities;
    }
  }

  // |dE| <= m sum (|v| |dv| + |dv|^2 / 2 + |g| |dp|), with Cauchy and Schwarz for the sums.
  const Vector3<float>& g = start.model.gravity;
  const double weight = std::sqrt(double(g.x) * g.x + double(g.y) * g.y + double(g.z) * g.z);
  const double total_mass = particle_mass(start.model) * start.particles.count;
  for (FreeRuns::Frame& frame : runs.frames) {
    const double speed = distance(frame.serial, std::vector<float>(frame.serial.size(), 0)).velocities;
    frame.energy =
        total_mass * (speed * frame.velocities + .5 * frame.velocities * frame.velocities + weight * frame.positions);
  }
  const double forgotten = .01 * start.model.smoothing_length;
  runs.comparable = std::ranges::find_if(runs.frames, [&](const auto& frame) { return frame.positions > forgotten; }) -
                    runs.frames.begin();
  return runs;
}

void check_one_step(Judgement& judgement, const Fluid<float>& start, const Fluid<float>& openmp,
                    const Fluid<float>& serial) {
  const int count = start.particles.count;
  Fluid<double> truth = convert<double>(start);
  serial::step_symmetric(truth);  // leaves the densities and accelerations of the step's start behind

  // The rounding of a step: densities within the bound of their sums, the accelerations that follow from them, and
  // three roundings on the way to half_velocity and position. Found in the truth's own order, at the step's start.
  Fluid<double> before = convert<double>(start);
  serial::rebuild_grid(before.grid, before.particles, before.sorted);
  const std::span<const double> density(truth.density.data(), count);
  std::vector<double> density_error = density_rounding(before, density);
  // N u density each for serial and openmp, and for serial once more by the factor 2.
  for (double& error : density_error) error *= 3;
  const Vectors<double> a_error = force_rounding(before, density, density_error);

  const std::vector<int> in_truth = id_order(truth.particles), in_openmp = id_order(openmp.particles),
                         in_serial = id_order(serial.particles);
  const double dt = truth.model.time_step;
  const auto axis = [&](auto of, const char* name) {
    std::vector<float> o(2 * count), s(2 * count);
    std::vector<double> t(2 * count), rounding(2 * count);
    for (int id = 0; id < count; ++id) {
      const int k = in_truth[id];
      t[id] = of(truth.particles.half_velocity)[k], t[count + id] = of(truth.particles.position)[k];
      o[id] = of(openmp.particles.half_velocity)[in_openmp[id]],
      o[count + id] = of(openmp.particles.position)[in_openmp[id]];
      s[id] = of(serial.particles.half_velocity)[in_serial[id]],
      s[count + id] = of(serial.particles.position)[in_serial[id]];
      const double hv_before = of(before.particles.half_velocity)[k], hv = t[id], p = t[count + id];
      // a and a dt round, then their sum with half_velocity: what it was is larger where a wall has turned it round.
      rounding[id] = dt * (of(a_error)[k] + 2 * unit_roundoff * std::abs(of(truth.acceleration)[k])) +
                     2 * unit_roundoff * (std::abs(hv_before) + std::abs(hv));
      // Moving rounds once, being mirrored at a wall twice more.
      rounding[count + id] = dt * rounding[id] + 3 * unit_roundoff * (std::abs(p) + dt * std::abs(hv));
    }
    within_bound(judgement, o, s, t, rounding, [&](std::size_t k) {
      return std::string(name) + (k < std::size_t(count) ? " half velocity" : " position") + " of particle " +
             std::to_string(k % count);
    });
  };
  axis(
      [](auto& v) -> auto& { return v.x; }, "x");
  axis(
      [](auto& v) -> auto& { return v.y; }, "y");
  axis(
      [](auto& v) -> auto& { return v.z; }, "z");
}

void check_free_run(Judgement& judgement, const FreeRuns& runs, const Holds& holds, const Fluid<float>& start,
                    Step<float>* step) {
  Fluid<float> fluid = start;
  Vector3<double> before = momentum(fluid);
  judgement.courses = {
      {"rms distance of positions", "m"}, {"rms distance of velocities", "m/s"}, {"distance of energies", "J"}};
  for (std::size_t frame = 0; frame < runs.frames.size(); ++frame) {
    step(fluid);
    const std::string fault = first_not_finite(fluid, [&](const auto& array, std::size_t i, const auto& field) {
      return of_element("particle")(array, fluid.particles.id[i], field);
    });
    check(judgement, fault.empty(), frame_name(fault.c_str(), frame), 1, 0);
    if (!judgement.passed) return;
    if (holds.inside_domain)
      check(judgement, inside_domain(fluid), frame_name("a particle is outside the domain", frame), 1, 0);
    if (holds.momentum_conserved) {
      const Vector3<double> after = momentum(fluid);
      const double change =
          std::max({std::abs(after.x - before.x), std::abs(after.y - before.y), std::abs(after.z - before.z)});
      const double allowed = momentum_rounding(fluid);
      check(judgement, change <= allowed, frame_name("momentum changed", frame), change, allowed);
      before = after;
    }
    if (frame >= runs.comparable) continue;
    const FreeRuns::Frame& serial = runs.frames[frame];
    const auto [positions, velocities] = distance(state_by_id(fluid.particles), serial.serial);
    const double found[] = {positions, velocities, std::abs(energy(fluid) - serial.serial_energy)},
                 bound[] = {serial.positions, serial.velocities, serial.energy};
    for (int k = 0; k < 3; ++k) {
      Course& course = judgement.courses[k];
      course.found.push_back(found[k]), course.bound.push_back(bound[k]);
      check(judgement, found[k] <= bound[k], frame_name((course.what + " from the serial run").c_str(), frame),
            found[k], bound[k]);
    }
  }
}

void check_lattice_density(Judgement& judgement, const Fluid<double>& lattice, std::span<const float> density) {
  const Vectors<double>& p = lattice.particles.position;
  const int count = lattice.particles.count;
  const auto range = [&](const Array<double>& x) { return std::minmax_element(x.begin(), x.begin() + count); };
  const auto [x_low, x_high] = range(p.x);
  const auto [y_low, y_high] = range(p.y);
  const auto [z_low, z_high] = range(p.z);
  const double h = lattice.model.smoothing_length, spacing = 1 / double(lattice.model.particles_per_metre);
  const double reach = std::max({-*x_low, *x_high, -*y_low, *y_high, -*z_low, *z_high});
  const double expected = lattice_density(lattice.model, spacing),
               allowed = lattice_density_rounding(lattice.model, spacing, reach);
  for (int i = 0; i < count; ++i) {
    const auto inside = [&](double x, double low, double high) { return x - low > h && high - x > h; };
    if (!inside(p.x[i], *x_low, *x_high) || !inside(p.y[i], *y_low, *y_high) || !inside(p.z[i], *z_low, *z_high))
      continue;
    check(judgement, std::abs(density[i] - expected) <= allowed,
          both_values("lattice density of particle " + std::to_string(lattice.particles.id[i]), density[i], expected),
          std::abs(density[i] - expected), allowed);
  }
}

}  // namespace lockstep::verify
