// Worlds, made body by body, in double: by scenes and by tests.
//
// All arrays are padded (common/array.h) at all times; padding is no body, a sphere of no size in no group, and hulls without vertices.
//
// A body is begun, gets its colliders, and is finished with its mass:
//
//   World<double> world = make_world();
//   begin_body(world, pose);
//   add_box(world, {.5, .5, .5});
//   finish_body(world, of_mass(1));
#pragma once

#include <span>

#include "common/mesh.h"
#include "common/rigid/world.h"

namespace lockstep::rigid {

inline constexpr Quaternion<double> no_rotation = {0, 0, 0, 1};
inline constexpr Pose<double> no_offset = {{0, 0, 0}, no_rotation, 0};

// No bodies, and the hulls that all worlds have: point, segment, cube.
World<double> make_world();

// Of the extent of a hull: how far at most points are outside of its faces, and corners beside their own.
inline constexpr double hull_error = 2e-6;

// The convex hull of points, m, in the library; its number. What is coplanar to within 1e-6 of their extent is one face, where that keeps
// to hull_error. Vertices keep the order of the points; faces are in the order of their corners, the lowest first. Throws
// std::invalid_argument, saying what is wrong, where points are fewer than four, not finite, or flat to within 1e-6 of their extent, or the
// hull has more than most_hull_vertices.
int make_hull(Hulls<double>& hulls, std::span<const Vector3<double>> points);

// How heavy a body is: nothing moves a static one.
struct Heaviness {
  double mass, density;  // kg, kg/m^3: one of them > 0, or none of a static body
};
constexpr Heaviness of_mass(double mass) { return {mass, 0}; }
constexpr Heaviness of_density(double density) { return {0, density}; }
constexpr Heaviness immovable = {0, 0};

struct Surface {
  double friction = .5, restitution = 0;
};

// Where the body's own origin is, to which its colliders are relative until it is finished; velocities of that origin. Its number.
int begin_body(World<double>& world, const Pose<double>& pose, const Motion<double>& motion = {}, const Surface& surface = {});
// Colliders of the body begun last; their place relative to it.
void add_sphere(World<double>& world, double radius, const Pose<double>& local = no_offset);
void add_capsule(World<double>& world, double half, double radius, const Pose<double>& local = no_offset);  // half the segment, along y
void add_box(World<double>& world, const Vector3<double>& half, const Pose<double>& local = no_offset);
void add_hull(World<double>& world, int hull, const Pose<double>& local = no_offset);
void add_plane(World<double>& world, const Pose<double>& local = no_offset);  // solid below local y = 0; of static bodies only
// A collider a triangle, around the middle of its own box; of static bodies only. Throws std::invalid_argument where a triangle is too thin
// to have a plane: where the sine of its angle at its first corner is less than 1e-6.
void add_mesh(World<double>& world, const Mesh& mesh, const Pose<double>& local = no_offset);
// Mass, inertia and its principal axes, as if colliders were solid and apart: the body's origin moves to the centre of mass and its axes to
// the principal axes (not where they are already: within rounding), colliders stay where they are in the world. Throws
// std::invalid_argument where a body that is not static has no collider, a plane or a mesh.
void finish_body(World<double>& world, const Heaviness& heaviness);

// Rounded to another precision.
template <class To, class From>
World<To> convert(const World<From>& world);

}  // namespace lockstep::rigid
