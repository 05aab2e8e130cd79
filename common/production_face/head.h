// The shape of a head, in front of the ears. Lengths in m; x to the viewer's right, y up, z ahead; the origin is
// between the ears. All shapes are ours: ellipsoids and capsules, joined smoothly.
#pragma once

#include "common/vector3.h"

namespace lockstep::production_face {

inline constexpr double mouth_height = -.045;               // y
inline constexpr double head_radius = .09;                  // about
inline constexpr Vector3<double> eye = {.029, .026, .082};  // of the left half, where x > 0

// Distances are about those in m, negative inside, exact where they are 0. They depend on |x|.

double distance_to_skin(const Vector3<double>& p);   // as if neither eyes nor mouth were open
double distance_to_skull(const Vector3<double>& p);  // cranium and jaw
// Skin without skull, eyes, mouth, and what is behind the ears. The mouth is open by `slit`, m.
double distance_to_flesh(const Vector3<double>& p, double slit);

// Away from the skull, of length 1.
Vector3<double> skull_normal(const Vector3<double>& p);

}  // namespace lockstep::production_face
