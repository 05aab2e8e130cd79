// The state of rigid bodies: bodies that move, colliders that are fixed to them and have a shape, and the hulls of
// these shapes.
//
// Every convex shape is a hull, scaled along its axes and rounded by a radius: a sphere is a point, a capsule a
// segment, a box a cube. Compounds are bodies with several colliders. A triangle mesh is a static body with one
// collider per triangle ([LRB08] "Collision Detection" names both ways for shapes that are not convex).
//
// The World owns all arrays. Elements beyond the counts are padding for lanes, which no result depends on.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/array.h"
#include "common/rigid/rotation.h"
#include "common/vector3.h"

namespace lockstep::rigid {

// Four numbers, which lanes load whole.
template <class Real>
struct alignas(4 * sizeof(Real)) Quad {
  Real x, y, z, w;
};
template <class T>
inline Vector3<T> vector_of(const Quad<T>& quad) {
  return {quad.x, quad.y, quad.z};
}

// The velocity of a body's centre of mass, m/s, and its angular velocity, rad/s, both along the axes of the world.
template <class Real>
struct alignas(8 * sizeof(Real)) Motion {
  Vector3<Real> velocity;
  Vector3<Real> angular_velocity;
  Real unused[2];
};

template <class Real>
struct Bodies {
  int count = 0;
  Array<Pose<Real>> pose;          // [body]: of the centre of mass; the axes are the principal axes of inertia
  Array<Motion<Real>> motion;      // [body]
  Array<Quad<Real>> inverse_mass;  // [body]: x y z: of inertia about the axes, 1 / (kg m^2); w: of mass, 1 / kg;
                                   //   all 0 for a static body
  Array<Real> friction;            // [body]: >= 0; of a contact, sqrt(of one times of the other)
  Array<Real> restitution;         // [body]: 0 .. 1; of a contact, the larger
};

enum class Kind : std::int32_t { sphere, capsule, box, hull, triangle, plane };
inline constexpr int kinds = 6;

// The colliders of a body stand together, in the order of bodies.
template <class Real>
struct Colliders {
  int count = 0;
  Array<std::int32_t> kind;   // [collider]: a Kind
  Array<std::int32_t> body;   // [collider]
  Array<std::int32_t> group;  // [collider]: its body, or -1 if that is static: two of one group never collide
  Array<Pose<Real>> local;    // [collider]: relative to the body
  Array<std::int32_t> hull;   // [collider]: which hull it is; a plane has none, -1
  Array<Quad<Real>> size;     // [collider]: x y z: the hull's scale along its axes; w: the radius it is rounded by, m.
                              //   sphere 0 0 0 r; capsule 0 h 0 r (h: half the segment, along y);
                              //   box: half sides and 0; hull and triangle 1 1 1 0;
                              //   plane 0 0 0 0: what is below its local y = 0 is solid
};

// All hulls, one behind the other. Hull h has vertices first_vertex[h] .. first_vertex[h + 1] - 1 and faces
// first_face[h] .. first_face[h + 1] - 1. Face f has corners first_corner[f] .. first_corner[f + 1] - 1,
// counterclockwise from outside. Corners are numbered within their hull. Hulls 0, 1 and 2 are the point, the segment
// from -y to +y and the cube, all of half size 1. The point and the segment have no face. A triangle has two, one per
// side.
template <class Real>
struct Hulls {
  int count = 0;
  int most_vertices = 0;     // of any hull
  Array<Quad<Real>> vertex;  // x y z, m; w 0
  Array<Quad<Real>> plane;   // [face]: outward unit normal, and its distance from the origin
  Array<std::int32_t> corner;
  Array<std::int32_t> first_vertex, first_face, first_corner;
  Array<Quad<Real>> centre, half;  // [hull]: the box around it, along its axes; w 0

  int vertices(int hull) const { return first_vertex[hull + 1] - first_vertex[hull]; }
  int faces(int hull) const { return first_face[hull + 1] - first_face[hull]; }
};
inline constexpr int point_hull = 0, segment_hull = 1, cube_hull = 2;
// Whether a hull fills the box around it. If so, the box around this turned box is as tight as the one around the
// turned hull.
template <class I>
inline auto fills_its_box(const I& hull) {
  return hull <= cube_hull;
}
inline constexpr int most_hull_vertices = 64;  // a hull has no more

template <class Real>
struct World {
  Bodies<Real> bodies;
  Colliders<Real> colliders;
  Hulls<Real> hulls;
};

// What the narrow phase reads of a world: the shapes, and their poses from place_colliders.
template <class Real>
struct Placed {
  const Colliders<Real>& colliders;
  const Hulls<Real>& hulls;
  std::span<const Pose<Real>> pose;  // [collider]
};

}  // namespace lockstep::rigid
