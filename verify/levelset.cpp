// The level set's kernels, as the verifier and the benchmark see them.
//
// Every openmp form has the bits of the serial form of the same algorithm. Whether the alternatives find the same distances is asked in
// rows of their own: sweeping until nothing changes against marching (`sweeps_for_heap`), and blocks against the undivided grid
// (`blocks_for_heap`, `blocks_for_sweeps`).
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include "common/levelset/blocks.h"
#include "common/levelset/fast_marching.h"
#include "common/levelset/fast_sweeping.h"
#include "common/levelset/initialize.h"
#include "common/levelset/scene.h"
#include "verify/compare.h"
#include "verify/domain.h"
#include "verify/kernel.h"

namespace lockstep::verify {
namespace {

using namespace levelset;

struct Inputs {
  Scene scene;
  Distances<float> start;  // as the serial initialize leaves them
  float band;
};

// The scene of one kernel after another; fields are large, so only the last one is kept.
std::shared_ptr<const Inputs> inputs(const std::string& path) {
  static std::string last_path;
  static std::shared_ptr<const Inputs> last;
  if (path == last_path) return last;
  last.reset();
  auto in = std::make_shared<Inputs>(Inputs{.scene = load_scene(path), .start = {}, .band = 0});
  in->band = static_cast<float>(in->scene.band);
  serial::initialize(in->scene.phi, in->start);
  last_path = path;
  return last = in;
}

using Change = std::function<void(Distances<float>&)>;

ElementName point_name(const Field<float>& field) {
  return [ny = field.ny, pitch = field.pitch](std::size_t i) {
    const int x = static_cast<int>(i % pitch) - Field<float>::padding, line = static_cast<int>(i / pitch);
    return "distance of (" + std::to_string(x) + ", " + std::to_string(line % ny) + ", " + std::to_string(line / ny) + ")";
  };
}

double points_within(const Distances<float>& d) {
  return static_cast<double>(std::ranges::count_if(d.distance.value, [](float v) { return v < far<float>; }));
}

constexpr double flops_of_upwind = 30;

// A kernel compared bitwise with its twin. What counts as work are the points whose distances are wanted.
Case bitwise_case(std::shared_ptr<const Inputs> in, Change twin, Change best, Change openmp, double flops_a_point) {
  struct State {
    std::shared_ptr<const Inputs> in;
    Distances<float> openmp, serial, expected;
  };
  auto s = std::make_shared<State>(State{in, in->start, in->start, in->start});
  twin(s->expected);
  const double points = points_within(s->expected);
  return {
      .reset = [s] { s->openmp.distance.value = s->serial.distance.value = s->in->start.distance.value; },
      .serial = [s, twin] { twin(s->serial); },
      .best_serial = best ? std::function<void()>([s, best] { best(s->serial); }) : nullptr,
      .openmp = [s, openmp] { openmp(s->openmp); },
      .judge =
          [s] {
            Judgement judgement{.verdict = Verdict::bitwise, .worst_at = ""};
            same_bits(judgement, std::span<const float>(s->openmp.distance.value), std::span<const float>(s->expected.distance.value),
                      point_name(s->expected.distance));
            return judgement;
          },
      .hash = [s] { return hash_bytes(std::span<const float>(s->openmp.distance.value)); },
      .work = {points, "points", 8 * points, flops_a_point * points},
  };
}

using Rounds = std::function<int(Distances<float>&)>;

// A sweeping kernel that must also know when nothing changes any more: after as many rounds as its twin, with the same distances.
Case until_nothing_changes_case(std::shared_ptr<const Inputs> in, Case kernel, Rounds twin, Rounds openmp) {
  struct Expected {
    Distances<float> distances;
    int rounds = 0;
  };
  const auto expected = std::make_shared<Expected>();
  kernel.judge = [in, twin, openmp, expected, judge = kernel.judge] {
    Judgement judgement = judge();
    if (expected->rounds == 0) {
      expected->distances = in->start;
      expected->rounds = twin(expected->distances);
    }
    Distances<float> d = in->start;
    const int rounds = openmp(d);
    same_bits(judgement, std::span<const float>(d.distance.value), std::span<const float>(expected->distances.distance.value),
              point_name(d.distance));
    if (rounds != expected->rounds) {
      judgement.passed = false;
      judgement.worst_at = both_values("rounds until nothing changes", rounds, expected->rounds);
    }
    return judgement;
  };
  return kernel;
}

Case initialize_case(const std::string& path) {
  struct State {
    std::shared_ptr<const Inputs> in;
    Distances<float> openmp, serial;
  };
  auto s = std::make_shared<State>(State{inputs(path), {}, {}});
  const Field<float>& phi = s->in->scene.phi;
  const double points = double(phi.nx) * phi.ny * phi.nz;
  return {
      .reset =
          [s] {  // what the field before has left
            s->openmp = s->in->start;
            std::ranges::fill(s->openmp.distance.value, 0.f);
          },
      .serial = [s] { serial::initialize(s->in->scene.phi, s->serial); },
      .best_serial = nullptr,
      .openmp = [s] { openmp::initialize(s->in->scene.phi, s->openmp); },
      .judge =
          [s] {
            Judgement judgement{.verdict = Verdict::bitwise, .worst_at = ""};
            const Distances<float>& expected = s->in->start;
            same_bits(judgement, std::span<const float>(s->openmp.distance.value), std::span<const float>(expected.distance.value),
                      point_name(expected.distance));
            const auto same = [](const Point& a, const Point& b) { return a.x == b.x && a.y == b.y && a.z == b.z; };
            if (!std::ranges::equal(s->openmp.interface, expected.interface, same)) {
              judgement.passed = false;
              judgement.worst_at = "interface points: openmp " + std::to_string(s->openmp.interface.size()) + ", serial " +
                                   std::to_string(expected.interface.size());
            }
            return judgement;
          },
      .hash = [s] { return hash_bytes(std::span<const float>(s->openmp.distance.value)); },
      .work = {points, "points", 8 * points, 20 * points},
  };
}

// Two algorithms for the same discrete equations. A solution rounds by less than ten u of itself, and takes an error of its
// neighbours over without making it larger (each is the least of averages of its neighbours); a path from the interface to the edge of the
// band has at the most three steps a spacing. So in the band two solutions are within 10 u (3 band / h) band of each other, and of points
// where only one of them is within the band, that one is as near to its edge.
Case same_distances_case(std::shared_ptr<const Inputs> in, Change reference, Change other, const std::string& what) {
  struct State {
    std::shared_ptr<const Inputs> in;
    Distances<float> reference, other;
  };
  auto s = std::make_shared<State>(State{in, in->start, in->start});
  reference(s->reference);
  const double points = points_within(s->reference);
  return {
      .reset = [s] { s->other.distance.value = s->in->start.distance.value; },
      .serial =
          [in, reference] {
            Distances<float> d = in->start;
            reference(d);
          },
      .best_serial = nullptr,
      .openmp = [s, other] { other(s->other); },
      .judge =
          [s, what] {
            Judgement judgement{.verdict = Verdict::converged, .worst_at = ""};
            const std::vector<float, AlignedAllocator<float>>&a = s->reference.distance.value, &b = s->other.distance.value;
            double widest = 0;
            for (const float v : a)
              if (v < far<float>) widest = std::max(widest, double(v));
            const double h = s->in->scene.phi.spacing;
            judgement.bound = 10 * unit_roundoff * (3 * widest / h) * widest;
            for (std::size_t i = 0; i < a.size(); ++i) {
              const bool only_one = (a[i] < far<float>) != (b[i] < far<float>);
              const double error = only_one ? std::abs(double(std::min(a[i], b[i])) - s->in->band) : std::abs(double(a[i]) - b[i]);
              if (error > judgement.error || !std::isfinite(error)) {
                judgement.error = error;
                judgement.worst_at = both_values(point_name(s->reference.distance)(i), b[i], a[i]);
              }
              if (!(error <= judgement.bound)) judgement.passed = false;
            }
            judgement.worst_at += (judgement.worst_at.empty() ? "" : "; ") + what;
            return judgement;
          },
      .hash = [s] { return hash_bytes(std::span<const float>(s->other.distance.value)); },
      .work = {points, "points", 8 * points, flops_of_upwind * points},
  };
}

// Blocks do the work of their padding again: by how much more points they look at.
std::string overlap(const Inputs& in) {
  double own = 0, padded = 0;
  const auto size = [](const Extent& x, const Extent& y, const Extent& z) {
    return double(x.end - x.begin) * (y.end - y.begin) * (z.end - z.begin);
  };
  const std::vector<Block> blocks = make_blocks(in.start, in.band, block_size);
  for (const Block& b : blocks) own += size(b.x, b.y, b.z), padded += size(b.padded_x, b.padded_y, b.padded_z);
  char text[80];
  std::snprintf(text, sizeof text, "%zu blocks, padded %.2f times their size", blocks.size(), padded / own);
  return text;
}

}  // namespace

std::vector<Kernel> levelset_kernels() {
  using Scenes = std::vector<std::string>;
  const auto scenes = [](Scenes names) {
    for (std::string& name : names) name = "scenes/levelset/" + name + ".toml";
    return names;
  };
  const Scenes in_bands = scenes({"slab_33", "slab_on_points", "spheres_and_box_64", "corrupted_64", "mesh_96", "torus_128"});
  const Scenes full = scenes({"spheres_and_box_64_full"});
  const Scenes more_bands = scenes({"spheres_and_box_128", "spheres_and_box_256", "corrupted_256"});
  const Scenes more_full = scenes({"spheres_and_box_128_full", "spheres_and_box_256_full"});
  const auto with = [](Scenes some, const Scenes& others) {
    some.insert(some.end(), others.begin(), others.end());
    return some;
  };
  const Scenes bench_band = scenes({"spheres_and_box_256"}), bench_both = scenes({"spheres_and_box_256", "spheres_and_box_256_full"});

  std::vector<Kernel> kernels;
  const auto takes = [](const std::string& path) { return domain_of_scene(path).name == "levelset"; };
  const auto add = [&](const char* name, const char* form, Scenes some, Scenes more, Scenes bench, auto make) {
    kernels.push_back({name, form, false, std::move(some), std::move(more), std::move(bench), takes, make});
  };
  constexpr int until_nothing_changes = 1000;
  const auto rounds_of = [](FastSweeping<float>* sweeping, const Inputs& in) -> Rounds {
    return [sweeping, band = in.band](Distances<float>& d) { return sweeping(d, band, until_nothing_changes); };
  };
  const auto rounds_of_blocks = [](FastSweepingInBlocks<float>* sweeping, const Inputs& in) -> Rounds {
    return [sweeping, band = in.band](Distances<float>& d) { return sweeping(d, band, until_nothing_changes, block_size); };
  };
  const auto sweep = [](FastSweeping<float>* sweeping, const Inputs& in, int rounds) -> Change {
    return [sweeping, band = in.band, rounds](Distances<float>& d) { sweeping(d, band, rounds); };
  };
  const auto march = [](FastMarching<float>* marching, const Inputs& in) -> Change {
    return [marching, band = in.band](Distances<float>& d) { marching(d, band); };
  };
  const auto sweep_blocks = [](FastSweepingInBlocks<float>* sweeping, const Inputs& in, int rounds) -> Change {
    return [sweeping, band = in.band, rounds](Distances<float>& d) { sweeping(d, band, rounds, block_size); };
  };
  const auto march_blocks = [](FastMarchingInBlocks<float>* marching, const Inputs& in) -> Change {
    return [marching, band = in.band](Distances<float>& d) { marching(d, band, block_size); };
  };

  add("levelset/initialize", "", with(in_bands, full), with(more_bands, more_full), bench_band, initialize_case);
  add("levelset/fast_marching", "blocks", in_bands, more_bands, bench_band, [=](const std::string& path) {
    const auto in = inputs(path);
    return bitwise_case(in, march_blocks(serial::fast_marching_blocks, *in), march(serial::fast_marching_heap, *in),
                        march_blocks(openmp::fast_marching_blocks, *in), 3 * flops_of_upwind);
  });
  add("levelset/fast_marching", "blocks_for_heap", in_bands, more_bands, {}, [=](const std::string& path) {
    const auto in = inputs(path);
    return same_distances_case(in, march(serial::fast_marching_heap, *in), march_blocks(openmp::fast_marching_blocks, *in), overlap(*in));
  });
  add("levelset/fast_sweeping", "sweeps", with(in_bands, full), with(more_bands, more_full), bench_both, [=](const std::string& path) {
    const auto in = inputs(path);
    return until_nothing_changes_case(in,
                                      bitwise_case(in, sweep(serial::fast_sweeping_sweeps, *in, in->scene.rounds), nullptr,
                                                   sweep(openmp::fast_sweeping_sweeps, *in, in->scene.rounds), 8 * flops_of_upwind),
                                      rounds_of(serial::fast_sweeping_sweeps, *in), rounds_of(openmp::fast_sweeping_sweeps, *in));
  });
  add("levelset/fast_sweeping", "sweeps_for_heap", with(in_bands, full), with(more_bands, more_full), {}, [=](const std::string& path) {
    const auto in = inputs(path);
    Distances<float> d = in->start;
    const int rounds = openmp::fast_sweeping_sweeps(d, in->band, until_nothing_changes);
    return same_distances_case(in, march(serial::fast_marching_heap, *in), sweep(openmp::fast_sweeping_sweeps, *in, until_nothing_changes),
                               std::to_string(rounds) + " rounds until nothing changed");
  });
  add("levelset/fast_sweeping", "blocks", in_bands, more_bands, bench_band, [=](const std::string& path) {
    const auto in = inputs(path);
    return until_nothing_changes_case(in,
                                      bitwise_case(in, sweep_blocks(serial::fast_sweeping_blocks, *in, in->scene.rounds),
                                                   sweep(serial::fast_sweeping_sweeps, *in, in->scene.rounds),
                                                   sweep_blocks(openmp::fast_sweeping_blocks, *in, in->scene.rounds), 8 * flops_of_upwind),
                                      rounds_of_blocks(serial::fast_sweeping_blocks, *in),
                                      rounds_of_blocks(openmp::fast_sweeping_blocks, *in));
  });
  add("levelset/fast_sweeping", "blocks_for_sweeps", in_bands, more_bands, {}, [=](const std::string& path) {
    const auto in = inputs(path);
    return same_distances_case(in, sweep(serial::fast_sweeping_sweeps, *in, until_nothing_changes),
                               sweep_blocks(openmp::fast_sweeping_blocks, *in, until_nothing_changes), overlap(*in));
  });
  return kernels;
}

}  // namespace lockstep::verify
