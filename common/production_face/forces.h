// Contract: the forces of a strained body on its nodes, f = -dE/du, in N.
//
//   f_n = sum over the tetrahedra with node n, in their order, of their forces on it (element_forces.h)
//
// summed from 0. The tetrahedra that fill up the last block give none.
// Held nodes feel what the flesh does to the bones.
//
// In:  body; strained, what update_state makes of it; its stress holds that of the muscles.
//      waves, made from the body.
// Out: force, 3 a node (parts.h). The `parts` of openmp's forces (make_parts) is scratch.
// Source: [ITJ07] "Production Face"; Teran, Sifakis, Irving and Fedkiw, Robust quasistatic finite elements and flesh
//         simulation, SCA 2005.
#pragma once

#include <span>

#include "common/production_face/element_forces.h"
#include "common/production_face/waves.h"

namespace lockstep::production_face {

template <class Real>
using Forces = void(const Body<Real>& body, const Strained<Real>& strained, std::span<Real> force);

namespace serial {
Forces<float> forces;
Forces<double> forces;
}  // namespace serial

namespace openmp {
void forces(const Body<float>& body, const Strained<float>& strained, const Waves& waves, Array<float>& parts,
            std::span<float> force);
// Each addition under its node's lock, in the order in which threads come: rounding depends on it.
Forces<float> forces_locks;
}  // namespace openmp

}  // namespace lockstep::production_face
