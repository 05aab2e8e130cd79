#include "common/levelset/shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lockstep::levelset {
namespace {

Vector3<double> minus(const Vector3<double>& a, const Vector3<double>& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

double length(double x, double y, double z) { return std::sqrt(x * x + y * y + z * z); }

double distance(const Sphere& sphere, const Vector3<double>& p) {
  const auto [x, y, z] = minus(p, sphere.centre);
  return length(x, y, z) - sphere.radius;
}

// Outside: the length of the vector from the box to p, which is zero along axes where p is within the box. Inside:
// minus the distance to the nearest side.
double distance(const Box& box, const Vector3<double>& p) {
  const auto [x, y, z] = minus(p, box.centre);
  const double out_x = std::abs(x) - box.half.x, out_y = std::abs(y) - box.half.y, out_z = std::abs(z) - box.half.z;
  return length(std::max(out_x, 0.), std::max(out_y, 0.), std::max(out_z, 0.)) +
         std::min(std::max({out_x, out_y, out_z}), 0.);
}

// In the plane through p and the axis, the tube is a circle.
double distance(const Torus& torus, const Vector3<double>& p) {
  const auto [x, y, z] = minus(p, torus.centre);
  return length(length(x, y, 0) - torus.ring, 0, z) - torus.tube;
}

}  // namespace

double signed_distance(const Shape& shape, const Vector3<double>& p) {
  return std::visit([&](const auto& s) { return distance(s, p); }, shape);
}

double signed_distance(const std::vector<Shape>& shapes, const Vector3<double>& p) {
  double least = std::numeric_limits<double>::infinity();
  for (const Shape& shape : shapes) least = std::min(least, signed_distance(shape, p));
  return least;
}

}  // namespace lockstep::levelset
