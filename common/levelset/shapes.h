// Shapes whose signed distance has a closed form.
#pragma once

#include <variant>
#include <vector>

#include "common/vector3.h"

namespace lockstep::levelset {

struct Sphere {
  Vector3<double> centre;  // m
  double radius;           // m, > 0
};

struct Box {               // with sides along the axes
  Vector3<double> centre;  // m
  Vector3<double> half;    // m, > 0
};

struct Torus {             // about the line along z through its centre
  Vector3<double> centre;  // m
  double ring;             // m: the radius of the circle that the tube is bent around
  double tube;             // m, > 0 and < ring: the radius of the tube
};

using Shape = std::variant<Sphere, Box, Torus>;

// The distance from the surface, negative inside, m.
double signed_distance(const Shape& shape, const Vector3<double>& p);

// The same of the union of the shapes; infinite if there are none. Inside, where shapes overlap, the value is only a
// lower bound of the distance from the surface.
double signed_distance(const std::vector<Shape>& shapes, const Vector3<double>& p);

}  // namespace lockstep::levelset
