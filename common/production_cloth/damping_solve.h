// Contract: how the cloth's own forces change its velocities in half a step. Elastic forces are explicit, damping is
// implicit.
//
//   M (v' - v) = s (f - D v'),   so   (M + s D) (v' - v) = s (f - D v)
//
// for the vertices that are free. Those that are held keep their velocity, to which damping couples the others. The
// system is symmetric and positive definite: D is a sum of squares (element_forces.h). Only the weights of quadratic
// bending are rounded one by one, which changes D by up to u |Q|, far less than M. The system is solved for the change
// of velocity, by conjugate gradients (common/linear/iterate.h), preconditioned by M. The tolerance is of the right
// side above, so that it does not depend on how fast the cloth moves as a whole. Products are made element by element,
// without a matrix.
//
// Nothing changes where the right-hand side is 0: in free fall and, but for rounding, in any rigid motion of a cloth
// without elastic forces.
//
// The solve begins with a guess g: a sum of the changes that the last two solves of the kind made, with the weights by
// which the last of them would have been guessed best, in the 2-norm, from the two before it. It goes along g as far as
// conjugate gradients go along a direction, (g . b) / (g . A g). So no guess is worse than none, in the energy norm of
// A. A product with A costs less beside D v, which the right side needs. Where both weights are 0 there is no guess.
//
// In:      elements; state, what the same version's `forces` has made of the present shape; mass, kg; inverse_mass,
//          1/kg, 0 of held vertices; half_step, s, in seconds; force, N: the elastic forces; when to stop.
// In, out: velocity, m/s: v, v'. Forces that do not depend on velocity, such as gravity, may be added before.
//          changes, 0 of held vertices: those of earlier solves; then of this one and the last.
// Scratch: memory, made for the elements.
// Returns: the iterations, without the way along the guess, and the recursive residual; the true one is not computed.
// Errors:  std::bad_alloc.
// Arrays are padded.
//
// Source: Bridson, Marino and Fedkiw 2003, section 2; [ITJ07] "Production Cloth".
#pragma once

#include <utility>

#include "common/linear/conjugate_gradients.h"
#include "common/production_cloth/forces.h"

namespace lockstep::production_cloth {

// At most two vectors are multiplied by D at once: v and the guess.
inline constexpr int damped_at_once = 2;

namespace openmp {

struct DampingRoom {
  Array<float> q;                               // A p
  Array<float> inverse_mass;                    // 1/kg; 0 of held vertices
  Array<float> membrane_parts[damped_at_once];  // records, by place
  Array<float> pushes[damped_at_once];          // [place]: pushes_of_facet
  Array<float> facet_normals;                   // [16 (3 block + c) + lane]
  Array<float> normals;                         // [16 (3 item + c) + lane]: of facets, at each vertex's corners
  Array<double> sums;                           // [block]: whole cache lines
};

}  // namespace openmp

// Vectors of the serial solve are records as those of Changes. In openmp component c of lane l of slice s stands at
// 16 (3 s + c) + l.
template <class Real>
struct DampingMemory {
  Array<Real> b, x;                   // the right-hand side, then the residual; the change of velocity
  Array<Real> guess;                  // in openmp then the direction
  Array<Real> rates[damped_at_once];  // [place]: of folding triangles, about their sides
  Array<Real> pulls[damped_at_once];  // serial: -D v
  openmp::DampingRoom room = {};      // of openmp alone
};

template <class Real>
using DampingSolve = linear::Solution(const Elements<Real>& elements, const State<Real>& state, const Array<Real>& mass,
                                      const Array<Real>& inverse_mass, Real half_step, const Vectors<Real>& force,
                                      const linear::Stop& stop, Vectors<Real>& velocity, Changes<Real>& changes,
                                      DampingMemory<Real>& memory);

namespace serial {
DampingMemory<float> make_damping_memory(const Elements<float>& elements);
DampingMemory<double> make_damping_memory(const Elements<double>& elements);
DampingSolve<float> damping_solve;
DampingSolve<double> damping_solve;
}  // namespace serial

namespace openmp {
DampingMemory<float> make_damping_memory(const Elements<float>& elements);
DampingSolve<float> damping_solve;
}  // namespace openmp

// --- Formulas; of a number or of lanes

// The damping of membranes whose F is f, by the velocities of their corners.
template <class T, class Real>
inline Parts<T, 3> damping_of_membrane(const Elements<Real>& elements, const Membrane<T>& m, const Columns<T>& f,
                                       const Vector3<T>& v0, const Vector3<T>& v1, const Vector3<T>& v2) {
  const Columns<T> rate = deformation_of(m, v1 - v0, v2 - v0);
  const T share(elements.membrane_damping);
  return parts_of_membrane(m, damping_stress(share * T(elements.lambda), share * T(elements.mu), f, rate));
}

// Whether a solve begins with a guess.
template <class Real>
inline bool has_guess(const Changes<Real>& changes) {
  return changes.weight[0] != 0 || changes.weight[1] != 0;
}

// Makes the change x, which stands in `before`, the last one. The others are dot products: y was the last change until
// then, and z the one before it. The next weights are those of y and z in what is nearest to x in the 2-norm. Where y
// and z are parallel but for a thousandth, or one is 0: all of x, if it is not 0.
template <class Real>
inline void keep_change(Changes<Real>& changes, double xx, double xy, double xz, double yy, double yz, double zz) {
  const double determinant = yy * zz - yz * yz;
  if (determinant > 1e-6 * (yy * zz))
    changes.weight = {static_cast<Real>((xy * zz - xz * yz) / determinant),
                      static_cast<Real>((xz * yy - xy * yz) / determinant)};
  else
    changes.weight = {Real(xx > 0 ? 1 : 0), 0};
  std::swap(changes.last, changes.before);
}

}  // namespace lockstep::production_cloth
