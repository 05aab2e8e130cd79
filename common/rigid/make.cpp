// Eigen calls fused multiply-adds where the machine has them. Without its lanes, a world has the same bits on every machine.
#define EIGEN_DONT_VECTORIZE
#include "common/rigid/make.h"

// Qhull's C headers.
extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <eigen3/Eigen/Dense>
#include <initializer_list>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "common/convert.h"

namespace lockstep::rigid {
namespace {

using Vector = Vector3<double>;
using Matrix = Eigen::Matrix3d;

constexpr Pose<double> inert_pose = no_offset;

// --- Arrays that grow and stay padded

template <class T>
void put(Array<T>& array, int at, const T& value, const T& inert) {
  array.resize(padded(at + 1), inert);
  array[at] = value;
}

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

// An array of beginnings, with one more at its end: whatever is beyond is empty.
void put_end(Array<std::int32_t>& first, int count, int end) {
  first.resize(padded(count + 1));
  std::fill(first.begin() + count, first.end(), end);
}

// --- Hulls

using Face = std::vector<int>;  // corners, counterclockwise from outside

double length(const Vector& v) { return std::sqrt(dot(v, v)); }

// Newell's normal, of the length of twice the area: exact of flat faces, and the mean of faces that are flat but for rounding.
Vector normal_of(const Face& face, std::span<const Vector> points) {
  Vector sum{0, 0, 0};
  const Vector& origin = points[face[0]];
  for (std::size_t k = 1; k + 1 < face.size(); ++k) sum = sum + cross(points[face[k]] - origin, points[face[k + 1]] - origin);
  return sum;
}

int put_hull(Hulls<double>& hulls, std::span<const Vector> vertices, std::span<const Face> faces) {
  const int hull = hulls.count++;
  const int first_vertex = hulls.first_vertex[hull], first_face = hulls.first_face[hull];
  Vector low = vertices[0], high = vertices[0];
  int end = first_vertex;
  for (const Vector& v : vertices) {
    put(hulls.vertex, end++, {v.x, v.y, v.z, 0}, {});
    low = {std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z)};
    high = {std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z)};
  }
  put_end(hulls.first_vertex, hulls.count, end);

  int face_end = first_face, corner_end = hulls.first_corner[first_face];
  for (const Face& face : faces) {
    const Vector n = normal_of(face, vertices);
    const double scale = 1 / length(n);
    const Vector unit = scale * n;
    // Through the farthest vertex: then none is outside by more than the rounding of one product.
    double distance = dot(unit, vertices[face[0]]);
    for (const Vector& v : vertices) distance = std::max(distance, dot(unit, v));
    put(hulls.plane, face_end++, {unit.x, unit.y, unit.z, distance}, {});
    for (const int corner : face) put(hulls.corner, corner_end++, corner, 0);
    put_end(hulls.first_corner, face_end, corner_end);
  }
  put_end(hulls.first_face, hulls.count, face_end);

  put(hulls.centre, hull, {.5 * (low.x + high.x), .5 * (low.y + high.y), .5 * (low.z + high.z), 0}, {});
  put(hulls.half, hull, {.5 * (high.x - low.x), .5 * (high.y - low.y), .5 * (high.z - low.z), 0}, {});
  hulls.most_vertices = std::max(hulls.most_vertices, static_cast<int>(vertices.size()));
  return hull;
}

// Coplanar to within this, of the extent, triangles are one face: coordinates written with six digits are no better.
constexpr double flat = 1e-6;

// Qhull's faces, of points from -1 to 1; empty where it finds them flat.
std::vector<Face> qhull_faces(std::vector<Vector>& points, const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> nowhere(std::fopen("/dev/null", "w"), std::fclose);
  qhT qhull{};
  qhT* qh = &qhull;  // the name that Qhull's macros expect
  qh_zero(qh, nowhere.get());
  std::vector<Face> faces;
  if (qh_new_qhull(qh, 3, static_cast<int>(points.size()), &points[0].x, False, const_cast<char*>(command.c_str()), nowhere.get(),
                   nowhere.get()) == 0) {
    facetT* facet;
    FORALLfacets {
      Face& face = faces.emplace_back();
      setT* corners = qh_facet3vertex(qh, facet);
      vertexT *vertex, **vertexp;
      FOREACHvertex_(corners) face.push_back(qh_pointid(qh, vertex->point));
      qh_settempfree(qh, &corners);
      std::ranges::reverse(face);  // Qhull's are clockwise
    }
  }
  qh_freeqhull(qh, !qh_ALL);
  int blocks, bytes;
  qh_memfreeshort(qh, &blocks, &bytes);
  return faces;
}

// How well faces fit the points that they are the hull of.
struct Fit {
  double depth = std::numeric_limits<double>::infinity();  // of all points behind a face, the least
  double error = 0;                                        // how far a point is outside of a face, or a corner beside its own
};

Fit fit_of(std::span<const Face> faces, std::span<const Vector> points) {
  Fit fit;
  for (const Face& face : faces) {
    const Vector n = normal_of(face, points);
    const double scale = 1 / length(n);
    double least = 0;
    for (const Vector& p : points) {
      const double outside = scale * dot(n, p - points[face[0]]);
      least = std::min(least, outside);
      fit.error = std::max(fit.error, outside);
    }
    for (const int corner : face) fit.error = std::max(fit.error, std::abs(scale * dot(n, points[corner] - points[face[0]])));
    fit.depth = std::min(fit.depth, -least);
  }
  return fit;
}

// The faces of the convex hull, of points from -1 to 1; empty where they are flat.
std::vector<Face> hull_faces(std::vector<Vector>& points) {
  // C1e-6: when the hull is done, merge what is coplanar to within 1e-6. Where slivers hang together, that may turn a face out of its
  // plane; then what is merged is only what is coplanar to within rounding.
  std::vector<Face> faces = qhull_faces(points, "qhull C1e-6");
  if (!(fit_of(faces, points).error <= 2 * hull_error)) faces = qhull_faces(points, "qhull");
  if (!(fit_of(faces, points).depth > 2 * flat)) faces.clear();
  return faces;
}

// --- Mass

// Of a solid of density 1: its volume, m^3, centre, m, and inertia about the centre, kg m^2.
struct Solid {
  double volume;
  Eigen::Vector3d centre;
  Matrix inertia;
};

Eigen::Vector3d eigen(const Vector& v) { return {v.x, v.y, v.z}; }
Vector plain(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Eigen::Quaterniond eigen(const Quaternion<double>& q) { return {q.w, q.x, q.y, q.z}; }

// From second moments (the integral of x x^T) to inertia.
Matrix inertia_of(const Matrix& moments) { return moments.trace() * Matrix::Identity() - moments; }
// What a mass 1 at an offset has.
Matrix inertia_at(const Eigen::Vector3d& offset) { return inertia_of(offset * offset.transpose()); }

Solid sphere_solid(double r) {
  const double volume = 4 * std::numbers::pi / 3 * r * r * r;
  return {volume, {0, 0, 0}, .4 * volume * r * r * Matrix::Identity()};
}

// A cylinder and two half balls. The centre of a half ball is 3/8 r from its disc, 83/320 m r^2 its inertia about it, across.
Solid capsule_solid(double h, double r) {
  const double cylinder = 2 * std::numbers::pi * r * r * h, balls = 4 * std::numbers::pi / 3 * r * r * r, arm = h + .375 * r;
  const double along = (.5 * cylinder + .4 * balls) * r * r;
  const double across = cylinder * (.25 * r * r + h * h / 3) + balls * (83. / 320 * r * r + arm * arm);
  return {cylinder + balls, {0, 0, 0}, Eigen::Vector3d(across, along, across).asDiagonal()};
}

Solid box_solid(const Quad<double>& half) {
  const double volume = 8 * half.x * half.y * half.z;
  const Eigen::Vector3d squares(half.x * half.x, half.y * half.y, half.z * half.z);
  return {volume, {0, 0, 0}, inertia_of(volume / 3 * Matrix(squares.asDiagonal()))};
}

// The hull cut into tetrahedra, from the middle of its box to triangles of its faces. Of the tetrahedron 0 a b c, of volume V, the
// second moments are V / 20 (a a^T + b b^T + c c^T + s s^T), s = a + b + c.
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

// Of a collider, in its own axes.
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

// Of a collider, in the axes of its body.
Solid solid_of(const World<double>& world, int collider) {
  const Solid solid = shape_solid(world, collider);
  const Pose<double>& local = world.colliders.local[collider];
  const Matrix turn = eigen(local.orientation).toRotationMatrix();
  return {solid.volume, eigen(local.position) + turn * solid.centre, turn * solid.inertia * turn.transpose()};
}

// All colliders from the first on, as if apart.
Solid solid_of_all(const World<double>& world, int first_collider) {
  std::vector<Solid> solids;
  for (int i = first_collider; i < world.colliders.count; ++i) solids.push_back(solid_of(world, i));
  Solid all{0, Eigen::Vector3d::Zero(), Matrix::Zero()};
  for (const Solid& solid : solids) all.volume += solid.volume, all.centre += solid.volume * solid.centre;
  all.centre /= all.volume;
  for (const Solid& solid : solids) all.inertia += solid.inertia + solid.volume * inertia_at(solid.centre - all.centre);
  return all;
}

// Of the sums above, for up to thousands of colliders: their rounding is about the number of terms times 1e-16.
constexpr double rounding = 1e-12;

// The turn from the body's axes to principal axes: none where they are principal already.
Eigen::Quaterniond principal_axes(const Matrix& inertia) {
  const double off = std::max({std::abs(inertia(0, 1)), std::abs(inertia(0, 2)), std::abs(inertia(1, 2))});
  if (off <= rounding * inertia.trace()) return Eigen::Quaterniond::Identity();
  Matrix axes = Eigen::SelfAdjointEigenSolver<Matrix>(inertia).eigenvectors();
  if (axes.determinant() < 0) axes.col(2) = -axes.col(2);
  return Eigen::Quaterniond(axes).normalized();
}

// The body's origin moves to an offset, its axes turn, and its colliders stay.
void move_origin(World<double>& world, int body, int first_collider, const Eigen::Vector3d& offset, const Eigen::Quaterniond& turn) {
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
  // -x, +x, -y, +y, -z, +z
  put_hull(world.hulls, cube, std::vector<Face>{{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}});
  return world;
}

int make_hull(Hulls<double>& hulls, std::span<const Vector3<double>> points) {
  const auto wrong = [](const std::string& what) { return std::invalid_argument(what); };
  if (points.size() < 4) throw wrong(std::to_string(points.size()) + " points, a hull has at least 4");
  Vector low = points[0], high = points[0];
  for (const Vector& p : points) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) throw wrong("a point is not finite");
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }

  // From -1 to 1, wherever and however large: Qhull's tolerances are those of coordinates.
  const Vector middle = {.5 * (low.x + high.x), .5 * (low.y + high.y), .5 * (low.z + high.z)};
  const double half_extent = .5 * std::max({high.x - low.x, high.y - low.y, high.z - low.z});
  std::vector<Vector> scaled;
  for (const Vector& p : points) scaled.push_back(half_extent > 0 ? 1 / half_extent * (p - middle) : Vector{0, 0, 0});
  std::vector<Face> faces = hull_faces(scaled);
  if (faces.empty()) throw wrong("the points are flat");

  // Vertices in the order of the points, faces in the order of their corners, the lowest first: whatever Qhull's order was.
  std::map<int, int> vertex_of;  // point
  for (const Face& face : faces)
    for (const int point : face) vertex_of[point];
  std::vector<Vector> vertices;
  for (auto& [point, vertex] : vertex_of) vertex = static_cast<int>(vertices.size()), vertices.push_back(points[point]);
  if (vertices.size() > most_hull_vertices)
    throw wrong("a hull of " + std::to_string(vertices.size()) + " vertices, at most " + std::to_string(most_hull_vertices));
  for (Face& face : faces) {
    for (int& corner : face) corner = vertex_of[corner];
    std::rotate(face.begin(), std::ranges::min_element(face), face.end());
  }
  std::ranges::sort(faces);
  return put_hull(hulls, vertices, faces);
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

void add_hull(World<double>& world, int hull, const Pose<double>& local) { add_collider(world, Kind::hull, hull, {1, 1, 1, 0}, local); }

void add_plane(World<double>& world, const Pose<double>& local) { add_collider(world, Kind::plane, -1, {}, local); }

void add_mesh(World<double>& world, const Mesh& mesh, const Pose<double>& local) {
  const Matrix3<double> turn = matrix_of(local.orientation);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Vector &p = mesh.points[a], &q = mesh.points[b], &r = mesh.points[c];
    const Vector ab = q - p, ac = r - p, normal = cross(ab, ac);
    if (!(dot(normal, normal) > flat * flat * dot(ab, ab) * dot(ac, ac)))
      throw std::invalid_argument("triangle " + std::to_string(t + 1) + " is thinner than a plane needs");
    // Around its own middle, so that float keeps its shape wherever in the mesh it is.
    const Vector middle = .5 * (Vector{std::min({p.x, q.x, r.x}), std::min({p.y, q.y, r.y}), std::min({p.z, q.z, r.z})} +
                                Vector{std::max({p.x, q.x, r.x}), std::max({p.y, q.y, r.y}), std::max({p.z, q.z, r.z})});
    const int hull =
        put_hull(world.hulls, std::vector<Vector>{p - middle, q - middle, r - middle}, std::vector<Face>{{0, 1, 2}, {0, 2, 1}});
    add_collider(world, Kind::triangle, hull, {1, 1, 1, 0}, {local.position + turn * middle, local.orientation, 0});
  }
}

void finish_body(World<double>& world, const Heaviness& heaviness) {
  const int body = world.bodies.count - 1;
  int first = world.colliders.count;
  while (first > 0 && world.colliders.body[first - 1] == body) --first;
  if (heaviness.mass == 0 && heaviness.density == 0) return;  // static, and as it is

  if (first == world.colliders.count) throw std::invalid_argument("a body without a shape cannot move");
  const Solid solid = solid_of_all(world, first);
  const double density = heaviness.density > 0 ? heaviness.density : heaviness.mass / solid.volume;
  const Eigen::Quaterniond turn = principal_axes(solid.inertia);
  const Matrix axes = turn.toRotationMatrix();
  const Eigen::Vector3d principal = density * (axes.transpose() * solid.inertia * axes).diagonal();
  world.bodies.inverse_mass[body] = {1 / principal.x(), 1 / principal.y(), 1 / principal.z(), 1 / (density * solid.volume)};
  for (int i = first; i < world.colliders.count; ++i) world.colliders.group[i] = body;

  const bool centred = solid.centre.norm() <= rounding * std::cbrt(solid.volume);
  const bool turned = turn.vec().norm() > 0;
  if (!centred || turned) move_origin(world, body, first, centred ? Eigen::Vector3d(0, 0, 0) : solid.centre, turn);
}

// --- Another precision

namespace {

template <class To, class From>
Quaternion<To> convert(const Quaternion<From>& q) {
  return {static_cast<To>(q.x), static_cast<To>(q.y), static_cast<To>(q.z), static_cast<To>(q.w)};
}

template <class To, class From>
Array<Quad<To>> convert(const Array<Quad<From>>& quads) {
  Array<Quad<To>> to;
  for (const auto& [x, y, z, w] : quads) to.push_back({static_cast<To>(x), static_cast<To>(y), static_cast<To>(z), static_cast<To>(w)});
  return to;
}

template <class To, class From>
Array<Pose<To>> convert(const Array<Pose<From>>& poses) {
  Array<Pose<To>> to;
  for (const Pose<From>& pose : poses) to.push_back({lockstep::convert<To>(pose.position), convert<To>(pose.orientation), 0});
  return to;
}

template <class To, class From>
Array<Motion<To>> convert(const Array<Motion<From>>& motions) {
  Array<Motion<To>> to;
  for (const Motion<From>& m : motions)
    to.push_back({lockstep::convert<To>(m.velocity), lockstep::convert<To>(m.angular_velocity), {0, 0}});
  return to;
}

}  // namespace

template <class To, class From>
World<To> convert(const World<From>& world) {
  const Bodies<From>& b = world.bodies;
  const Colliders<From>& c = world.colliders;
  const Hulls<From>& h = world.hulls;
  return {.bodies = {b.count, convert<To>(b.pose), convert<To>(b.motion), convert<To>(b.inverse_mass), lockstep::convert<To>(b.friction),
                     lockstep::convert<To>(b.restitution)},
          .colliders = {c.count, c.kind, c.body, c.group, convert<To>(c.local), c.hull, convert<To>(c.size)},
          .hulls = {h.count, h.most_vertices, convert<To>(h.vertex), convert<To>(h.plane), h.corner, h.first_vertex, h.first_face,
                    h.first_corner, convert<To>(h.centre), convert<To>(h.half)}};
}

template World<float> convert(const World<double>&);
template World<double> convert(const World<float>&);

}  // namespace lockstep::rigid
