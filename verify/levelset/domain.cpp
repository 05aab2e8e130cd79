// Level sets: what `run` does with their scenes.
#include <cmath>
#include <functional>
#include <memory>

#include "common/levelset/blocks.h"
#include "common/levelset/fast_marching.h"
#include "common/levelset/fast_sweeping.h"
#include "common/levelset/initialize.h"
#include "common/levelset/scene.h"
#include "common/levelset/vti.h"
#include "verify/domain.h"

namespace lockstep::verify {
namespace {

// A level set does not move: one step makes the distances.
Simulation simulation(const RunOptions& options) {
  struct State {
    levelset::Scene scene;
    levelset::Field<float> signed_distance;
  };
  using Compute = std::function<void(levelset::Distances<float>&, float band, int rounds)>;
  struct Form {
    std::string variant, name;
    levelset::Initialize<float>* initialize;
    Compute compute;
  };
  const auto march = [](levelset::FastMarching<float>* marching) -> Compute {
    return [marching](levelset::Distances<float>& d, float band, int) { marching(d, band); };
  };
  namespace serial = levelset::serial;
  namespace openmp = levelset::openmp;
  const auto sweep = [](levelset::FastSweeping<float>* sweeping) -> Compute { return sweeping; };
  const auto sweep_blocks = [](levelset::FastSweepingInBlocks<float>* sweeping) -> Compute {
    return [sweeping](levelset::Distances<float>& d, float band, int rounds) {
      sweeping(d, band, rounds, levelset::block_size);
    };
  };
  const Form forms[] = {{"serial", "sweeps", serial::initialize, sweep(serial::fast_sweeping_sweeps)},
                        {"serial", "blocks", serial::initialize, sweep_blocks(serial::fast_sweeping_blocks)},
                        {"serial", "heap", serial::initialize, march(serial::fast_marching_heap)},
                        {"openmp", "sweeps", openmp::initialize, sweep(openmp::fast_sweeping_sweeps)},
                        {"openmp", "blocks", openmp::initialize, sweep_blocks(openmp::fast_sweeping_blocks)}};

  auto state = std::make_shared<State>(State{levelset::load_scene(options.scene), {}});
  state->signed_distance = state->scene.phi;
  const Form form = find_form(forms, options.form, [&](const Form& f) { return f.variant == options.variant; });
  const auto write = [state](const std::string& path) {
    levelset::write_image(path, state->signed_distance, state->scene.grid, static_cast<float>(state->scene.band));
  };
  const levelset::Grid& grid = state->scene.grid;
  return {
      .name = state->scene.name,
      .form = form.name,
      .elements = grid.nx * grid.ny * grid.nz,
      .unit = "points",
      .frames = 1,
      .step =
          [state, form] {
            levelset::Distances<float> distances;
            form.initialize(state->scene.phi, distances);
            form.compute(distances, static_cast<float>(state->scene.band), state->scene.rounds);
            const Array<float>&phi = state->scene.phi.value, &d = distances.distance.value;
            for (std::size_t i = 0; i < d.size(); ++i) state->signed_distance.value[i] = phi[i] < 0 ? -d[i] : d[i];
          },
      .time_step = 0,
      .parts = {{"frame", true, write}},
      .write_state = write,
      .state_formats = {".vti", ".vtk"},
      .state = {},
      .fault =
          [state] {
            const Array<float>& d = state->signed_distance.value;
            return first_fault("point ", static_cast<int>(d.size()), " is NaN",
                               [&](int i) { return !std::isnan(d[i]); });
          },
      .summary = nullptr,
  };
}

// A scene that is loaded must have finite values of phi.
std::string fault_of_scene(const std::string& path) {
  const levelset::Scene scene = levelset::load_scene(path);
  for (const float phi : scene.phi.value)
    if (!std::isfinite(phi)) return "phi is not finite";
  return "";
}

const RegisterDomain levelset_domain{{.name = "levelset",
                                      .simulation = simulation,
                                      .moves = false,
                                      .determinism = {"torus_128"},
                                      .fault_of_scene = fault_of_scene}};

}  // namespace
}  // namespace lockstep::verify
