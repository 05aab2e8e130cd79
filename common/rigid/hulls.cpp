// Convex hulls of points, by Qhull, and the arrays that hold them.
#include "common/rigid/hulls.h"

// Qhull's C headers.
extern "C" {
#include <libqhull_r/qhull_ra.h>
}

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>

#include "common/rigid/make.h"

namespace lockstep::rigid {
namespace {

using Vector = Vector3<double>;

// Sets the end of the last element in an array of beginnings. Whatever is beyond it is empty.
void put_end(Array<std::int32_t>& first, int count, int end) {
  first.resize(padded(count + 1));
  std::fill(first.begin() + count, first.end(), end);
}

double length(const Vector& v) { return std::sqrt(dot(v, v)); }

// Newell's normal, whose length is twice the area. It is exact for flat faces, and the mean for faces that are flat
// only to within rounding.
Vector normal_of(const Face& face, std::span<const Vector> points) {
  Vector sum{0, 0, 0};
  const Vector& origin = points[face[0]];
  for (std::size_t k = 1; k + 1 < face.size(); ++k)
    sum = sum + cross(points[face[k]] - origin, points[face[k + 1]] - origin);
  return sum;
}

}  // namespace

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
    // The plane goes through the farthest vertex. Then no vertex is outside by more than the rounding of one product.
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

namespace {

// Qhull's faces of points from -1 to 1; none if Qhull finds the points flat.
std::vector<Face> qhull_faces(std::vector<Vector>& points, const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> nowhere(std::fopen("/dev/null", "w"), std::fclose);
  qhT qhull{};
  qhT* qh = &qhull;  // the name that Qhull's macros expect
  qh_zero(qh, nowhere.get());
  std::vector<Face> faces;
  if (qh_new_qhull(qh, 3, static_cast<int>(points.size()), &points[0].x, False, const_cast<char*>(command.c_str()),
                   nowhere.get(), nowhere.get()) == 0) {
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

// How well faces fit the points whose hull they are.
struct Fit {
  // The least, over faces, of the greatest distance of a point behind the face.
  double depth = std::numeric_limits<double>::infinity();
  // The greatest distance of a point outside of a face, or of a corner off its own face.
  double error = 0;
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
    for (const int corner : face)
      fit.error = std::max(fit.error, std::abs(scale * dot(n, points[corner] - points[face[0]])));
    fit.depth = std::min(fit.depth, -least);
  }
  return fit;
}

// The faces of the convex hull of points from -1 to 1; none if the points are flat.
std::vector<Face> hull_faces(std::vector<Vector>& points) {
  // C1e-6: when the hull is done, Qhull merges faces that are coplanar to within 1e-6. In a chain of slivers that may
  // turn a face out of its plane. Then Qhull runs again and merges only what is coplanar to within rounding.
  std::vector<Face> faces = qhull_faces(points, "qhull C1e-6");
  if (!(fit_of(faces, points).error <= 2 * hull_error)) faces = qhull_faces(points, "qhull");
  if (!(fit_of(faces, points).depth > 2 * flat)) faces.clear();
  return faces;
}

}  // namespace

int make_hull(Hulls<double>& hulls, std::span<const Vector3<double>> points) {
  const auto wrong = [](const std::string& what) { return std::invalid_argument(what); };
  if (points.size() < 4) throw wrong(std::to_string(points.size()) + " points, a hull has at least 4");
  Vector low = points[0], high = points[0];
  for (const Vector& p : points) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) throw wrong("a point is not finite");
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }

  // Scaled to -1 .. 1, wherever and however large the hull is, because Qhull's tolerances depend on the coordinates.
  const Vector middle = {.5 * (low.x + high.x), .5 * (low.y + high.y), .5 * (low.z + high.z)};
  const double half_extent = .5 * std::max({high.x - low.x, high.y - low.y, high.z - low.z});
  std::vector<Vector> scaled;
  for (const Vector& p : points) scaled.push_back(half_extent > 0 ? 1 / half_extent * (p - middle) : Vector{0, 0, 0});
  std::vector<Face> faces = hull_faces(scaled);
  if (faces.empty()) throw wrong("the points are flat");

  // Vertices take the order of the points, and faces the order of their corners, the lowest first. So the hull does not
  // depend on Qhull's order.
  std::map<int, int> vertex_of;  // point
  for (const Face& face : faces)
    for (const int point : face) vertex_of[point];
  std::vector<Vector> vertices;
  for (auto& [point, vertex] : vertex_of) vertex = static_cast<int>(vertices.size()), vertices.push_back(points[point]);
  if (vertices.size() > most_hull_vertices)
    throw wrong("a hull of " + std::to_string(vertices.size()) + " vertices, at most " +
                std::to_string(most_hull_vertices));
  for (Face& face : faces) {
    for (int& corner : face) corner = vertex_of[corner];
    std::rotate(face.begin(), std::ranges::min_element(face), face.end());
  }
  std::ranges::sort(faces);
  return put_hull(hulls, vertices, faces);
}

}  // namespace lockstep::rigid
