// The production cloth: what `run` and `endure` do with its scenes.
#include <cmath>

#include "common/production_cloth/scene.h"
#include "verify/domain.h"

namespace lockstep::verify {
namespace {

using namespace production_cloth;

// A cloth that is loaded has finite positions, and triangles whose corners are vertices.
std::string fault_of_scene(const std::string& path) {
  const Scene scene = load_scene(path);
  for (int i = 0; i < scene.topology.vertices; ++i) {
    const Vector3<double> p = load(scene.rest, i);
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) return "a position is not finite";
  }
  for (std::size_t t = 0; t < scene.topology.triangles.size(); ++t)
    for (const std::int32_t v : scene.topology.corners(t))
      if (v < 0 || v >= scene.topology.vertices) return "a corner is no vertex";
  return "";
}

const RegisterDomain production_cloth_domain{
    {.name = "production_cloth", .moves = false, .determinism = {"ball_5k"}, .fault_of_scene = fault_of_scene}};

}  // namespace
}  // namespace lockstep::verify
