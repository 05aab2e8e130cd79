// Solid bodies that a cloth drapes over, and how they move.
//
// A scene gives a body's shape where the body is at time 0, and its path. For a step, shapes stand where bodies are at
// its end, and a body says how far each of its points has moved in the step: d(x) = turn x + shift, of the point that
// ends at x.
#pragma once

#include <variant>
#include <vector>

#include "common/cloth/cloth.h"
#include "common/placement.h"
#include "common/production_cloth/level_set.h"

namespace lockstep::production_cloth {

// Where something rigid is at given times; between two of them turn and shift are linear in time. Before the first and
// after the last it rests there. No key: it never moves.
struct Path {
  struct Key {
    double time;  // s
    Placement placement;
  };
  Vector3<double> pivot = {0, 0, 0};  // m
  std::vector<Key> keys;              // times ascend
};

Placement placement_at(const Path& path, double time);

// Where the point is that was at x before the body was placed.
Vector3<double> placed(const Path& path, const Placement& placement, const Vector3<double>& x);

using Shape = std::variant<cloth::Plane<double>, cloth::Capsule<double>, cloth::Box<double>, LevelSet<double>>;

struct Body {
  Shape shape;
  double friction = 0;  // Coulomb's coefficient
  Path path;
};

// A shape at the end of a step.
template <class Real, template <class> class Shape>
struct Moved {
  Shape<Real> shape;
  Real friction;
  Matrix3<Real> turn;   // of d(x)
  Vector3<Real> shift;  // m
};

template <class Real>
struct MovedBodies {
  std::vector<Moved<Real, cloth::Plane>> planes;
  std::vector<Moved<Real, cloth::Capsule>> capsules;
  std::vector<Moved<Real, cloth::Box>> boxes;
  std::vector<Moved<Real, LevelSet>> level_sets;

  bool empty() const { return planes.empty() && capsules.empty() && boxes.empty() && level_sets.empty(); }
};

// The bodies at the end of a step, all larger by `thickness` (m).
MovedBodies<float> move_bodies(const std::vector<Body>& bodies, double start, double end, double thickness);

}  // namespace lockstep::production_cloth
