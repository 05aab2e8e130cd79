#include "verify/production_cloth/frame.h"

#include <omp.h>

#include <string>

#include "common/production_cloth/scene.h"
#include "verify/held_team.h"
#include "verify/production_cloth/forms.h"
#include "verify/production_cloth/moving.h"
#include "verify/program.h"

namespace lockstep::verify {
namespace {

using namespace production_cloth;

constexpr int measured_frame = 180;  // at 3 s: the ball has lifted the curtain

// Runs the steps of a frame; after_step() sees each.
template <class AfterStep>
void run_frame(const Scene& scene, const Cloth<float>& cloth, int frame, Step<float>* step, Motion<float>& motion,
               StepMemory<float>& memory, const AfterStep& after_step) {
  const double dt = scene.frame_time / scene.substeps;
  for (int k = frame * scene.substeps; k < (frame + 1) * scene.substeps; ++k) {
    step(cloth, script_of(scene, k * dt, (k + 1) * dt), motion, memory);
    after_step();
  }
}

}  // namespace

void rows_of_cloth_frame(const std::function<void(FrameRow fields, const std::function<FrameRow()>& measure)>& add) {
  const std::string name = "curtain_and_ball_5k";
  const Scene scene = load_scene("scenes/production_cloth/" + name + ".toml");
  const Cloth<float> cloth = make_cloth(scene);
  Motion<float> start = motion_at_rest(scene);
  StepMemory<float> in_order = production_cloth::serial::make_memory(cloth),
                    in_lanes = production_cloth::openmp::make_memory(cloth);
  for (int frame = 0; frame < measured_frame; ++frame) {
    progress("cloth_modules: " + name + ", frame " + std::to_string(frame));
    run_frame(scene, cloth, frame, production_cloth::openmp::step_batches, start, in_lanes, [] {});
  }

  const auto row = [&](const std::string& variant, int threads, Step<float>* step, StepMemory<float>& memory) {
    progress("cloth_modules: " + name + ", " + variant + ", threads " + std::to_string(threads));
    add({{"scene", name}, {"variant", variant}, {"form", "batches"}, {"threads", threads}}, [&] {
      Motion<float> motion = start;
      double seconds[int(Module::count)] = {};
      std::int64_t iterations = 0, near = 0, impacts = 0;
      hold_team(threads, [&] {
        run_frame(scene, cloth, measured_frame, step, motion, memory, [&] {
          for (int k = 0; k < int(Module::count); ++k) seconds[k] += memory.seconds[k];
          iterations += memory.took.iterations, near += memory.took.near, impacts += memory.took.collided.impacts;
        });
      });
      FrameRow fields = {{"triangles", cloth.topology.triangles.size()},
                         {"steps", scene.substeps},
                         {"iterations", iterations},
                         {"near", near},
                         {"impacts", impacts}};
      for (int k = 0; k < int(Module::count); ++k)
        fields["modules"].push_back({{"module", name_of_module[k]}, {"ms", 1e3 * seconds[k]}});
      return fields;
    });
  };
  const int most = omp_get_max_threads();
  row("serial", 1, production_cloth::serial::step_original, in_order);
  for (int threads = 1; threads <= most; threads *= 2)
    row("openmp", threads, production_cloth::openmp::step_batches, in_lanes);
  omp_set_num_threads(most);
}

}  // namespace lockstep::verify
