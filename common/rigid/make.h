// Makes worlds, body by body, in double, for scenes and tests.
//
// All arrays are padded (common/array.h) at all times. Padding holds static bodies, spheres of radius 0 in no group,
// and hulls without vertices.
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

// Returns a world without bodies, with the hulls that all worlds have: point, segment, cube.
World<double> make_world();

// How far points are outside of a hull's faces at most, and corners off their own face, relative to the hull's extent.
inline constexpr double hull_error = 2e-6;

// Adds the convex hull of points, m, to `hulls` and returns its number. Triangles that are coplanar to within 1e-6 of
// the points' extent become one face, where that keeps to hull_error. Vertices keep the order of the points. Faces are
// in the order of their corners, the lowest first. Throws std::invalid_argument, saying what is wrong, if there are
// fewer than four points, if a point is not finite, if the points are flat to within 1e-6 of their extent, or if the
// hull has more than most_hull_vertices.
int make_hull(Hulls<double>& hulls, std::span<const Vector3<double>> points);

// How heavy a body is. Nothing moves a static one.
struct Heaviness {
  double mass, density;  // kg, kg/m^3: one of them > 0; a static body has neither
};
constexpr Heaviness of_mass(double mass) { return {mass, 0}; }
constexpr Heaviness of_density(double density) { return {0, density}; }
constexpr Heaviness immovable = {0, 0};

struct Surface {
  double friction = .5, restitution = 0;
};

// Begins a body and returns its number. `pose` is that of the body's own origin, `motion` the velocities there.
// Colliders are relative to this origin until the body is finished.
int begin_body(World<double>& world, const Pose<double>& pose, const Motion<double>& motion = {},
               const Surface& surface = {});
// These add colliders to the body begun last. `local` is their pose relative to it.
void add_sphere(World<double>& world, double radius, const Pose<double>& local = no_offset);
// `half` is half the segment, along y.
void add_capsule(World<double>& world, double half, double radius, const Pose<double>& local = no_offset);
void add_box(World<double>& world, const Vector3<double>& half, const Pose<double>& local = no_offset);
void add_hull(World<double>& world, int hull, const Pose<double>& local = no_offset);
// Solid below local y = 0. For static bodies only.
void add_plane(World<double>& world, const Pose<double>& local = no_offset);
// Adds one collider per triangle, around the middle of the triangle's own box. For static bodies only. Throws
// std::invalid_argument if a triangle is too thin to have a plane: if its height above its longest edge is not more
// than 1e-6 of that edge.
void add_mesh(World<double>& world, const Mesh& mesh, const Pose<double>& local = no_offset);
// Computes mass, inertia and principal axes of the body begun last, as if its colliders were solid and did not overlap.
// The body's origin moves to the centre of mass, and its axes turn to the principal axes, unless they are there already
// to within rounding. Colliders stay where they are in the world. Throws std::invalid_argument if a body that is not
// static has no collider, or has a plane or a mesh.
void finish_body(World<double>& world, const Heaviness& heaviness);

// Converts a world to another precision. Widening is exact.
template <class To, class From>
World<To> convert(const World<From>& world);

}  // namespace lockstep::rigid
