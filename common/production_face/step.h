// Contract: a frame of the face: where flesh rests, given its bones' places and its muscles' activation.
//
// Newton's method for f(u) = 0 at free nodes:
//
//   K du = f,   u += a du
//
// In the first step held nodes move to their places, and free nodes follow within the same solve: the right-hand side
// is f - K d, d the displacement of held nodes. So flesh between bones is not torn by a jaw that moves at once. Where
// bones move, a = 1. In other steps, a is the first of 1, 1/2, 1/4, ... that lowers the energy enough,
//
//   E(u + a du) <= E(u) - 1e-4 a f . du + what rounding may add to E.
//
// K is exact, so that convergence is quadratic, unless a solve finds that it is not definite. Then the derivative is
// made definite (update_state.h) for that step and for others until |f| has fallen to `exact_again` of what it was.
//
// K du = f is solved to a share of |f| that falls with |f| (Eisenstat and Walker), but no further than half the frame's
// tolerance. Where bones move, it is solved to `share_of_bones`: flesh goes far in this step, and a greater residual
// would tear it.
//
//   newton   as above, by multigrid (solve.h). Ends where |f| <= tolerance times the first right-hand side, or times
//            force_of_strain if that is less, as in crushed flesh; or below what the rounding of strains makes of f
//            (force_of_rounding); or where neither energy nor forces fall any more; or after `most_steps`.
//   facesim  what PARSEC's program does in a frame: held nodes move first; one step, definite, by 200 iterations of
//            `plain`; a = 1.
//
// In:      face; target; tolerance.
// In, out: pose, finite.
// Scratch: memory, made for the face. Of it, what the frame took comes out (Frame), and `strained` and `force` of the
//          pose, held nodes' forces 0.
// Errors:  std::bad_alloc.
// Source:  [ITJ07] "Production Face"; Teran, Sifakis, Irving and Fedkiw, Robust quasistatic finite elements and flesh
//          simulation, SCA 2005; Eisenstat and Walker, Choosing the forcing terms in an inexact Newton method, SIAM J.
//          Sci. Comput. 17 (1996).
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/production_face/assemble.h"
#include "common/production_face/forces.h"
#include "common/production_face/motion.h"
#include "common/production_face/solve.h"

namespace lockstep::production_face {

inline constexpr int most_steps = 50;
inline constexpr int most_in_vain = 3;        // steps in a row: energy within rounding, |f| not halved
inline constexpr int most_halvings = 12;      // of a step
inline constexpr int most_iterations = 3000;  // of a step's solve
inline constexpr double exact_again = .1;
inline constexpr double share_of_bones = 1e-3;
inline constexpr linear::Stop stop_of_facesim = {.tolerance = 1e-6, .iterations = 200};

// A body of flesh, and what follows from it once.
template <class Real>
struct Face {
  Body<Real> body;
  Flesh flesh;
  Pattern pattern;
  Coarsening<Real> coarsening;
  Waves waves;
  double volume;  // m^3, of all tetrahedra
};

template <class Real>
Face<Real> make_face(const Body<Real>& body, const Flesh& flesh) {
  double volume = 0;
  for (const Real v : body.volume.value) volume += v;
  Pattern pattern = make_pattern(body);
  Coarsening<Real> coarsening = make_coarsening(body, pattern);
  return {body, flesh, std::move(pattern), std::move(coarsening), make_waves(body), volume};
}

// The modules of a step.
enum class Module { update_state, forces, assemble, solve, move, count };
inline constexpr const char* name_of_module[] = {"update_state", "forces", "assemble", "solve", "move"};

// What a frame took.
struct Frame {
  int steps = 0, iterations = 0, halvings = 0;
  double first = 0, last = 0;               // N: the force that `tolerance` is a share of; |f| at the end
  double seconds[int(Module::count)] = {};  // by module
};

// Scratch, which keeps its room from frame to frame; and what the last frame took.
template <class Real, class Matrix>
struct StepMemory {
  Strained<Real> strained;
  Matrix k;
  Multigrid<Real, Matrix> multigrid;
  Array<Real> force, change, bones;  // [3 n + c]: f; du; d
  Vectors<Real> before;              // the displacement that a step begins with; `move` writes all of the pose's
  Array<Real> shares, parts;         // of openmp's assemble and forces
  Frame frame;
};

using SerialMemory = StepMemory<float, linear::BlockRows<float>>;
using OpenmpMemory = StepMemory<float, linear::SlicedBlockRows>;

template <class Real, class Matrix>
using Step = void(const Face<Real>& face, const Target<Real>& target, double tolerance, Pose<Real>& pose,
                  StepMemory<Real, Matrix>& memory);

namespace serial {
SerialMemory make_memory(const Face<float>& face);
StepMemory<double, linear::BlockRows<double>> make_memory(const Face<double>& face);
Step<float, linear::BlockRows<float>> step_newton, step_facesim;
Step<double, linear::BlockRows<double>> step_newton, step_facesim;
}  // namespace serial

namespace openmp {
OpenmpMemory make_memory(const Face<float>& face);
Step<float, linear::SlicedBlockRows> step_newton, step_facesim;
}  // namespace openmp

// --- Formulas

// N: what |f| is where F is off by 1 in each tetrahedron. That is a stress of kappa, which acts on a node across the
// faces around it, about the square of a tetrahedron's length.
template <class Real>
double force_of_strain(const Face<Real>& face) {
  const double length = std::cbrt(face.volume / face.body.tetrahedra);
  return face.flesh.kappa * length * length * std::sqrt(3. * face.body.nodes);
}

// N: the same where F is off by 12 units of rounding.
template <class Real>
double force_of_rounding(const Face<Real>& face) {
  return 6 * double(std::numeric_limits<Real>::epsilon()) * force_of_strain(face);
}

// J: what rounding may add to the energy. At rest, its density is a difference of terms of 3 (m10 + m01).
template <class Real>
double energy_of_rounding(const Face<Real>& face) {
  return 32 * 0x1p-24 * 3 * (double(face.flesh.m10) + face.flesh.m01) * face.volume;
}

// The share of |f| that a step's solve leaves.
inline double forcing(double force, double first, double tolerance) {
  return std::max({std::min(.05, force / first), .5 * tolerance * first / force, 1e-5});
}

}  // namespace lockstep::production_face
