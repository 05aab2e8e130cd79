#include "common/production_cloth/script.h"

#include "common/convert.h"

namespace lockstep::production_cloth {

Script<float> script_of(const Scene& scene, double start, double end) {
  Script<float> script = {move_bodies(scene.bodies, start, end, scene.contact.thickness), {}, {}};
  for (const Hold& hold : scene.holds)
    script.held.insert(script.held.end(), hold.vertices.begin(), hold.vertices.end());
  script.place.resize(script.held.size());
  std::size_t k = 0;
  for (const Hold& hold : scene.holds) {
    const Placement placement = placement_at(hold.path, end);
    for (const std::int32_t v : hold.vertices)
      store(script.place, k++, convert<float>(placed(hold.path, placement, load(scene.rest, v))));
  }
  return script;
}

}  // namespace lockstep::production_cloth
