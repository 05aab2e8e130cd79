#include "verify/curves.h"

#include <omp.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "verify/pages.h"
#include "verify/selection.h"

namespace lockstep::verify {
namespace {

struct Curve {
  const char *kernel, *form, *scene, *quick_scene;
};
constexpr Curve all[] = {
    {"rigid/step", "batches", "castle_hit", "pyramid_24"},
    {"rigid/sweep_and_prune", "batch", "boxes_100k", "castle"},
    {"rigid/gjk", "cold", "hull_pit_2000", "hull_soup"},
    {"fluid/step", "pair_lists", "dam_break_500k", "dam_break_5k"},
    {"fluid/step", "owner_gather", "dam_break_500k", "dam_break_5k"},
    {"fluid/step", "sub_grid", "dam_break_500k", "dam_break_5k"},
    {"fluid/step", "cell_locks", "dam_break_500k", "dam_break_5k"},
    {"cloth/step", "colours", "flag_128", "flag_128"},
};

}  // namespace

void curves(const FigureOptions& options, const Model& model, RowsOf& rows) {
  const std::vector<int> numbers =
      options.quick ? std::vector<int>{1, 2, 64} : std::vector<int>{1, 2, 4, 8, 16, 32, 64, 128};
  for (const Curve& curve : all) {
    const std::string scene = options.quick ? curve.quick_scene : curve.scene;
    const Selected selected = select_one(curve.kernel, curve.form, scene);
    std::optional<Case> run;  // made for the first row that is modelled
    for (const int cores : numbers)
      rows.add({{"kernel", curve.kernel}, {"form", curve.form}, {"scene", scene}, {"cores", cores}}, [&] {
        progress("curves: " + selected.kernel.name + " " + curve.form + ", " + std::to_string(cores) + " cores");
        if (!run) {
          const PagesOfTeam near(std::min(numbers.back(), omp_get_num_procs()));
          run = selected.kernel.make(selected.scene_path);
        }
        return scale_row(model, {run->reset, run->openmp, run->work.bytes, run->work.data}, cores, effort_of(options));
      });
  }
}

}  // namespace lockstep::verify
