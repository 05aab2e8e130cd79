#include "verify/sizes.h"

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "verify/selection.h"

namespace lockstep::verify {
namespace {

struct Growing {
  const char *kernel, *form;
  std::vector<const char*> scenes;  // smallest first
};
const std::vector<Growing> all = {
    {"rigid/contact_solver", "blocks", {"pyramid_15", "pyramid_24", "castle_hit", "castles_4"}},
    {"rigid/step", "blocks", {"pyramid_15", "pyramid_24", "castle_hit", "castles_4"}},
    {"rigid/gjk", "cold", {"soup_10", "hull_soup", "hull_pit_2000", "hull_soup_100k"}},
    {"fluid/step", "pair_lists", {"dam_break_5k", "dam_break_35k", "dam_break_100k", "dam_break_500k"}},
    {"cloth/relax", "colours", {"flag_33", "flag_128", "flag_256", "flag_1024"}},
    {"levelset/fast_sweeping",
     "sweeps",
     {"spheres_and_box_64_full", "spheres_and_box_128_full", "spheres_and_box_256_full", "spheres_and_box_512_full"}},
    {"levelset/fast_sweeping",
     "blocks",
     {"spheres_and_box_64", "spheres_and_box_128", "spheres_and_box_256", "spheres_and_box_512"}},
};
constexpr std::size_t quick_scenes = 2;
constexpr int most_records = 15;  // of a row

}  // namespace

void problem_sizes(const FigureOptions& options, const Model& model, RowsOf& rows) {
  for (const Growing& growing : all)
    for (std::size_t k = 0; k < (options.quick ? quick_scenes : growing.scenes.size()); ++k) {
      const std::string scene = growing.scenes[k];
      const Selected selected = select_one(growing.kernel, growing.form, scene);
      std::optional<Case> run;  // made for the first row that is modelled
      for (const int cores : {1, 64})
        rows.add({{"kernel", growing.kernel}, {"form", growing.form}, {"scene", scene}, {"cores", cores}}, [&] {
          progress("problem sizes: " + selected.kernel.name + ", " + scene);
          if (!run) run = selected.kernel.make(selected.scene_path);
          const Repeatable what = {run->reset, run->openmp, run->work.bytes, run->work.data};
          Replayed least = {.total = std::numeric_limits<double>::infinity()};
          const double enough = now() + (options.quick ? 0 : options.brief ? .3 : 1);
          const auto wanted = [&](int made) {
            return made < effort_of(options).fewest || (made < most_records && now() < enough);
          };
          for (int made = 0; wanted(made); ++made)
            keep_shorter(least, replay(record_once(what, cores, model), what, model));
          Rows row = {{"items", run->work.items}, {"unit", run->work.unit}};
          row.update(fields_of(least, what, cores, model));
          return row;
        });
    }
}

}  // namespace lockstep::verify
