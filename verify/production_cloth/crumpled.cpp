#include "verify/production_cloth/crumpled.h"

#include <cmath>

#include "verify/production_cloth/inputs.h"

namespace lockstep::verify::production_cloth_inputs {
namespace {

constexpr double radius = .06;  // m, of the ball
constexpr double waves = 20;    // rad/m: with the radius, edges keep about their lengths
constexpr double way = .003;    // m, that no vertex moves farther along an axis

Vector3<float> place(const Vector3<double>& rest, double phase) {
  const auto wave = [&](double u, double v, double w, double at) {
    return static_cast<float>(radius * std::sin(waves * (u * rest.x + v * rest.y + w * rest.z) + at + phase));
  };
  return {wave(1, .2, .3, 0), wave(.37, -.5, -.9, 1), wave(.7, .9, .8, 2)};
}

}  // namespace

std::shared_ptr<const Crumpled> crumpled(const std::string& path) {
  const auto in = inputs(path);
  Crumpled made = {production_cloth::make_search(in->topology), {}, {}, static_cast<float>(in->contact.thickness / 2)};
  made.start.resize(in->topology.vertices), made.end.resize(in->topology.vertices);
  for (int i = 0; i < in->topology.vertices; ++i) {
    store(made.start, i, place(load(in->rest, i), 0));
    store(made.end, i, place(load(in->rest, i), way / radius));
  }
  return std::make_shared<const Crumpled>(std::move(made));
}

}  // namespace lockstep::verify::production_cloth_inputs
