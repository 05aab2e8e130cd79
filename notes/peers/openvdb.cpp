// OpenVDB: distances in a band about a surface, by its parallel fast sweeping (tools/FastSweeping.h), from a grid whose
// values have the surface as their zero.
#include <openvdb/openvdb.h>
#include <openvdb/tools/FastSweeping.h>
#include <openvdb/tools/SignedFloodFill.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>

#include "common/levelset/fast_sweeping.h"
#include "common/levelset/initialize.h"
#include "common/levelset/scene.h"
#include "notes/peers/peer.h"

namespace lockstep::peers {
namespace {

using namespace levelset;

template <class F>
void for_each_point(const Scene& scene, const F& f) {
  for (int z = 0; z < scene.grid.nz; ++z)
    for (int y = 0; y < scene.grid.ny; ++y)
      for (int x = 0; x < scene.grid.nx; ++x)
        f(x, y, z, std::abs(signed_distance(scene.shapes, scene.grid.position(x, y, z))));
}

// The scene's values at the points within its band, and nothing else. What is not there has the sign of its side:
// otherwise the band's inner edge would be a surface.
openvdb::FloatGrid::Ptr grid_of(const Scene& scene) {
  const double farthest = std::min(scene.band, 1e6);
  auto grid = openvdb::FloatGrid::create(static_cast<float>(farthest));
  grid->setTransform(openvdb::math::Transform::createLinearTransform(scene.grid.spacing));
  auto at = grid->getAccessor();
  for_each_point(scene, [&](int x, int y, int z, double exact) {
    if (exact <= farthest) at.setValue({x, y, z}, scene.phi(x, y, z));
  });
  openvdb::tools::signedFloodFill(grid->tree());
  return grid;
}

// The errors of |distance| where the exact one is at least a spacing within the band, in spacings.
template <class F>
Json errors(const Scene& scene, const F& distance) {
  double sum = 0, most = 0, points = 0, missing = 0;
  for_each_point(scene, [&](int x, int y, int z, double exact) {
    if (exact > scene.band - scene.grid.spacing) return;
    const double found = distance(x, y, z);
    if (!(found < scene.band + scene.grid.spacing && found < 1e6)) {
      ++missing;
      return;
    }
    const double error = std::abs(found - exact) / scene.grid.spacing;
    sum += error, most = std::max(most, error), ++points;
  });
  return {{"mean_error_spacings", sum / points}, {"most_error_spacings", most}, {"missing_points", missing}};
}

void compare(Json& rows, const Asked& asked) {
  for (const std::string& name : asked.scenes) {
    const Scene scene = load_scene(path_of("levelset", name));
    if (scene.shapes.empty()) throw std::runtime_error("this comparison is for shapes whose distance is known");
    const openvdb::FloatGrid::Ptr start = grid_of(scene);
    openvdb::FloatGrid::Ptr found;
    Distances<float> ours;
    for (const int threads : asked.threads) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      Json row = {{"work", "distances from a level set"},
                  {"scene", scene.name},
                  {"ours", "levelset/initialize and levelset/fast_sweeping sweeps"},
                  {"items", {{"points", start->activeVoxelCount()}}}};
      row.update(take_turns(
          threads, 1,
          {[&] { found.reset(); }, [&] { found = openvdb::tools::sdfToSdf(*start, 0.f, scene.rounds); }},
          {[] {},
           [&] {
             openmp::initialize(scene.phi, ours);
             openmp::fast_sweeping_sweeps(ours, static_cast<float>(scene.band), scene.rounds);
           }}));
      const auto at = found->getConstAccessor();
      row["quality"] =
          errors(scene, [&](int x, int y, int z) { return std::abs(at.getValue(openvdb::Coord(x, y, z))); });
      row["ours_quality"] = errors(scene, [&](int x, int y, int z) { return ours.distance(x, y, z); });
      row["not_the_same"] =
          "Both in float, one round of eight sweeps. OpenVDB keeps its points in a sparse tree and is told which points"
          " are in the band; ours goes through a dense grid and finds out. OpenVDB's distances have a sign.";
      rows.push_back(row);
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
