// The production face: bodies do not move yet, so that there is nothing to run.
#include <cmath>

#include "common/production_face/scene.h"
#include "verify/domain.h"

namespace lockstep::verify {
namespace {

// A body that is loaded must have finite gradients and volumes, and corners that are nodes.
std::string fault_of_scene(const std::string& path) {
  const production_face::Body<float> body = production_face::load_scene(path).body;
  for (int t = 0; t < body.tetrahedra; ++t) {
    if (!(body.volume.at(t, 0) > 0) || !std::isfinite(body.volume.at(t, 0))) return "a volume is not positive";
    for (int k = 0; k < 9; ++k)
      if (!std::isfinite(body.gradient.at(t, k))) return "a gradient is not finite";
    for (int a = 0; a < 4; ++a)
      if (body.corner.at(t, a) < 0 || body.corner.at(t, a) >= body.nodes) return "a corner is no node";
  }
  return "";
}

const RegisterDomain production_face_domain{
    {.name = "production_face", .moves = false, .determinism = {"bar_shaken"}, .fault_of_scene = fault_of_scene}};

}  // namespace
}  // namespace lockstep::verify
