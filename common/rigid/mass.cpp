// Mass, inertia and principal axes of bodies, from the solids that their colliders are.
//
// Spheres, capsules and boxes have closed forms. A hull is cut into tetrahedra. A body's colliders count as solids of
// one density that do not overlap; their inertias add up at the common centre (parallel axes).

// Without Eigen's lanes a world has the same bits on every machine: Eigen calls fused multiply-adds where a machine has
// them.
#define EIGEN_DONT_VECTORIZE
#include <algorithm>
#include <cmath>
#include <eigen3/Eigen/Dense>
#include <initializer_list>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "common/rigid/make.h"

namespace lockstep::rigid {
namespace {

using Vector = Vector3<double>;
using Matrix = Eigen::Matrix3d;

// A solid of density 1: volume, m^3, centre, m, and inertia about the centre, kg m^2.
struct Solid {
  double volume;
  Eigen::Vector3d centre;
  Matrix inertia;
};

Eigen::Vector3d eigen(const Vector& v) { return {v.x, v.y, v.z}; }
Vector plain(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Eigen::Quaterniond eigen(const Quaternion<double>& q) { return {q.w, q.x, q.y, q.z}; }

// Inertia from second moments (the integral of x x^T).
Matrix inertia_of(const Matrix& moments) { return moments.trace() * Matrix::Identity() - moments; }
// The inertia of a mass 1 at an offset.
Matrix inertia_at(const Eigen::Vector3d& offset) { return inertia_of(offset * offset.transpose()); }

Solid sphere_solid(double r) {
  const double volume = 4 * std::numbers::pi / 3 * r * r * r;
  return {volume, {0, 0, 0}, .4 * volume * r * r * Matrix::Identity()};
}

// A cylinder and two half balls. A half ball's centre is 3/8 r from its disc. Its inertia about an axis through that
// centre, parallel to the disc, is 83/320 m r^2.
Solid capsule_solid(double h, double r) {
  const double cylinder = 2 * std::numbers::pi * r * r * h, balls = 4 * std::numbers::pi / 3 * r * r * r,
               arm = h + .375 * r;
  const double along = (.5 * cylinder + .4 * balls) * r * r;
  const double across = cylinder * (.25 * r * r + h * h / 3) + balls * (83. / 320 * r * r + arm * arm);
  return {cylinder + balls, {0, 0, 0}, Eigen::Vector3d(across, along, across).asDiagonal()};
}

Solid box_solid(const Quad<double>& half) {
  const double volume = 8 * half.x * half.y * half.z;
  const Eigen::Vector3d squares(half.x * half.x, half.y * half.y, half.z * half.z);
  return {volume, {0, 0, 0}, inertia_of(volume / 3 * Matrix(squares.asDiagonal()))};
}

// The hull is cut into tetrahedra, from the middle of its box to triangles of its faces. A tetrahedron 0 a b c of
// volume V has the second moments V / 20 (a a^T + b b^T + c c^T + s s^T), s = a + b + c.
Solid hull_solid(const Hulls<double>& hulls, int hull) {
  const Quad<double>& c = hulls.centre[hull];
  const Eigen::Vector3d middle(c.x, c.y, c.z);
  const auto vertex = [&](int corner) {
    const Quad<double>& v = hulls.vertex[hulls.first_vertex[hull] + hulls.corner[corner]];
    return Eigen::Vector3d(Eigen::Vector3d(v.x, v.y, v.z) - middle);
  };
  double volume = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();  // moments
  Matrix second = Matrix::Zero();
  for (int face = hulls.first_face[hull]; face < hulls.first_face[hull + 1]; ++face) {
    const Eigen::Vector3d a = vertex(hulls.first_corner[face]);
    for (int k = hulls.first_corner[face] + 1; k + 1 < hulls.first_corner[face + 1]; ++k) {
      const Eigen::Vector3d b = vertex(k), c = vertex(k + 1), sum = a + b + c;
      const double v = a.dot(b.cross(c)) / 6;
      volume += v;
      first += v / 4 * sum;
      second += v / 20 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose());
    }
  }
  const Eigen::Vector3d offset = first / volume;
  return {volume, middle + offset, inertia_of(second) - volume * inertia_at(offset)};
}

// The solid of a collider, in the collider's axes.
Solid shape_solid(const World<double>& world, int collider) {
  const Quad<double>& size = world.colliders.size[collider];
  switch (static_cast<Kind>(world.colliders.kind[collider])) {
    case Kind::sphere: return sphere_solid(size.w);
    case Kind::capsule: return capsule_solid(size.y, size.w);
    case Kind::box: return box_solid(size);
    case Kind::hull: return hull_solid(world.hulls, world.colliders.hull[collider]);
    case Kind::triangle:
    case Kind::plane: break;
  }
  throw std::invalid_argument("a body with a plane or a mesh cannot move");
}

// The solid of a collider, in the axes of its body.
Solid solid_of(const World<double>& world, int collider) {
  const Solid solid = shape_solid(world, collider);
  const Pose<double>& local = world.colliders.local[collider];
  const Matrix turn = eigen(local.orientation).toRotationMatrix();
  return {solid.volume, eigen(local.position) + turn * solid.centre, turn * solid.inertia * turn.transpose()};
}

// The solid of all colliders from the first on, as if they did not overlap.
Solid solid_of_all(const World<double>& world, int first_collider) {
  std::vector<Solid> solids;
  for (int i = first_collider; i < world.colliders.count; ++i) solids.push_back(solid_of(world, i));
  Solid all{0, Eigen::Vector3d::Zero(), Matrix::Zero()};
  for (const Solid& solid : solids) all.volume += solid.volume, all.centre += solid.volume * solid.centre;
  all.centre /= all.volume;
  for (const Solid& solid : solids) all.inertia += solid.inertia + solid.volume * inertia_at(solid.centre - all.centre);
  return all;
}

// Rounding of the sums above, relative, for up to thousands of colliders: about the number of terms times 1e-16.
constexpr double rounding = 1e-12;

// The rotation from the body's axes to principal axes. It is none if they are principal already.
Eigen::Quaterniond principal_axes(const Matrix& inertia) {
  const double off = std::max({std::abs(inertia(0, 1)), std::abs(inertia(0, 2)), std::abs(inertia(1, 2))});
  if (off <= rounding * inertia.trace()) return Eigen::Quaterniond::Identity();
  Matrix axes = Eigen::SelfAdjointEigenSolver<Matrix>(inertia).eigenvectors();
  if (axes.determinant() < 0) axes.col(2) = -axes.col(2);
  return Eigen::Quaterniond(axes).normalized();
}

// Moves the body's origin to an offset and turns its axes. The colliders stay where they are in the world.
void move_origin(World<double>& world, int body, int first_collider, const Eigen::Vector3d& offset,
                 const Eigen::Quaterniond& turn) {
  const auto to_plain = [](const Eigen::Quaterniond& q) { return Quaternion<double>{q.x(), q.y(), q.z(), q.w()}; };
  Pose<double>& pose = world.bodies.pose[body];
  Motion<double>& motion = world.bodies.motion[body];
  const Eigen::Quaterniond orientation = eigen(pose.orientation);
  const Vector arm = plain(orientation * offset);
  pose.position = pose.position + arm;
  motion.velocity = motion.velocity + cross(motion.angular_velocity, arm);
  pose.orientation = to_plain((orientation * turn).normalized());
  for (int i = first_collider; i < world.colliders.count; ++i) {
    Pose<double>& local = world.colliders.local[i];
    local.position = plain(turn.conjugate() * (eigen(local.position) - offset));
    local.orientation = to_plain((turn.conjugate() * eigen(local.orientation)).normalized());
  }
}

}  // namespace

void finish_body(World<double>& world, const Heaviness& heaviness) {
  const int body = world.bodies.count - 1;
  int first = world.colliders.count;
  while (first > 0 && world.colliders.body[first - 1] == body) --first;
  if (heaviness.mass == 0 && heaviness.density == 0) return;  // static: nothing to compute

  if (first == world.colliders.count) throw std::invalid_argument("a body without a shape cannot move");
  const Solid solid = solid_of_all(world, first);
  const double density = heaviness.density > 0 ? heaviness.density : heaviness.mass / solid.volume;
  const Eigen::Quaterniond turn = principal_axes(solid.inertia);
  const Matrix axes = turn.toRotationMatrix();
  const Eigen::Vector3d principal = density * (axes.transpose() * solid.inertia * axes).diagonal();
  world.bodies.inverse_mass[body] = {1 / principal.x(), 1 / principal.y(), 1 / principal.z(),
                                     1 / (density * solid.volume)};
  for (int i = first; i < world.colliders.count; ++i) world.colliders.group[i] = body;

  const bool centred = solid.centre.norm() <= rounding * std::cbrt(solid.volume);
  const bool turned = turn.vec().norm() > 0;
  if (!centred || turned) move_origin(world, body, first, centred ? Eigen::Vector3d(0, 0, 0) : solid.centre, turn);
}

}  // namespace lockstep::rigid
