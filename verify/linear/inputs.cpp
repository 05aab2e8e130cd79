#include "verify/linear/inputs.h"

#include <random>
#include <utility>

#include "verify/inputs.h"

namespace lockstep::verify::linear_inputs {

using namespace linear;

namespace {

template <class Matrix>
double bytes_of_rows(const Matrix& a) {
  return 4. * double(a.begin.size() + a.column.size() + a.value.size());
}

}  // namespace

// For the cache.
double bytes_of(const Inputs& in) {
  return bytes_of_rows(in.scene.rows) + bytes_of_rows(in.scene.blocks) + linear::bytes_of(in.sliced) +
         linear::bytes_of(in.sliced_blocks) + 4. * double(in.scene.b.size() + in.x.size());
}
double bytes_of(const Factored& in) {
  return bytes_of_rows(in.rows) + bytes_of_rows(in.factor.lower) + bytes_of_rows(in.factor.upper) +
         linear::bytes_of(in.sliced) + linear::bytes_of(in.sliced_factor.lower) +
         linear::bytes_of(in.sliced_factor.upper) + 20. * double(in.b.size());
}

std::shared_ptr<const Inputs> inputs(const std::string& path) {
  return verify::inputs<Inputs>(path, [&] {
    Inputs in{.scene = load_scene(path), .x = {}, .sliced = {}, .sliced_blocks = {}};
    in.sliced = slice(in.scene.rows);
    in.sliced_blocks = slice(in.scene.blocks);
    std::mt19937 random(2);  // whose numbers the standard fixes
    in.x.resize(in.scene.rows.columns);
    for (float& x : in.x) x = static_cast<float>(static_cast<int>(random() >> 8) - (1 << 23)) / (1 << 23);
    return in;
  });
}

std::shared_ptr<const Factored> factored(const std::string& path) {
  return verify::inputs<Factored>(path, [&] {
    const auto in = inputs(path);
    Factored made;
    made.levels = make_levels(in->scene.rows);
    made.rows = reordered(in->scene.rows, made.levels.order);
    made.sliced = slice(made.rows);
    made.factor = serial::incomplete_cholesky(made.rows, in->scene.modification);
    made.sliced_factor = slice(made.factor, made.levels);
    made.b = reordered(std::span<const float>(in->scene.b), made.levels.order);
    return made;
  });
}

bool is_solvable(const std::string& path) { return inputs(path)->scene.solvable; }
bool has_blocks(const std::string& path) { return inputs(path)->scene.blocks.rows > 0; }

}  // namespace lockstep::verify::linear_inputs
