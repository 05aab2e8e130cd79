// A frame of the face.
//
// The order of the kernels and its serial form stand in serial/production_face/step.cpp. Each kernel has threads and
// lanes of its own; so have the loops over nodes between them.
//
// The contract stands in common/production_face/step.h.
#include "common/production_face/step.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/linear/dot.h"
#include "common/linear/multiply.h"
#include "common/linear/update.h"
#include "common/production_face/update_state.h"
#include "common/real.h"
#include "common/stopwatch.h"

namespace lockstep::production_face::openmp {
namespace {

using Memory = StepMemory<Real, linear::SlicedBlockRows>;

// Adds the time since the last call to a module's.
struct Clock {
  Frame& frame;
  Stopwatch stopwatch = {};

  void operator()(Module module) { frame.seconds[int(module)] += stopwatch.lap(); }
};

double norm(const Array<Real>& x) { return std::sqrt(linear::openmp::dot(x, x)); }

double energy_of(const Face<Real>& face, const Memory& memory) {
  return linear::openmp::dot(face.body.volume.value, memory.strained.energy.value);
}

// d: how far held nodes are from their places. Returns whether any is.
bool set_bones(const Body<Real>& body, const Target<Real>& target, const Pose<Real>& pose, Memory& memory) {
  bool moves = false;
  // A held node is written by one thread; whether one moves does not depend on their order.
#pragma omp parallel for schedule(static) reduction(|| : moves)
  for (std::size_t k = 0; k < body.held.size(); ++k) {
    const std::size_t n = body.held[k];
    const Vector3<Real> d = load(target.held, k) - load(pose.displacement, n);
    memory.bones[3 * n] = d.x, memory.bones[3 * n + 1] = d.y, memory.bones[3 * n + 2] = d.z;
    moves = moves || d.x != 0 || d.y != 0 || d.z != 0;
  }
  return moves;
}

// u = before + a du.
void move(const Memory& memory, Real a, Pose<Real>& pose) {
  const std::size_t nodes = memory.change.size() / 3;
  // A node is written by one thread, from numbers that none changes.
#pragma omp parallel for schedule(static)
  for (std::size_t n = 0; n < nodes; ++n) {
    const Vector3<Real> du = {memory.change[3 * n], memory.change[3 * n + 1], memory.change[3 * n + 2]};
    store(pose.displacement, n, load(memory.before, n) + a * du);
  }
}

// f is 0 at held nodes.
void clear_held(const Body<Real>& body, Array<Real>& force) {
  // A held node is written by one thread.
#pragma omp parallel for schedule(static)
  for (std::size_t k = 0; k < body.held.size(); ++k) {
    const std::size_t n = body.held[k];
    force[3 * n] = force[3 * n + 1] = force[3 * n + 2] = 0;
  }
}

// Stresses and forces of a pose.
void evaluate(const Face<Real>& face, const Pose<Real>& pose, bool definite, Memory& memory, Clock& clock) {
  update_state(face.body, face.flesh, pose, definite, memory.strained);
  clock(Module::update_state);
  forces(face.body, memory.strained, face.waves, memory.parts, memory.force);
  clear_held(face.body, memory.force);
  clock(Module::forces);
}

// The stiffness of a pose whose stresses and forces are there. `definite` tells whether the derivative is, too.
void set_stiffness(const Face<Real>& face, const Pose<Real>& pose, bool wanted, bool& definite, Memory& memory,
                   Clock& clock) {
  if (wanted != definite) {
    definite = wanted;
    update_state(face.body, face.flesh, pose, definite, memory.strained);
    clock(Module::update_state);
  }
  assemble(face.body, memory.strained, face.pattern, memory.shares, memory.k);
  clock(Module::assemble);
}

// f - K d takes the place of f: the forces once held nodes have moved.
void follow_bones(Memory& memory, Clock& clock) {
  linear::openmp::multiply(memory.k, memory.bones, memory.change);
  linear::openmp::axpy(Real(-1), memory.change, memory.force);
  clock(Module::solve);
}

// du. Returns whether K showed itself to be definite.
bool solve(const Face<Real>& face, const linear::Stop& stop, Memory& memory, Clock& clock) {
  const linear::Solution solution =
      solve_multigrid(face.coarsening, memory.k, memory.force, stop, memory.change, memory.multigrid);
  memory.frame.iterations += solution.iterations;
  clock(Module::solve);
  return solution.recursive_residual <= stop.tolerance || solution.iterations >= stop.iterations;
}

// Moves by the first of du, du / 2, du / 4, ... that lowers the energy enough. Returns whether there is one;
// if not, nothing has moved. `slope` is f . du.
bool search(const Face<Real>& face, double slope, bool definite, Pose<Real>& pose, Memory& memory, Clock& clock) {
  const double energy = energy_of(face, memory), rounding = energy_of_rounding(face);
  std::swap(memory.before, pose.displacement);
  for (double a = 1;; a /= 2, ++memory.frame.halvings) {
    move(memory, static_cast<Real>(a), pose);
    clock(Module::move);
    evaluate(face, pose, definite, memory, clock);
    if (energy_of(face, memory) <= energy - 1e-4 * a * slope + rounding) return true;
    if (a <= 1. / (1 << most_halvings)) break;
  }
  std::swap(memory.before, pose.displacement);
  evaluate(face, pose, definite, memory, clock);
  return false;
}

}  // namespace

void step_newton(const Face<Real>& face, const Target<Real>& target, double tolerance, Pose<Real>& pose,
                 Memory& memory) {
  Frame& frame = memory.frame = {};
  Clock clock = {frame};
  pose.activation = target.activation;
  bool bones_move = set_bones(face.body, target, pose, memory);
  clock(Module::move);
  bool definite = false;
  double exact_below = std::numeric_limits<double>::infinity();  // N
  int in_vain = 0;                                               // steps in a row (most_in_vain)
  evaluate(face, pose, definite, memory, clock);
  frame.last = norm(memory.force);
  const double least = force_of_rounding(face), rounding = energy_of_rounding(face);
  while (frame.steps < most_steps && (bones_move || frame.last > std::max(least, tolerance * frame.first))) {
    set_stiffness(face, pose, frame.last >= exact_below, definite, memory, clock);
    if (bones_move) follow_bones(memory, clock), frame.last = norm(memory.force);
    if (frame.steps == 0) frame.first = std::min(frame.last, force_of_strain(face));
    const double share = bones_move ? share_of_bones : forcing(frame.last, frame.first, tolerance);
    const linear::Stop stop = {share, most_iterations};
    if (!solve(face, stop, memory, clock) && !definite) {
      exact_below = exact_again * frame.last;
      set_stiffness(face, pose, true, definite, memory, clock);
      solve(face, stop, memory, clock);
    }
    ++frame.steps;
    if (bones_move) {
      linear::openmp::axpy(Real(1), memory.bones, memory.change);
      std::swap(memory.before, pose.displacement);
      move(memory, Real(1), pose);
      clock(Module::move);
      evaluate(face, pose, definite, memory, clock);
      frame.last = norm(memory.force), bones_move = false;
      continue;
    }
    const double slope = linear::openmp::dot(memory.force, memory.change), before = frame.last;
    const bool falls = search(face, slope, definite, pose, memory, clock);
    frame.last = norm(memory.force);
    in_vain = slope <= rounding && frame.last > .5 * before ? in_vain + 1 : 0;
    if (!falls || in_vain == most_in_vain) break;
  }
}

void step_facesim(const Face<Real>& face, const Target<Real>& target, double, Pose<Real>& pose, Memory& memory) {
  Frame& frame = memory.frame = {};
  Clock clock = {frame};
  pose.activation = target.activation;
  set_bones(face.body, target, pose, memory);
  memory.change = memory.bones;
  std::swap(memory.before, pose.displacement);
  move(memory, Real(1), pose);
  clock(Module::move);
  evaluate(face, pose, true, memory, clock);
  frame.first = norm(memory.force), frame.steps = 1;
  assemble(face.body, memory.strained, face.pattern, memory.shares, memory.k);
  clock(Module::assemble);
  frame.iterations = solve_plain(memory.k, memory.force, stop_of_facesim, memory.change).iterations;
  clock(Module::solve);
  std::swap(memory.before, pose.displacement);
  move(memory, Real(1), pose);
  clock(Module::move);
  evaluate(face, pose, true, memory, clock);
  frame.last = norm(memory.force);
}

Memory make_memory(const Face<Real>& face) {
  const std::size_t n = 3 * static_cast<std::size_t>(face.body.nodes);
  Memory memory;
  memory.strained = make_strained(face.body), memory.k = linear::slice(make_block_rows<Real>(face.pattern));
  memory.shares = make_shares(face.body), memory.parts = make_parts(face.body);
  for (Array<Real>* vector : {&memory.force, &memory.change, &memory.bones}) vector->resize(n);
  memory.before.resize(face.body.nodes);
  memory.multigrid = make_multigrid(face.coarsening, memory.k);
  return memory;
}

}  // namespace lockstep::production_face::openmp
