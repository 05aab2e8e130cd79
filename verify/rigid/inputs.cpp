#include "verify/rigid/inputs.h"

#include <utility>

#include "common/rigid/match_contacts.h"
#include "verify/inputs.h"

namespace lockstep::verify::rigid_inputs {

using namespace rigid;

namespace {

Inputs make(const std::string& path) {
  Inputs in{load_scene(path), {}, {}, {}, {}};
  in.settings = settings_of(in.scene);
  in.world = in.scene.world;
  Step<float>* step = serial::step_batches;
  if (settles_by_openmp) step = openmp::step_batches;
  for (int k = 0; k < in.scene.settle; ++k) step(in.settings, in.world, in.last);
  in.now = in.last;
  World<float> after = in.world;
  step(in.settings, after, in.now);
  serial::contact_blocks(in.now.manifolds, in.body(), in.world.bodies, in.now.blocks);
  return in;
}

}  // namespace

// For the cache.
double bytes_of(const Inputs& in) {
  return 2 * lockstep::bytes_of(in.world) + lockstep::bytes_of(in.last) + lockstep::bytes_of(in.now);
}

std::shared_ptr<const Inputs> inputs(const std::string& path) {
  return verify::inputs<Inputs>(path, [&] { return make(path); });
}

Array<Impulses<float>> warm_start(const Inputs& in) {
  Array<Impulses<float>> impulses(in.now.manifolds.size());
  serial::match_contacts(in.last.manifolds, in.last.impulses, in.now.manifolds, impulses);
  return impulses;
}

void find_kept(const Inputs& in, NarrowPhaseState& state, KeptContacts<float>& kept) {
  if (in.last.pairs.empty()) return;
  Array<Manifold<float>> manifolds;
  state = {};
  serial::narrow_phase_kept({in.world.colliders, in.world.hulls, in.last.placed}, in.last.pairs, in.margin(), state,
                            kept, manifolds);
}

double rows_of(const Inputs& in) {
  double points = 0;
  for (const Manifold<float>& m : in.now.manifolds) points += m.count;
  const SolverSettings& solver = in.settings.solver;
  return points * solver.substeps * (solver.biased_sweeps + 3 * solver.relax_sweeps);
}

Scenes scenes_of_all(std::vector<std::string> bench, std::vector<std::string> tsan) {
  return {.verify = {"four_bodies", "degenerate", "assorted", "soup_10", "mesh_and_hulls", "rounds_20000", "castle"},
          .more = {"soup_1", "soup_50", "hull_soup", "box_pit_4000", "hull_pit_2000", "pyramid_24", "wall",
                   "castle_hit", "dominoes_1000"},
          .bench = std::move(bench),
          .tsan = std::move(tsan)};
}

Scenes with_hulls_at_rest(std::vector<std::string> bench, std::vector<std::string> tsan) {
  Scenes scenes = scenes_of_all(std::move(bench), std::move(tsan));
  scenes.verify.push_back("hull_pit_2000");
  std::erase(scenes.more, "hull_pit_2000");
  return scenes;
}

Scenes and_more(Scenes scenes, const std::string& name) {
  scenes.more.push_back(name);
  return scenes;
}

}  // namespace lockstep::verify::rigid_inputs
