#include "verify/cloth/run.h"

#include <algorithm>
#include <cmath>

#include "common/cloth/collide.h"
#include "common/cloth/make.h"
#include "common/cloth/residual.h"
#include "common/cloth/verlet.h"
#include "verify/arrays.h"
#include "verify/inputs.h"

namespace lockstep::verify {
namespace {

using namespace cloth;

double dot(const Vector3<double>& a, const Vector3<double>& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vector3<double> minus(const Vector3<double>& a, const Vector3<double>& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }

double depth_in(const Plane<double>& plane, const Vector3<double>& p) { return plane.offset - dot(plane.normal, p); }

double depth_in(const Capsule<double>& capsule, const Vector3<double>& p) {
  const Vector3<double> axis = minus(capsule.to, capsule.from), from = minus(p, capsule.from);
  const double l2 = dot(axis, axis), along = l2 > 0 ? std::clamp(dot(from, axis) / l2, 0., 1.) : 0;
  return capsule.radius - std::hypot(from.x - along * axis.x, from.y - along * axis.y, from.z - along * axis.z);
}

double depth_in(const Box<double>& box, const Vector3<double>& p) {
  const Vector3<double> from = minus(p, box.centre);
  return std::min({box.half.x - std::abs(dot(from, box.axis[0])), box.half.y - std::abs(dot(from, box.axis[1])),
                   box.half.z - std::abs(dot(from, box.axis[2]))});
}

}  // namespace

Deepest deepest_inside(const Bodies<double>& bodies, const Cloth<float>& cloth) {
  Deepest deepest{0, 0};
  for (int i = 0; i < cloth.count; ++i) {
    if (cloth.inverse_mass[i] == 0) continue;
    const Vector3<double> p = {cloth.position.x[i], cloth.position.y[i], cloth.position.z[i]};
    const auto ask = [&](const auto& list) {
      for (const auto& body : list)
        if (const double depth = depth_in(body, p); depth > deepest.depth) deepest = {depth, i};
    };
    ask(bodies.planes), ask(bodies.capsules), ask(bodies.boxes);
  }
  return deepest;
}

std::string fault_of(const Bodies<double>& bodies, const Cloth<float>& cloth) {
  if (const std::string fault = first_not_finite(cloth, of_element("particle")); !fault.empty()) return fault;
  const Deepest deepest = deepest_inside(bodies, cloth);
  if (deepest.depth <= 0) return "";
  return "particle " + std::to_string(deepest.particle) + " is " + std::to_string(deepest.depth) + " m inside a body";
}

double residual_left(const Cloth<float>& start, Relax<float>* relax, int n) {
  constexpr int steps = 60;
  Cloth<float> cloth = start;
  const Vector3<float>& g = start.model.gravity;
  if (g.x == 0 && g.y == 0 && g.z == 0) {
    relax(cloth, n);
    return residual(cloth);
  }
  double sum = 0;
  for (int step = 0; step < steps; ++step) {
    for (int substep = 0; substep < cloth.model.substeps; ++substep) {
      openmp::verlet(cloth);
      relax(cloth, n);
      openmp::collide(cloth);
    }
    if (step >= steps / 2) sum += residual(cloth) / (steps - steps / 2);
  }
  return sum;
}

std::shared_ptr<const Cloth<float>> serial_run(const Scene& scene, const std::string& form, Step<float>* step) {
  return inputs<Cloth<float>>(scene.path + ' ' + form, [&] {
    Cloth<float> cloth = convert<float>(scene.cloth);
    for (int frame = 0; frame < scene.frames; ++frame) step(cloth);
    return cloth;
  });
}

void check_run(Judgement& judgement, const Scene& scene, const Cloth<float>& expected, Step<float>* step) {
  Cloth<float> cloth = convert<float>(scene.cloth);
  for (int frame = 1; frame <= scene.frames; ++frame) {
    step(cloth);
    const std::string fault = fault_of(scene.bodies, cloth);
    if (fault.empty()) continue;
    judgement.passed = false;
    judgement.worst_at = fault + " after step " + std::to_string(frame);
    return;
  }
  same_bits(judgement, cloth, expected,
            [name = of_element("particle")](const auto& array, std::size_t i, const auto& field) {
              return name(array, i, field) + " after the run";
            });
}

}  // namespace lockstep::verify
