// The rows and benchmarks of GJK: bitwise with the serial twin, from the simplices of the step before (warm) and from
// none (cold).
#include <algorithm>

#include "openmp/rigid/full_blocks.h"
#include "verify/rigid/narrow_inputs.h"

namespace lockstep::verify::rigid_gjk {
namespace {

using namespace rigid;
using namespace rigid_inputs;

// How full the lanes are in the iterations of gjk. A block ends when few of its pairs are left. The blocks are replayed
// with as many iterations as each pair took. The first iteration of a pair without a simplex needs no loop.
double lane_use(const Placed<float>& placed, std::span<const Pair> pairs, std::span<const Closest<float>> closest,
                bool warm) {
  double used = 0, there = 0;
  for (std::size_t first = 0; first < pairs.size(); first += openmp::chunk_size) {
    const int n = static_cast<int>(std::min<std::size_t>(openmp::chunk_size, pairs.size() - first));
    std::vector<int> left(n);
    for (int k = 0; k < n; ++k) left[k] = closest[first + k].iterations - !warm;
    openmp::in_full_blocks(
        n, [&](int k) { return openmp::size_key(placed, pairs[first + k]); },
        [&](std::span<std::int32_t> which, int enough) {
          const auto unfinished = [&] {
            return static_cast<int>(std::ranges::count_if(which, [&](int k) { return left[k] > 0; }));
          };
          for (int active = unfinished(); active > enough; active = unfinished()) {
            used += active, there += lanes;
            for (const int k : which) left[k] -= left[k] > 0;
          }
          std::stable_partition(which.begin(), which.end(), [&](int k) { return left[k] > 0; });
          return unfinished();
        });
  }
  return there > 0 ? used / there : 0;
}

Case gjk_case(const std::string& path, bool warm) {
  const auto in = inputs(path);
  const SharedPairs pairs = convex_pairs(*in);
  const auto with = [=](Gjk<float>* gjk) {
    return [=](Distances& d) { gjk(in->placed(), *pairs, d.simplex, d.closest.span()); };
  };
  const double n = static_cast<double>(pairs->size());
  Distances there = serial_distances(*in, *pairs, warm);
  return make_case<Distances>({
      .start = std::make_shared<const Distances>(not_yet_known(*in, *pairs, warm)),
      .serial = with(serial::gjk),
      .best_serial = nullptr,
      .openmp = with(openmp::gjk),
      .compare = nullptr,
      .work = {n, "pairs", n * (2 * bytes_of_pose + sizeof(Closest<float>)), n * 2000,
               lane_use(in->placed(), *pairs, there.closest.span(), warm)},
  });
}

const Register gjk{{.name = "rigid/gjk",
                    .place = 9,
                    .forms = {{.name = "warm",
                               .make = [](const std::string& path) { return gjk_case(path, true); },
                               .scenes = hull_scenes()},
                              {.name = "cold",
                               .make = [](const std::string& path) { return gjk_case(path, false); },
                               .scenes = and_more(hull_scenes(), "hull_soup_100k")}}}};

}  // namespace
}  // namespace lockstep::verify::rigid_gjk
