#include "common/production_cloth/bodies.h"

#include <algorithm>

#include "common/convert.h"

namespace lockstep::production_cloth {
namespace {

using cloth::Box;
using cloth::Capsule;
using cloth::Plane;

Matrix3<float> to_float(const Matrix3<double>& m) {
  return {convert<float>(m.x), convert<float>(m.y), convert<float>(m.z)};
}

Plane<double> at(const Plane<double>& plane, const Path& path, const Placement& placement) {
  const Vector3<double> normal = rotation_by(placement.turn) * plane.normal;
  return {normal, dot(normal, placed(path, placement, plane.offset * plane.normal))};
}
Capsule<double> at(const Capsule<double>& capsule, const Path& path, const Placement& placement) {
  return {placed(path, placement, capsule.from), placed(path, placement, capsule.to), capsule.radius};
}
Box<double> at(const Box<double>& box, const Path& path, const Placement& placement) {
  Box<double> moved = {placed(path, placement, box.centre), box.half, box.axis};
  for (Vector3<double>& axis : moved.axis) axis = rotation_by(placement.turn) * axis;
  return moved;
}
LevelSet<double> at(const LevelSet<double>& body, const Path& path, const Placement& placement) {
  const Matrix3<double> turn = rotation_by(placement.turn);
  return {body.solid,
          placed(path, placement, body.origin),
          {turn * body.turn.x, turn * body.turn.y, turn * body.turn.z},
          body.larger_by};
}

Plane<float> thickened(const Plane<double>& plane, double thickness) {
  return {convert<float>(plane.normal), static_cast<float>(plane.offset + thickness)};
}
Capsule<float> thickened(const Capsule<double>& capsule, double thickness) {
  return {convert<float>(capsule.from), convert<float>(capsule.to), static_cast<float>(capsule.radius + thickness)};
}
Box<float> thickened(const Box<double>& box, double thickness) {
  return {convert<float>(box.centre),
          convert<float>(box.half + Vector3<double>{thickness, thickness, thickness}),
          {convert<float>(box.axis[0]), convert<float>(box.axis[1]), convert<float>(box.axis[2])}};
}
LevelSet<float> thickened(const LevelSet<double>& body, double thickness) {
  return {body.solid, convert<float>(body.origin), to_float(body.turn), static_cast<float>(body.larger_by + thickness)};
}

void add(MovedBodies<float>& to, const Moved<float, cloth::Plane>& body) { to.planes.push_back(body); }
void add(MovedBodies<float>& to, const Moved<float, cloth::Capsule>& body) { to.capsules.push_back(body); }
void add(MovedBodies<float>& to, const Moved<float, cloth::Box>& body) { to.boxes.push_back(body); }
void add(MovedBodies<float>& to, const Moved<float, LevelSet>& body) { to.level_sets.push_back(body); }

}  // namespace

Placement placement_at(const Path& path, double time) {
  if (path.keys.empty()) return {};
  const auto after = std::ranges::upper_bound(path.keys, time, {}, &Path::Key::time);
  if (after == path.keys.begin()) return path.keys.front().placement;
  if (after == path.keys.end()) return path.keys.back().placement;
  const Path::Key &from = *(after - 1), &to = *after;
  const double share = (time - from.time) / (to.time - from.time);
  const auto between = [&](const Vector3<double>& a, const Vector3<double>& b) { return a + share * (b - a); };
  return {between(from.placement.turn, to.placement.turn), between(from.placement.shift, to.placement.shift)};
}

Vector3<double> placed(const Path& path, const Placement& placement, const Vector3<double>& x) {
  return path.pivot + placement.shift + rotation_by(placement.turn) * (x - path.pivot);
}

MovedBodies<float> move_bodies(const std::vector<Body>& bodies, double start, double end, double thickness) {
  MovedBodies<float> moved;
  for (const Body& body : bodies) {
    const Placement before = placement_at(body.path, start), now = placement_at(body.path, end);
    // The body's points X begin the step at B X + p and end it at A X + q. So the point that ends at x began at
    // B A^T (x - q) + p.
    const Matrix3<double> a = rotation_by(now.turn), b = rotation_by(before.turn);
    const auto back = [&](const Vector3<double>& v) { return b * transposed_times(a, v); };
    const Vector3<double> zero = {0, 0, 0}, origin = placed(body.path, now, zero);
    const Matrix3<double> turn = {Vector3<double>{1, 0, 0} - back({1, 0, 0}),
                                  Vector3<double>{0, 1, 0} - back({0, 1, 0}),
                                  Vector3<double>{0, 0, 1} - back({0, 0, 1})};
    const Vector3<double> shift = back(origin) - placed(body.path, before, zero);
    std::visit(
        [&](const auto& shape) {
          add(moved, {thickened(at(shape, body.path, now), thickness), static_cast<float>(body.friction),
                      to_float(turn), convert<float>(shift)});
        },
        body.shape);
  }
  return moved;
}

}  // namespace lockstep::production_cloth
