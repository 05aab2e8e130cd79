#include "verify/sensitivity.h"

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "verify/selection.h"

namespace lockstep::verify {
namespace {

// Eight channels of DDR5-4800, 8 bytes wide: the most that they can carry. A triad reaches less.
constexpr double server_gb_per_s = 8 * 4.8 * 8;
constexpr double times_as_dear[] = {.5, 1, 2};

struct Looked {
  const char *kernel, *form, *scene, *quick_scene;
};
constexpr Looked all[] = {
    {"rigid/step", "batches", "castle_hit", "castle"},
    {"fluid/step", "pair_lists", "dam_break_100k", "dam_break_5k"},
    {"cloth/step", "colours", "flag_128", "flag_33"},
    {"levelset/fast_sweeping", "sweeps", "spheres_and_box_256_full", "spheres_and_box_128_full"},
    {"linear/multiply", "block_rows", "elasticity_48", "elasticity_24"},
};

// This machine, and it with other forks and barriers, each with its own memory and with the server's.
struct Variation {
  double barriers, memory_gb_per_s;
};
std::vector<Variation> variations(const Model& model) {
  std::vector<Variation> found;
  for (const double memory : {model.costs.bytes_per_ns, server_gb_per_s})
    for (const double barriers : times_as_dear) found.push_back({barriers, memory});
  return found;
}

Model varied(const Model& model, const Variation& variation) {
  return with_given(model, {{"fork_join_2_ns", variation.barriers * model.costs.fork_join.two},
                            {"barrier_2_ns", variation.barriers * model.costs.barrier.two},
                            {"memory_gb_per_s", variation.memory_gb_per_s}});
}

}  // namespace

void sensitivity(const FigureOptions& options, const Model& model, RowsOf& rows) {
  const std::vector<Variation> all_variations = variations(model);
  std::vector<Model> models;
  for (const Variation& variation : all_variations) models.push_back(varied(model, variation));
  for (const Looked& look : all) {
    const std::string scene = options.quick ? look.quick_scene : look.scene;
    const Selected selected = select_one(look.kernel, look.form, scene);
    std::optional<Case> run;  // made for the first row that is measured
    for (const int cores : {1, 64})
      rows.add({{"kernel", look.kernel}, {"form", look.form}, {"scene", scene}, {"cores", cores}}, [&] {
        progress("sensitivity: " + selected.kernel.name + ", " + std::to_string(cores) + " cores");
        if (!run) run = selected.kernel.make(selected.scene_path);
        const Repeatable what = {run->reset, run->openmp, run->work.bytes, run->work.data};
        std::vector<Replayed> least(models.size(), {.total = std::numeric_limits<double>::infinity()});
        for (int repeat = 0; repeat < (options.quick ? 1 : 5); ++repeat) {
          const Record made = record_once(what, cores, model);
          for (std::size_t m = 0; m < models.size(); ++m) keep_shorter(least[m], replay(made, what, models[m]));
        }
        Rows row;
        for (std::size_t m = 0; m < models.size(); ++m) {
          Rows varied = {{"barriers", all_variations[m].barriers},
                         {"memory_gb_per_s", all_variations[m].memory_gb_per_s}};
          varied.update(fields_of(least[m], what, cores, models[m]));
          row["replays"].push_back(varied);
        }
        return row;
      });
  }
}

}  // namespace lockstep::verify
