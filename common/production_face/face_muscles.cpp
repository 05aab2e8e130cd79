// A muscle follows a curve on the face, from its origin to its insertion. A tetrahedron is in it where its centroid,
// seen along the normal of the skull, is nearer to the curve than half the muscle's width, and where it is at the
// muscle's depth under the skin. Its fibre is the tangent of the curve, turned across that normal. (The skin's own
// normal, at that depth under lips and brows, points anywhere.) Where muscles lie and what they pull is from anatomy;
// all numbers are ours.
#include "common/production_face/face_muscles.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/production_face/head.h"

namespace lockstep::production_face {
namespace {

using Vector = Vector3<double>;

// On the face as seen from the front, of its left half: millimetres to the right of the middle, and up.
struct Seen {
  double x, y;
};

// Either through three points, along a parabola; or, round eyes and mouth, part of an ellipse: its centre, its two
// half axes, and where it begins and ends, degrees from x to y.
struct Muscle {
  const char* name;
  double half_width;  // mm
  bool is_ellipse;
  Seen a, b, c;
};

constexpr Muscle muscles[] = {
    {"frontalis", 5, false, {27, 94}, {28, 72}, {27, 48}},
    {"corrugator supercilii", 3, false, {6, 40}, {17, 44}, {29, 47}},
    {"procerus", 3, false, {4, 16}, {4, 31}, {5, 47}},
    {"orbicularis oculi upper", 3.5, true, {29, 26}, {19.5, 14}, {180, 0}},
    {"orbicularis oculi lower", 3.5, true, {29, 26}, {19.5, 14}, {180, 360}},
    {"levator labii superioris alaeque nasi", 3, false, {11, 20}, {16, -6}, {14, -33}},
    {"levator labii superioris", 3.5, false, {27, 8}, {23, -12}, {18, -34}},
    {"levator anguli oris", 3.5, false, {25, -4}, {27, -22}, {27, -41}},
    {"zygomaticus minor", 3, false, {42, 4}, {33, -14}, {20, -34}},
    {"zygomaticus major", 3.5, false, {53, -2}, {43, -20}, {28, -41}},
    {"risorius", 3.5, false, {54, -44}, {42, -46}, {28, -45}},
    {"buccinator", 4, false, {54, -30}, {42, -36}, {28, -45}},
    {"depressor anguli oris", 3.5, false, {31, -80}, {33, -64}, {28, -47}},
    {"depressor labii inferioris", 3.5, false, {22, -82}, {19, -68}, {13, -55}},
    {"mentalis", 3.5, false, {7, -66}, {8, -78}, {7, -90}},
    {"orbicularis oris", 4, true, {0, -45}, {29, 12}, {90, -90}},
};
constexpr int a_side = static_cast<int>(std::size(muscles));
constexpr double least_depth = .04 * head_radius, most_depth = .13 * head_radius;
constexpr int segments = 24;

Seen along(const Muscle& m, double s) {
  if (m.is_ellipse) {
    const double angle = (m.c.x + s * (m.c.y - m.c.x)) * std::numbers::pi / 180;
    return {m.a.x + m.b.x * std::cos(angle), m.a.y + m.b.y * std::sin(angle)};
  }
  const double a = (1 - s) * (1 - 2 * s), b = 4 * s * (1 - s), c = s * (2 * s - 1);
  return {a * m.a.x + b * m.b.x + c * m.c.x, a * m.a.y + b * m.b.y + c * m.c.y};
}

// The frontmost point there, amid the muscles' layer.
Vector below_skin(const Seen& seen) {
  double outside = 1.5 * head_radius, inside = 0;
  for (int halving = 0; halving < 40; ++halving) {
    const double z = .5 * (outside + inside);
    const bool above = distance_to_skin({.001 * seen.x, .001 * seen.y, z}) > -.5 * (least_depth + most_depth);
    (above ? outside : inside) = z;
  }
  return {.001 * seen.x, .001 * seen.y, outside};
}

struct Curve {
  std::vector<Vector> points;
  Vector low, high;  // a box that holds the muscle
  double half_width;
};

Curve curve_of(const Muscle& m) {
  Curve curve = {{}, {1, 1, 1}, {-1, -1, -1}, .001 * m.half_width};
  const double margin = curve.half_width + most_depth;
  for (int i = 0; i <= segments; ++i) {
    const Vector p = curve.points.emplace_back(below_skin(along(m, double(i) / segments)));
    curve.low = {std::min(curve.low.x, p.x - margin), std::min(curve.low.y, p.y - margin),
                 std::min(curve.low.z, p.z - margin)};
    curve.high = {std::max(curve.high.x, p.x + margin), std::max(curve.high.y, p.y + margin),
                  std::max(curve.high.z, p.z + margin)};
  }
  return curve;
}

bool is_in_box(const Curve& curve, const Vector& p) {
  return p.x > curve.low.x && p.y > curve.low.y && p.z > curve.low.z && p.x < curve.high.x && p.y < curve.high.y &&
         p.z < curve.high.z;
}

// The muscle's share at a point, and its direction there: of the curve's nearest segment, as seen along the normal.
struct Strand {
  double share = 0;
  Vector direction = {0, 0, 0};
};

Strand strand_at(const Curve& curve, const Vector& p, const Vector& normal) {
  double nearest = curve.half_width;
  Strand strand;
  for (int i = 0; i < segments; ++i) {
    const Vector from = curve.points[i], axis = curve.points[i + 1] - from;
    const double s = std::clamp(dot(p - from, axis) / dot(axis, axis), 0., 1.);
    const Vector away = p - from - s * axis;
    const double above = dot(away, normal);
    if (std::abs(above) > most_depth) continue;
    const Vector beside = away - above * normal;
    const double distance = std::sqrt(dot(beside, beside));
    if (distance >= nearest) continue;
    nearest = distance;
    const Vector direction = axis - dot(axis, normal) * normal;
    // Whole within .6 of the half width, and none at its rim.
    strand = {std::min(1., (1 - distance / curve.half_width) / .4),
              (1 / std::sqrt(dot(direction, direction))) * direction};
  }
  return strand;
}

}  // namespace

std::vector<std::string> face_muscles() {
  std::vector<std::string> names;
  for (const char* side : {" left", " right"})
    for (const Muscle& muscle : muscles) names.push_back(muscle.name + std::string(side));
  return names;
}

std::vector<Fibre> face_fibres(const Mesh& mesh) {
  std::vector<Curve> curves;
  for (const Muscle& muscle : muscles) curves.push_back(curve_of(muscle));
  std::vector<Fibre> fibres;
  for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    Vector centroid = {0, 0, 0};
    for (const std::int32_t corner : mesh.tetrahedra[t]) centroid = centroid + .25 * mesh.nodes[corner];
    const double depth = -distance_to_skin(centroid);
    if (depth < least_depth || depth > most_depth) continue;
    const Vector normal = skull_normal(centroid);
    for (int m = 0; m < 2 * a_side; ++m) {
      // The right half's muscles are the left half's, seen in a mirror.
      const auto as_left = [&](const Vector& x) { return m < a_side ? x : Vector{-x.x, x.y, x.z}; };
      const Curve& curve = curves[m % a_side];
      if (!is_in_box(curve, as_left(centroid))) continue;
      const Strand strand = strand_at(curve, as_left(centroid), as_left(normal));
      if (strand.share > 0)
        fibres.push_back({static_cast<std::int32_t>(t), m, as_left(strand.direction), strand.share});
    }
  }
  return fibres;
}

}  // namespace lockstep::production_face
