#include "common/production_face/head.h"

#include <algorithm>
#include <cmath>

namespace lockstep::production_face {
namespace {

using Vector = Vector3<double>;

double length(const Vector& a) { return std::sqrt(dot(a, a)); }

double ellipsoid(const Vector& p, const Vector& centre, const Vector& radii) {
  const Vector d = p - centre;
  const Vector once = {d.x / radii.x, d.y / radii.y, d.z / radii.z};
  const Vector twice = {once.x / radii.x, once.y / radii.y, once.z / radii.z};
  const double away = length(once);
  // Within a thousandth of the centre the quotient of lengths is not needed, and has no value at it.
  return away < 1e-3 ? -std::min({radii.x, radii.y, radii.z}) : away * (away - 1) / length(twice);
}

double capsule(const Vector& p, const Vector& from, const Vector& to, double radius) {
  const Vector axis = to - from;
  const double along = std::clamp(dot(p - from, axis) / dot(axis, axis), 0., 1.);
  return length(p - from - along * axis) - radius;
}

// The union, whose edge is rounded over a width of about `blend`.
double join(double a, double b, double blend) {
  const double near = std::max(blend - std::abs(a - b), 0.) / blend;
  return std::min(a, b) - .25 * near * near * blend;
}
double cut_off(double a, double b, double blend) { return -join(-a, b, blend); }

Vector right(const Vector& p) { return {std::abs(p.x), p.y, p.z}; }

}  // namespace

double distance_to_skin(const Vector& point) {
  const Vector p = right(point);
  double d = ellipsoid(p, {0, .018, .000}, {.074, .097, .090});                      // cranium
  d = join(d, ellipsoid(p, {0, -.045, .012}, {.055, .064, .074}), .030);             // jaw
  d = join(d, ellipsoid(p, {.043, -.004, .052}, {.019, .017, .019}), .022);          // cheekbones
  d = join(d, ellipsoid(p, {0, -.087, .066}, {.021, .016, .016}), .030);             // chin
  d = join(d, capsule(p, {.010, .045, .082}, {.034, .047, .074}, .006), .014);       // brows
  d = cut_off(d, ellipsoid(p, {.029, .024, .098}, {.020, .014, .017}), .014);        // hollows of the eyes
  d = join(d, ellipsoid(p, eye, {.0190, .0135, .0060}), .010);                       // lids
  d = join(d, capsule(p, {0, .034, .084}, {0, .000, .103}, .0065), .014);            // bridge of the nose
  d = join(d, ellipsoid(p, {0, -.005, .105}, {.0095, .0085, .0090}), .008);          // its tip
  d = join(d, ellipsoid(p, {.0115, -.008, .095}, {.0065, .0062, .0090}), .006);      // its wings
  d = join(d, ellipsoid(p, {0, -.030, .082}, {.026, .022, .011}), .016);             // what is before the teeth
  d = join(d, ellipsoid(p, {.0065, -.0400, .0895}, {.0170, .0056, .0072}), .005);    // upper lip
  d = join(d, ellipsoid(p, {0, -.0512, .0885}, {.0195, .0066, .0078}), .005);        // lower lip
  return cut_off(d, capsule(p, {0, -.020, .1035}, {0, -.035, .0995}, .0022), .004);  // groove above the upper lip
}

double distance_to_skull(const Vector& point) {
  const Vector p = right(point);
  return join(ellipsoid(p, {0, .018, 0}, {.0627, .0857, .0787}), ellipsoid(p, {0, -.045, .012}, {.0447, .0527, .0627}),
              .030);
}

double distance_to_flesh(const Vector& point, double slit) {
  const Vector p = right(point);
  const double eyes = ellipsoid(p, eye, {.0130, .0068, .03});
  const double mouth = std::max({p.x - .0235, std::abs(p.y - mouth_height) - .5 * slit, .06 - p.z});
  return std::max({distance_to_skin(p), -distance_to_skull(p), -eyes, -mouth, -p.z});
}

Vector skull_normal(const Vector& p) {
  constexpr double step = 1e-4;
  const auto slope = [&](const Vector& d) { return distance_to_skull(p + d) - distance_to_skull(p - d); };
  const Vector gradient = {slope({step, 0, 0}), slope({0, step, 0}), slope({0, 0, step})};
  return (1 / length(gradient)) * gradient;
}

}  // namespace lockstep::production_face
