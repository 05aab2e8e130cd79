// OpenVDB: a level set that a given flow carries and that stays a distance (tools/LevelSetAdvect.h, which calls
// LevelSetTracker.h). The flow is Enright's, which draws a sphere out to a thin sheet and brings it back: what is then
// missing, or elsewhere, is the error.
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetAdvect.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "common/production_fluid/scene.h"
#include "common/production_fluid/step.h"
#include "notes/peers/peer.h"

namespace lockstep::peers {
namespace {

using namespace production_fluid;

const float half_width = openvdb::LEVEL_SET_HALF_WIDTH;  // cells: what a new tracker expects

// phi within the narrow band, and the sign of the side elsewhere.
openvdb::FloatGrid::Ptr grid_of(const Fluid<float>& fluid) {
  const float h = fluid.spacing, background = half_width * h;
  auto grid = openvdb::FloatGrid::create(background);
  auto transform = openvdb::math::Transform::createLinearTransform(h);
  transform->postTranslate(openvdb::Vec3d(.5 * h));  // phi stands at the centres of cells
  grid->setTransform(transform);
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  auto at = grid->getAccessor();
  for (int z = 0; z < fluid.nz; ++z)
    for (int y = 0; y < fluid.ny; ++y)
      for (int x = 0; x < fluid.nx; ++x) {
        const float phi = fluid.phi(x, y, z);
        if (std::abs(phi) < background)
          at.setValue({x, y, z}, phi);
        else if (phi < 0)
          at.setValueOff({x, y, z}, -background);
      }
  grid->pruneGrid();
  return grid;
}

// Against the start, where the flow ends, in percent of its volume.
template <class F>
Json errors(const Fluid<float>& start, const F& phi) {
  double volume = 0, left = 0, misplaced = 0;
  for (int z = 0; z < start.nz; ++z)
    for (int y = 0; y < start.ny; ++y)
      for (int x = 0; x < start.nx; ++x) {
        const double before = liquid_share(start.phi(x, y, z), start.spacing);
        const double now = liquid_share(phi(x, y, z), start.spacing);
        volume += before, left += now, misplaced += std::abs(now - before);
      }
  return {{"volume_lost_percent", 100 * (1 - left / volume)}, {"misplaced_percent", 100 * misplaced / volume}};
}

void compare(Json& rows, const Asked& asked) {
  for (const std::string& name : asked.scenes) {
    const Scene scene = load_scene(path_of("production_fluid", name));
    const int frames = scene.frames;
    const auto end = static_cast<float>(frames * scene.model.frame);
    if (!scene.model.given || scene.model.period != 3)
      throw std::runtime_error("this comparison is for Enright's flow of three seconds, which OpenVDB has");
    const openvdb::FloatGrid::Ptr start = grid_of(scene.fluid);
    for (const int per_block : {scene.model.per_block, 0}) {
      Model model = scene.model;
      model.per_block = per_block;
      Liquid<float> liquid_at_start, ours;
      liquid_at_start.fluid = scene.fluid;
      StepMemory<float> memory;
      serial::start(model, liquid_at_start, memory);
      openvdb::FloatGrid::Ptr theirs;
      for (const int threads : asked.threads) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        const std::string particles = per_block ? ", with particles" : ", without particles";
        Json row = {{"work", "a frame of a level set in a given flow, kept a distance"},
                    {"scene", scene.name},
                    {"ours", "production_fluid/step multigrid" + particles},
                    {"items", {{"cells", double(scene.fluid.nx) * scene.fluid.ny * scene.fluid.nz}}}};
        const Side their_side = {[&] { theirs = start->deepCopy(); },
                                 [&] {
                                   openvdb::tools::LevelSetAdvection<openvdb::FloatGrid> advection(*theirs, {});
                                   advection.advect(0, end);
                                 }};
        const Side our_side = {[&] { ours = liquid_at_start; },
                               [&] {
                                 for (int k = 0; k < frames; ++k) openmp::step_multigrid(model, ours, memory);
                               }};
        row.update(take_turns(threads, frames, their_side, our_side));
        const auto at = theirs->getConstAccessor();
        row["quality"] =
            errors(scene.fluid, [&](int x, int y, int z) { return at.getValue(openvdb::Coord(x, y, z)); });
        row["ours_quality"] = errors(scene.fluid, [&](int x, int y, int z) { return ours.fluid.phi(x, y, z); });
        row["not_the_same"] =
            "All frames of the scene, in float. OpenVDB keeps a sparse band of three cells, by its defaults: WENO of"
            " fifth order, three iterations of normalization a substep; it evaluates the flow where it needs it. Ours"
            " keeps a dense grid, MacCormack, sweeping" + std::string(per_block ? ", and marker particles." : ".");
        rows.push_back(row);
      }
    }
  }
}

}  // namespace
}  // namespace lockstep::peers

int main(int count, char** words) {
  using namespace lockstep::peers;
  openvdb::initialize();
  return report([&](Json& rows) { compare(rows, asked(count, words)); });
}
