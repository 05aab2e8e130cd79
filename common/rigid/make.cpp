// Worlds, made body by body. Masses: common/rigid/mass.cpp; hulls: common/rigid/hulls.cpp.
#include "common/rigid/make.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/arrays.h"
#include "common/rigid/arrays.h"
#include "common/rigid/hulls.h"

namespace lockstep::rigid {
namespace {

using Vector = Vector3<double>;

constexpr Pose<double> inert_pose = no_offset;

void begin_arrays(World<double>& world) {
  const std::size_t n = padded(0);
  Bodies<double>& bodies = world.bodies;
  bodies.pose.assign(n, inert_pose), bodies.motion.resize(n), bodies.inverse_mass.resize(n);
  bodies.friction.resize(n), bodies.restitution.resize(n);
  Colliders<double>& colliders = world.colliders;
  colliders.kind.resize(n), colliders.body.resize(n), colliders.group.assign(n, -1);
  colliders.local.assign(n, inert_pose), colliders.hull.resize(n), colliders.size.resize(n);
  Hulls<double>& hulls = world.hulls;
  hulls.vertex.resize(n), hulls.plane.resize(n), hulls.corner.resize(n);
  hulls.first_vertex.resize(padded(1)), hulls.first_face.resize(padded(1)), hulls.first_corner.resize(padded(1));
  hulls.centre.resize(n), hulls.half.resize(n);
}

void add_collider(World<double>& world, Kind kind, int hull, const Quad<double>& size, const Pose<double>& local) {
  Colliders<double>& colliders = world.colliders;
  const int i = colliders.count++;
  put(colliders.kind, i, static_cast<std::int32_t>(kind), 0);
  put(colliders.body, i, world.bodies.count - 1, 0);
  put(colliders.group, i, -1, -1);
  put(colliders.local, i, local, inert_pose);
  put(colliders.hull, i, hull, point_hull);
  put(colliders.size, i, size, {});
}

}  // namespace

// --- Worlds

World<double> make_world() {
  World<double> world;
  begin_arrays(world);
  put_hull(world.hulls, std::vector<Vector>{{0, 0, 0}}, {});
  put_hull(world.hulls, std::vector<Vector>{{0, -1, 0}, {0, 1, 0}}, {});
  std::vector<Vector> cube;  // vertex 4 z + 2 y + x, from - to +
  for (const double z : {-1., 1.})
    for (const double y : {-1., 1.})
      for (const double x : {-1., 1.}) cube.push_back({x, y, z});
  // faces: -x, +x, -y, +y, -z, +z
  put_hull(world.hulls, cube,
           std::vector<Face>{{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}});
  return world;
}

int begin_body(World<double>& world, const Pose<double>& pose, const Motion<double>& motion, const Surface& surface) {
  Bodies<double>& bodies = world.bodies;
  const int i = bodies.count++;
  put(bodies.pose, i, pose, inert_pose);
  put(bodies.motion, i, motion, {});
  put(bodies.inverse_mass, i, {}, {});
  put(bodies.friction, i, surface.friction, 0.);
  put(bodies.restitution, i, surface.restitution, 0.);
  return i;
}

void add_sphere(World<double>& world, double radius, const Pose<double>& local) {
  add_collider(world, Kind::sphere, point_hull, {0, 0, 0, radius}, local);
}

void add_capsule(World<double>& world, double half, double radius, const Pose<double>& local) {
  add_collider(world, Kind::capsule, segment_hull, {0, half, 0, radius}, local);
}

void add_box(World<double>& world, const Vector3<double>& half, const Pose<double>& local) {
  add_collider(world, Kind::box, cube_hull, {half.x, half.y, half.z, 0}, local);
}

void add_hull(World<double>& world, int hull, const Pose<double>& local) {
  add_collider(world, Kind::hull, hull, {1, 1, 1, 0}, local);
}

void add_plane(World<double>& world, const Pose<double>& local) { add_collider(world, Kind::plane, -1, {}, local); }

void add_mesh(World<double>& world, const Mesh& mesh, const Pose<double>& local) {
  const Matrix3<double> turn = matrix_of(local.orientation);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vector &p = mesh.points[a], &q = mesh.points[b], &r = mesh.points[c];
    const Vector ab = q - p, ac = r - p, bc = r - q, normal = cross(ab, ac);
    const double longest_2 = std::max({dot(ab, ab), dot(ac, ac), dot(bc, bc)});
    if (!(dot(normal, normal) > flat * flat * longest_2 * longest_2))
      throw std::invalid_argument("triangle " + std::to_string(t + 1) + " is thinner than a plane needs");
    // The hull is around its own middle, so that float keeps its shape far from the mesh's origin, too.
    const Vector middle =
        .5 * (Vector{std::min({p.x, q.x, r.x}), std::min({p.y, q.y, r.y}), std::min({p.z, q.z, r.z})} +
              Vector{std::max({p.x, q.x, r.x}), std::max({p.y, q.y, r.y}), std::max({p.z, q.z, r.z})});
    const int hull = put_hull(world.hulls, std::vector<Vector>{p - middle, q - middle, r - middle},
                              std::vector<Face>{{0, 1, 2}, {0, 2, 1}});
    add_collider(world, Kind::triangle, hull, {1, 1, 1, 0}, {local.position + turn * middle, local.orientation, 0});
  }
}

// --- Another precision

template <class To, class From>
World<To> convert(const World<From>& world) {
  World<To> to;
  convert_arrays<To>(world, to);
  to.bodies.count = world.bodies.count;
  to.colliders.count = world.colliders.count;
  to.hulls.count = world.hulls.count, to.hulls.most_vertices = world.hulls.most_vertices;
  return to;
}

template World<float> convert(const World<double>&);
template World<double> convert(const World<float>&);

}  // namespace lockstep::rigid
