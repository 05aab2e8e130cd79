// libccd: whether two hulls overlap, by its GJK, for the pairs whose boxes overlap.
#include <ccd/ccd.h>

#include <algorithm>
#include <filesystem>
#include <vector>

#include "common/rigid/gjk.h"
#include "notes/peers/peer.h"
#include "verify/rigid/narrow_inputs.h"

namespace lockstep::peers {
namespace {

using namespace rigid;
using namespace verify::rigid_inputs;

// A hull's corners, in the world.
using Corners = std::vector<ccd_vec3_t>;

void support(const void* hull, const ccd_vec3_t* direction, ccd_vec3_t* farthest) {
  const ccd_vec3_t* best = nullptr;
  double most = 0;
  for (const ccd_vec3_t& corner : *static_cast<const Corners*>(hull))
    if (const double along = ccdVec3Dot(&corner, direction); !best || along > most) best = &corner, most = along;
  ccdVec3Copy(farthest, best);
}

std::vector<Corners> corners_of(const Inputs& in) {
  const auto& [colliders, hulls, poses] = in.placed();
  std::vector<Corners> corners(colliders.count);
  for (int c = 0; c < colliders.count; ++c) {
    const int hull = colliders.hull[c];
    if (hull < 0) continue;
    for (int v = hulls.first_vertex[hull]; v < hulls.first_vertex[hull + 1]; ++v) {
      const Quad<float>&p = hulls.vertex[v], &size = colliders.size[c];
      const auto& [position, q, unused] = poses[c];
      const Vector3<double> local = {double(p.x) * size.x, double(p.y) * size.y, double(p.z) * size.z},
                            turned = matrix_of(Quaternion<double>{q.x, q.y, q.z, q.w}) * local;
      corners[c].push_back({{position.x + turned.x, position.y + turned.y, position.z + turned.z}});
    }
  }
  return corners;
}

void compare(Json& rows, const Asked& asked) {
  for (const std::string& name : asked.scenes) {
    const auto in = inputs(path_of("rigid", name));
    const SharedPairs pairs = convex_pairs(*in);
    const std::vector<Corners> corners = corners_of(*in);
    ccd_t ccd;
    CCD_INIT(&ccd);
    ccd.support1 = ccd.support2 = support;
    ccd.max_iterations = 100;
    std::vector<char> overlap(pairs->size());
    const Distances start = not_yet_known(*in, *pairs, false);
    Distances found = start;
    for (const int threads : asked.threads) {
      Json row = {{"work", "pairs of hulls by GJK"},
                  {"scene", std::filesystem::path(name).stem().string()},
                  {"ours", "rigid/gjk cold"},
                  {"items", {{"pairs", pairs->size()}}}};
      row.update(take_turns(threads, 1,
                            {[] {},
                             [&] {
                               for (std::size_t k = 0; k < pairs->size(); ++k) {
                                 const auto& [a, b] = (*pairs)[k];
                                 overlap[k] = ccdGJKIntersect(&corners[a], &corners[b], &ccd) != 0;
                               }
                             }},
                            {[&] { found.simplex = start.simplex; },
                             [&] { openmp::gjk(in->placed(), *pairs, found.simplex, found.closest.span()); }}));
      double overlaps = 0, our_overlaps = 0, differ = 0;
      for (std::size_t k = 0; k < pairs->size(); ++k) {
        const bool ours = found.closest.record[k].distance == 0;
        overlaps += overlap[k], our_overlaps += ours, differ += ours != bool(overlap[k]);
      }
      row["quality"] = {{"overlaps", overlaps}, {"pairs_that_differ", differ}};
      row["ours_quality"] = {{"overlaps", our_overlaps}, {"pairs_that_differ", differ}};
      row["not_the_same"] =
          "libccd, in double, says only whether hulls overlap; ours, in float, finds distance and closest points too,"
          " both from nothing. Its corners stand in the world before the clock starts, ours are placed within.";
      rows.push_back(row);
    }
  }
}

}  // namespace
}  // namespace lockstep::peers

int main(int count, char** words) {
  using namespace lockstep::peers;
  return report([&](Json& rows) { compare(rows, asked(count, words)); });
}
