// How big and how fine a cloth may be.
#pragma once

#include <string>

#include "common/cloth/cloth.h"

namespace lockstep::cloth {

// Particles, constraints and corners are counted in int32; a particle of a sheet begins up to 6 constraints, a triangle
// 6 as well.
inline constexpr double max_particles = 1 << 28;
inline constexpr double max_triangles = 1 << 28;

// Lengths and masses beyond these would leave the range of float where they are squared and multiplied.
inline constexpr double smallest = 1e-9;
inline constexpr double largest = 1e9;

// Bytes to make a cloth in double and keep it in float, too.
double making_bytes(double particles, double constraints, double triangles, double most_constraints_of_a_particle);

// Throw InputError unless a sheet or a mesh is within the limits above and fits this machine's memory. To be called
// before the cloth is made. `where` opens the message: the place at fault. triangles_around: the largest number of
// triangles at one point; copies: how many such cloths there will be.
void require_sheet_size(double rows, double columns, int copies, const std::string& where);
void require_mesh_size(double points, double triangles, double triangles_around, int copies, const std::string& where);

// Throws InputError where a constraint is shorter or longer than the limits above: of two particles at one place, say.
void require_lengths(const Cloth<double>& cloth, const std::string& where);

}  // namespace lockstep::cloth
