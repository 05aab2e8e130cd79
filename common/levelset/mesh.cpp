#include "common/levelset/mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "common/levelset/reach.h"

namespace lockstep::levelset {
namespace {

using Vector = Vector3<double>;

// --- Distance

double squared_distance_from_edge(const Vector& p, const Vector& a, const Vector& b) {
  const Vector ap = (p - a), ab = (b - a);
  const double length_2 = dot(ab, ab), t = length_2 > 0 ? std::clamp(dot(ap, ab) / length_2, 0., 1.) : 0;
  const Vector off = {ap.x - t * ab.x, ap.y - t * ab.y, ap.z - t * ab.z};
  return dot(off, off);
}

// The nearest point of a triangle is on an edge, unless p is above or below the triangle.
struct Plate {
  Vector a, b, c;
  Vector normal;    // of any length
  double normal_2;  // its square; 0 if the triangle is too thin to have a normal: then its edges alone count

  explicit Plate(const Vector& a, const Vector& b, const Vector& c) : a(a), b(b), c(c) {
    const Vector ab = (b - a), ac = (c - a);
    normal = cross(ab, ac);
    normal_2 = dot(normal, normal);
    if (!(normal_2 > 1e-24 * dot(ab, ab) * dot(ac, ac))) normal_2 = 0;
  }

  double squared_distance_from_plane(const Vector& p) const {
    const double along = dot((p - a), normal);
    return normal_2 > 0 ? along * along / normal_2 : 0;
  }

  double squared_distance(const Vector& p) const {
    const auto is_left_of = [&](const Vector& from, const Vector& to) {
      return dot(cross((to - from), (p - from)), normal) >= 0;
    };
    if (normal_2 > 0 && is_left_of(a, b) && is_left_of(b, c) && is_left_of(c, a)) return squared_distance_from_plane(p);
    return std::min({squared_distance_from_edge(p, a, b), squared_distance_from_edge(p, b, c),
                     squared_distance_from_edge(p, c, a)});
  }
};

// The points of an axis from `low` to `high`, m; rounding may add one at either end.
Extent points_between(double low, double high, double origin, double spacing, int n) {
  const auto point = [&](double x) {
    return static_cast<int>(std::clamp((x - origin) / spacing - .5, -1., static_cast<double>(n)));
  };
  return {std::max(point(low), 0), std::min(point(high) + 2, n)};
}

// The squared distance from the nearest triangle, up to `exact` spacings: each triangle updates the points near it.
Field<double> squared_distance(const Mesh& mesh, const Grid& grid, double exact) {
  const double most = exact * grid.spacing, most_2 = most * most;
  Field<double> least = make_field<double>(grid.nx, grid.ny, grid.nz, grid.spacing, most_2);
  for (const Triangle& t : mesh.triangles) {
    const Plate plate(mesh.points[t.a], mesh.points[t.b], mesh.points[t.c]);
    const auto near = [&](double Vector::*axis, int n) {
      const auto [low, high] = std::minmax({plate.a.*axis, plate.b.*axis, plate.c.*axis});
      return points_between(low - most, high + most, grid.origin.*axis, grid.spacing, n);
    };
    const Extent ex = near(&Vector::x, grid.nx), ey = near(&Vector::y, grid.ny), ez = near(&Vector::z, grid.nz);
    for (int z = ez.begin; z < ez.end; ++z)
      for (int y = ey.begin; y < ey.end; ++y)
        for (int x = ex.begin; x < ex.end; ++x) {
          const Vector p = grid.position(x, y, z);
          double& d = least(x, y, z);
          if (plate.squared_distance_from_plane(p) < d) d = std::min(d, plate.squared_distance(p));
        }
  }
  return least;
}

// --- Sign

// Where an edge crosses the height z: the same bits for both triangles of the edge.
Vector at_height(double z, Vector low, Vector high) {
  if (low.z > high.z) std::swap(low, high);
  const double t = (z - low.z) / (high.z - low.z);
  return {low.x + t * (high.x - low.x), low.y + t * (high.y - low.y), z};
}

// 1 at points inside, 0 outside.
//
// A plane of constant z cuts a triangle in a segment between two of its edges. A line along x crosses the triangle if
// one end of the segment is to the left of the line and the other is not. An edge contains its lower end but not its
// upper one. So at any height a triangle has no such edge or two, and all triangles around a point of the mesh agree.
// However positions round, a line leaves the mesh as often as it enters, and the crossing lies on the triangle, even on
// one that is almost parallel to the line.
Field<std::uint8_t> inside(const Mesh& mesh, const Grid& grid) {
  // At first 1 at points with an odd number of crossings between them and the point before on the line along x.
  Field<std::uint8_t> in = make_field<std::uint8_t>(grid.nx, grid.ny, grid.nz, 0, 0);
  for (const Triangle& t : mesh.triangles) {
    const Vector corner[] = {mesh.points[t.a], mesh.points[t.b], mesh.points[t.c]};
    const auto [low_z, high_z] = std::minmax({corner[0].z, corner[1].z, corner[2].z});
    const Extent ez = points_between(low_z, high_z, grid.origin.z, grid.spacing, grid.nz);
    for (int k = ez.begin; k < ez.end; ++k) {
      const double z = grid.position(0, 0, k).z;
      Vector end[2];
      int ends = 0;
      for (int n = 0; n < 3; ++n) {
        const Vector &from = corner[n], &to = corner[(n + 1) % 3];
        if ((from.z > z) != (to.z > z)) end[ends++] = at_height(z, from, to);
      }
      if (ends == 0) continue;
      const auto [low_y, high_y] = std::minmax({end[0].y, end[1].y});
      const Extent ey = points_between(low_y, high_y, grid.origin.y, grid.spacing, grid.ny);
      for (int j = ey.begin; j < ey.end; ++j) {
        const double y = grid.position(0, j, 0).y;
        if ((end[0].y > y) == (end[1].y > y)) continue;
        const double x = end[0].x + (y - end[0].y) / (end[1].y - end[0].y) * (end[1].x - end[0].x);
        const double behind = std::max(std::ceil((x - grid.origin.x) / grid.spacing - .5), 0.);
        if (behind < grid.nx) in(static_cast<int>(behind), j, k) ^= 1;
      }
    }
  }
  for (int z = 0; z < grid.nz; ++z)
    for (int y = 0; y < grid.ny; ++y)
      for (int x = 1; x < grid.nx; ++x) in(x, y, z) ^= in(x - 1, y, z);
  return in;
}

}  // namespace

Field<double> signed_distance(const Mesh& mesh, const Grid& grid, double exact) {
  Field<double> distance = squared_distance(mesh, grid, exact);
  const Field<std::uint8_t> in = inside(mesh, grid);
  for (int z = 0; z < grid.nz; ++z)
    for (int y = 0; y < grid.ny; ++y)
      for (int x = 0; x < grid.nx; ++x) {
        double& d = distance(x, y, z);
        d = in(x, y, z) ? -std::sqrt(d) : std::sqrt(d);
      }
  return distance;
}

}  // namespace lockstep::levelset
