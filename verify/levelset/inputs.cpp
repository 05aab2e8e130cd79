#include "verify/levelset/inputs.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "common/levelset/blocks.h"
#include "common/levelset/initialize.h"
#include "verify/inputs.h"
#include "verify/twin.h"

namespace lockstep::verify::levelset_inputs {

using namespace levelset;

namespace {

Inputs make(const std::string& path) {
  Inputs in{.scene = load_scene(path), .start = {}, .band = 0};
  in.band = static_cast<float>(in.scene.band);
  serial::initialize(in.scene.phi, in.start);
  return in;
}

double points_within(const Distances<float>& d) {
  return static_cast<double>(std::ranges::count_if(d.distance.value, [](float v) { return v < far<float>; }));
}

}  // namespace

// For the cache.
double bytes_of(const Inputs& in) { return 4. * in.scene.phi.value.size() + lockstep::bytes_of(in.start); }

std::shared_ptr<const Inputs> inputs(const std::string& path) {
  return verify::inputs<Inputs>(path, [&] { return make(path); });
}

ValueName point_name(const Field<float>& field) {
  return [ny = field.ny, pitch = field.pitch](const std::string& array, std::size_t i, const std::string& of) {
    if (array != "distance") return value_name(array, i, of);
    const int x = static_cast<int>(i % pitch) - Field<float>::padding, line = static_cast<int>(i / pitch);
    return "distance of (" + std::to_string(x) + ", " + std::to_string(line % ny) + ", " + std::to_string(line / ny) +
           ")";
  };
}

Case bitwise_case(std::shared_ptr<const Inputs> in, Change twin, Change best, Change openmp, double flops_a_point) {
  Distances<float> distances = in->start;
  twin(distances);
  const double points = points_within(distances);
  return make_case<Distances<float>>({
      .start = {in, &in->start},
      .serial = twin,
      .best_serial = best,
      .openmp = openmp,
      .compare = [in](const auto& openmp,
                      const auto& serial) { return bitwise(openmp, serial, point_name(in->start.distance)); },
      .work = {points, "points", 8 * points, flops_a_point * points},
      .restore = [](auto& now, const auto& start) { now.distance.value = start.distance.value; },
      .hash = [](const auto& now) { return hash_bytes(std::span<const float>(now.distance.value)); },
  });
}

// A solution rounds by less than ten u of itself, and does not make an error of its neighbours larger (its derivatives
// by them are >= 0 and sum to 1); a path from the interface to the edge of the band has at most three steps a spacing.
// So in the band two solutions are within 10 u (3 band / h) band of each other. Where only one of the two is within the
// band, it must be as near to the band's edge.
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
            const Array<float>&a = s->reference.distance.value, &b = s->other.distance.value;
            double widest = 0;
            for (const float v : a)
              if (v < far<float>) widest = std::max(widest, double(v));
            const double h = s->in->scene.phi.spacing;
            judgement.bound = 10 * unit_roundoff * (3 * widest / h) * widest;
            for (std::size_t i = 0; i < a.size(); ++i) {
              const bool only_one = (a[i] < far<float>) != (b[i] < far<float>);
              const double error =
                  only_one ? std::abs(double(std::min(a[i], b[i])) - s->in->band) : std::abs(double(a[i]) - b[i]);
              if (error > judgement.error || !std::isfinite(error)) {
                judgement.error = error;
                judgement.worst_at = both_values(point_name(s->reference.distance)("distance", i, ""), b[i], a[i]);
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

Scenes scenes_in_bands(std::vector<std::string> bench) {
  return {.verify = {"slab_33", "slab_on_points", "spheres_and_box_64", "corrupted_64", "mesh_96", "torus_128"},
          .more = {"spheres_and_box_128", "spheres_and_box_256", "corrupted_256"},
          .bench = std::move(bench),
          .tsan = {"torus_128"}};  // more than one block
}

Scenes scenes_of_all(std::vector<std::string> bench) {
  Scenes scenes = scenes_in_bands(std::move(bench));
  scenes.verify.push_back("spheres_and_box_64_full");
  scenes.more.insert(scenes.more.end(), {"spheres_and_box_128_full", "spheres_and_box_256_full"});
  scenes.tsan = {"slab_33", "spheres_and_box_64_full"};
  return scenes;
}

Scenes without_tsan(Scenes scenes) {
  scenes.tsan.clear();
  return scenes;
}

}  // namespace lockstep::verify::levelset_inputs
